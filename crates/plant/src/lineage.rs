//! The table `[lineage]` of a file: where a plant comes from.
//!
//! Owns how it is read and written. Those who know no lineage keep it as a table that is not known. Never draws.
//!
//! Start at [`Plant::origin`].

use species::Lineage;
use toml::{Table, Value};

use crate::genome::Plant;

/// The name of the table.
const NAME: &str = "lineage";

impl Plant {
    /// What its file says of its origin.
    pub fn origin(&self) -> Lineage {
        let inline = self.unknown[1].iter().find(|(key, _)| key == NAME).map(|(_, inline)| inline);
        let file: Table = inline.and_then(|it| toml::from_str(&format!("it = {it}")).ok()).unwrap_or_default();
        let table = file.get("it").and_then(Value::as_table).cloned().unwrap_or_default();
        Lineage::of_table(&table)
    }

    /// The same plant with this origin.
    #[must_use]
    pub fn with_origin(&self, lineage: &Lineage) -> Plant {
        let mut plant = self.clone();
        let of_file = &mut plant.unknown[1];
        of_file.retain(|(key, _)| key != NAME);
        let entries = lineage.to_table();
        if !entries.is_empty() {
            of_file.push((NAME.to_owned(), Value::Table(entries).to_string()));
            // As reading orders them.
            of_file.sort();
        }
        plant
    }
}

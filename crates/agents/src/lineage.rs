//! The table `[lineage]` of a file: where a globe comes from.
//!
//! Owns how it is read and written. Those who know no lineage keep it as a table that is not known. Never draws.
//!
//! Start at [`Globe::origin`].

use species::Lineage;
use toml::{Table, Value};

use crate::globe::{Globe, Kept};

/// The name of the table.
const NAME: &str = "lineage";

impl Globe {
    /// What its file says of its origin.
    pub fn origin(&self) -> Lineage {
        let table = table(&self.kept.after).remove(NAME).and_then(|it| it.try_into::<Table>().ok()).unwrap_or_default();
        Lineage::of_table(&table)
    }

    /// The same globe with this origin.
    #[must_use]
    pub fn with_origin(&self, lineage: &Lineage) -> Globe {
        let [mut before, mut after] = [&self.kept.before, &self.kept.after].map(|kept| table(kept));
        for kept in [&mut before, &mut after] {
            kept.remove(NAME);
        }
        let entries = lineage.to_table();
        if !entries.is_empty() {
            after.insert(NAME.to_owned(), Value::Table(entries));
        }
        let [before, after] = [before, after].map(|kept| toml::to_string(&kept).unwrap_or_default());
        Globe { kept: Kept { before, after, ..self.kept.clone() }, ..self.clone() }
    }
}

/// What is kept as text; it was written from a table.
fn table(kept: &str) -> Table {
    toml::from_str(kept).unwrap_or_default()
}

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
/// Its keys that have lists.
const LISTS: [&str; 2] = ["parents", "authors"];

impl Globe {
    /// What its file says of its origin.
    pub fn origin(&self) -> Lineage {
        let table = table(&self.kept.after).remove(NAME).and_then(|it| it.try_into::<Table>().ok()).unwrap_or_default();
        let texts =
            |values: &[Value]| values.iter().filter_map(|value| value.as_str().map(ToOwned::to_owned)).collect();
        Lineage::of_entries(|key| match table.get(key) {
            Some(Value::Array(values)) => texts(values),
            value => value.map(|value| texts(std::slice::from_ref(value))).unwrap_or_default(),
        })
    }

    /// The same globe with this origin.
    #[must_use]
    pub fn with_origin(&self, lineage: &Lineage) -> Globe {
        let [mut before, mut after] = [&self.kept.before, &self.kept.after].map(|kept| table(kept));
        for kept in [&mut before, &mut after] {
            kept.remove(NAME);
        }
        let entries = lineage.entries().into_iter().map(|(key, values)| {
            let mut values = values.into_iter().map(Value::String);
            let value = if LISTS.contains(&key) { None } else { values.next() };
            (key.to_owned(), value.unwrap_or_else(|| Value::Array(values.collect())))
        });
        let entries: Table = entries.collect();
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

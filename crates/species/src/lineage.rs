//! Where a genome comes from.
//!
//! Owns what a genome says of its parents, its authors and its licence, and what a child of several says. Each species
//! writes it in its own format, one generation deep. Never judges whether a licence was given.
//!
//! Start at [`Lineage::of_child`].

use std::slice;

use toml::{Table, Value};

use crate::licence::strictest;

/// The keys that have lists in a table.
const LISTS: [&str; 2] = ["parents", "authors"];

/// What a genome says of its origin. Texts are trimmed and not empty.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Lineage {
    /// Its own id.
    pub id: Option<String>,
    /// The ids of those that it was made of.
    pub parents: Vec<String>,
    /// What made it of them: the name of an operator.
    pub operator: Option<String>,
    /// When, in any form. Nobody but the caller knows it.
    pub date: Option<String>,
    /// Its authors and those of its ancestors: `name` or `name <address>`.
    pub authors: Vec<String>,
    /// The licence, as it is written.
    pub licence: Option<String>,
}

impl Lineage {
    /// What a child of these parents by `operator` says: all their names, and the strictest of their licences. It has no id
    /// and no date yet; parents without an id are left out.
    pub fn of_child(operator: &str, parents: &[Lineage]) -> Lineage {
        let mut authors: Vec<String> = Vec::new();
        for author in parents.iter().flat_map(|parent| &parent.authors) {
            if !authors.contains(author) {
                authors.push(author.clone());
            }
        }
        let licences = parents.iter().map(|parent| parent.licence.clone());
        Lineage {
            id: None,
            parents: parents.iter().filter_map(|parent| parent.id.clone()).collect(),
            operator: Some(operator.to_owned()),
            date: None,
            authors,
            licence: licences.reduce(|a, b| strictest(a.as_deref(), b.as_deref())).flatten(),
        }
    }

    /// All that is known, each by its key, in the order in which it is written. What has one value has it alone.
    pub fn entries(&self) -> Vec<(&'static str, Vec<String>)> {
        let one = |value: &Option<String>| value.iter().cloned().collect::<Vec<String>>();
        let all = [
            ("id", one(&self.id)),
            ("date", one(&self.date)),
            ("operator", one(&self.operator)),
            ("parents", self.parents.clone()),
            ("authors", self.authors.clone()),
            ("licence", one(&self.licence)),
        ];
        all.into_iter().filter(|(_, values)| !values.is_empty()).collect()
    }

    /// The same as a table of TOML, for files that are in that format.
    pub fn to_table(&self) -> Table {
        let entries = self.entries().into_iter().map(|(key, values)| {
            let mut values = values.into_iter().map(Value::String);
            let value = if LISTS.contains(&key) { None } else { values.next() };
            (key.to_owned(), value.unwrap_or_else(|| Value::Array(values.collect())))
        });
        entries.collect()
    }

    /// The lineage in a table of TOML; what is no text is left out.
    pub fn of_table(table: &Table) -> Lineage {
        let texts =
            |values: &[Value]| values.iter().filter_map(|value| value.as_str().map(ToOwned::to_owned)).collect();
        Lineage::of_entries(|key| match table.get(key) {
            Some(Value::Array(values)) => texts(values),
            value => value.map(|value| texts(slice::from_ref(value))).unwrap_or_default(),
        })
    }

    /// The lineage of which `values` tells the values of a key; nothing for a key that is not there.
    pub fn of_entries(values: impl Fn(&str) -> Vec<String>) -> Lineage {
        let all = |key: &str| -> Vec<String> {
            let values = values(key).into_iter().map(|value| value.trim().to_owned());
            values.filter(|value| !value.is_empty()).collect()
        };
        let one = |key: &str| all(key).into_iter().next();
        Lineage {
            id: one("id"),
            parents: all("parents"),
            operator: one("operator"),
            date: one("date"),
            authors: all("authors"),
            licence: one("licence"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lineage(id: &str, authors: &[&str], licence: Option<&str>) -> Lineage {
        let authors = authors.iter().map(ToString::to_string).collect();
        Lineage { id: Some(id.into()), authors, licence: licence.map(Into::into), ..Lineage::default() }
    }

    #[test]
    fn a_child_has_all_names_and_the_strictest_licence_of_its_parents() {
        let parents =
            [lineage("7.1", &["ann", "bob <b.example>"], Some("CC-BY-4.0")), lineage("7.2", &["ann"], Some("CC0-1.0"))];
        let child = Lineage::of_child("union", &parents);
        assert_eq!(child.parents, ["7.1", "7.2"]);
        assert_eq!(child.authors, ["ann", "bob <b.example>"]);
        assert_eq!((child.licence.as_deref(), child.operator.as_deref()), (Some("CC-BY-4.0"), Some("union")));
        assert_eq!((child.id, child.date), (None, None));
        let without = Lineage::of_child("union", &[parents[0].clone(), lineage("7.3", &[], None)]);
        assert_eq!(without.licence, None, "what has no licence is not covered by another's");
    }

    #[test]
    fn entries_read_back() {
        let whole = Lineage {
            id: Some("8.1".into()),
            parents: vec!["7.1".into(), "7.2".into()],
            operator: Some("union".into()),
            date: Some("2026-11-25".into()),
            ..lineage("8.1", &["ann", "bob"], Some("MIT"))
        };
        for lineage in [whole, Lineage::default()] {
            let entries = lineage.entries();
            let values = |key: &str| entries.iter().find(|(other, _)| *other == key).map(|(_, values)| values.clone());
            assert_eq!(Lineage::of_entries(|key| values(key).unwrap_or_default()), lineage);
        }
    }
}

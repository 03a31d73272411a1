//! The form `(lineage ...)` of a file: where a genome comes from.
//!
//! Owns how it is read and written. Those who know no lineage keep it as a form that is not known. Never draws.
//!
//! Start at [`Genome::origin`].

use std::fmt::Write as _;

use ::species::Lineage;

use crate::form::{Form, Kind, read};
use crate::genome::Genome;
use crate::writer::quoted;

/// The name of the form.
const NAME: &str = "lineage";

impl Genome {
    /// What its file says of its origin.
    pub fn origin(&self) -> Lineage {
        let Some(form) = self.unknown.iter().find_map(|form| read(form).ok().filter(is_lineage)) else {
            return Lineage::default();
        };
        let entries = form.call().map(|(_, entries)| entries).unwrap_or_default();
        let text = |value: &Form<'_>| match &value.kind {
            Kind::Text(text) => Some(text.clone()),
            Kind::Atom | Kind::List(_) | Kind::Vector(_) => None,
        };
        Lineage::of_entries(|key| {
            let mut of_key = entries.iter().filter_map(Form::call).filter(|(head, _)| head.text == key);
            of_key.next().map(|(_, values)| values.iter().filter_map(text).collect()).unwrap_or_default()
        })
    }

    /// The same genome with this origin.
    #[must_use]
    pub fn with_origin(&self, lineage: &Lineage) -> Genome {
        let mut genome = self.clone();
        genome.unknown.retain(|form| !read(form).is_ok_and(|form| is_lineage(&form)));
        let mut form = format!("({NAME}");
        for (key, values) in lineage.entries() {
            let values: Vec<String> = values.iter().map(|value| quoted(value)).collect();
            write!(form, " ({key} {})", values.join(" ")).expect("a text takes what is written");
        }
        if *lineage != Lineage::default() {
            genome.unknown.push(form + ")");
        }
        genome
    }
}

fn is_lineage(form: &Form<'_>) -> bool {
    form.call().is_some_and(|(head, _)| head.text == NAME)
}

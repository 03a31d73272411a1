//! An entry of `credits.toml`.
//!
//! Owns what is said of a sheep or a transition, and how a new entry is written. Never reads the file.

use std::fmt;
use std::ops::Range;

use flock::SheepId;

use super::licence::Licence;

/// A sheep with its loop and its genome, or a transition.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Subject {
    /// This sheep.
    Sheep(SheepId),
    /// The transition from the one to the other.
    Transition(SheepId, SheepId),
}

/// What an entry says; `None` where it says nothing.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Said {
    /// Who made it.
    pub authors: Option<Vec<String>>,
    /// What it is under.
    pub licence: Option<Licence>,
    /// What it was imported from: a file, or the name that Electric Sheep has for it.
    pub source: Option<String>,
    /// What it was bred from, of a sheep.
    pub parents: Option<Vec<String>>,
    /// A sentence that whoever shows it has to say.
    pub attribution: Option<String>,
}

/// An entry, with its places in the text.
#[derive(Debug)]
pub(super) struct Entry {
    pub(super) said: Said,
    /// From its header to its last key.
    pub(super) lines: Range<usize>,
    /// The values of `id`, or of `from` and `to`.
    pub(super) ids: Vec<Range<usize>>,
}

impl Subject {
    /// The sheep that it names.
    pub(super) fn ids(&self) -> Vec<&SheepId> {
        match self {
            Self::Sheep(id) => vec![id],
            Self::Transition(from, to) => vec![from, to],
        }
    }

    /// The lines of a new entry.
    pub(super) fn table(&self, said: &Said) -> Vec<String> {
        let pair = |key: &str, text: &str| format!("{key} = {}", quoted(text));
        let list = |key: &str, texts: &[String]| {
            let texts: Vec<String> = texts.iter().map(|text| quoted(text)).collect();
            format!("{key} = [{}]", texts.join(", "))
        };
        let mut lines = match self {
            Self::Sheep(id) => vec!["[[sheep]]".to_owned(), pair("id", id.as_str())],
            Self::Transition(from, to) => {
                vec!["[[transition]]".to_owned(), pair("from", from.as_str()), pair("to", to.as_str())]
            }
        };
        let Said { authors, licence, source, parents, attribution } = said;
        lines.extend(authors.iter().map(|authors| list("authors", authors)));
        lines.extend(licence.iter().map(|licence| pair("licence", licence.as_str())));
        lines.extend(source.iter().map(|source| pair("source", source)));
        lines.extend(parents.iter().map(|parents| list("parents", parents)));
        lines.extend(attribution.iter().map(|attribution| pair("attribution", attribution)));
        lines
    }
}

impl Said {
    /// Whether it says nothing.
    pub(super) fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

impl fmt::Display for Subject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sheep(id) => write!(f, "sheep `{id}`"),
            Self::Transition(from, to) => write!(f, "the transition from `{from}` to `{to}`"),
        }
    }
}

/// `text` as TOML writes it.
pub(super) fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

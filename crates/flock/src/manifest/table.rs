//! Reading of TOML tables by key, with errors that name file, line and key.
//!
//! Owns the errors of a manifest and the reader of tables. The keys are defined in `mod.rs`.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use diagnostics::did_you_mean;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::excerpt::excerpt;
use super::names::NameError;
use super::plain::{Block, PlainEntry, Scalar};

/// Why a manifest was not read.
#[derive(Debug, thiserror::Error)]
pub enum ManifestError {
    /// A required key is missing.
    #[error("`{path}`, line {line}: the key `{key}` is missing from {table}")]
    Missing {
        /// The file.
        path: PathBuf,
        /// Where the table starts, from 1.
        line: usize,
        /// The key.
        key: &'static str,
        /// The table, as in the file.
        table: &'static str,
        /// A key of the table that may be meant to be it.
        similar: Option<String>,
    },
    /// Too much of it is not in the plain form, which needs more memory than a unit has.
    #[error(
        "`{path}`, line {line}: not in the plain form that `dreams` writes, so {limit} bytes at most are read; found {bytes}"
    )]
    NotPlain {
        /// The file.
        path: PathBuf,
        /// The first that is not plain, from 1.
        line: usize,
        /// The bytes that would have to be parsed as a TOML document.
        bytes: u64,
        /// How many a unit reads so.
        limit: u64,
    },
    /// The file could not be read.
    #[error("cannot read `{path}`")]
    Read {
        /// The file.
        path: PathBuf,
        /// The system error.
        source: std::io::Error,
    },
    /// The file is not TOML.
    #[error("`{path}`, line {line}, key `{key}`: not TOML: {message}")]
    Syntax {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// The text before the `=` of that line, or the whole line.
        key: String,
        /// The message of the parser.
        message: String,
    },
    /// Larger than a unit's memory allows.
    #[error("`{path}` is too large: {bytes} bytes, a unit reads {limit} at most")]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// How many it has.
        bytes: u64,
        /// How many a unit reads.
        limit: u64,
    },
    /// A key that no table of that kind has.
    #[error("`{path}`, line {line}: unknown key `{key}` in {table}, which has {}", quoted(.known))]
    UnknownKey {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// The key as found.
        key: String,
        /// The table, as in the file.
        table: &'static str,
        /// The keys it may have.
        known: Vec<&'static str>,
    },
    /// A value that the key cannot have.
    #[error("`{path}`, line {line}, key `{key}`: wanted {wanted}, found {found}")]
    Value {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// The key.
        key: &'static str,
        /// The expected value.
        wanted: String,
        /// The value found.
        found: String,
    },
}

impl ManifestError {
    /// A hint for the user.
    pub fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::Missing { key, similar: Some(similar), .. } => {
                return Some(format!("there is `{similar}`: did you mean `{key}`?"));
            }
            Self::UnknownKey { key, known, .. } => return did_you_mean(key, known.iter().copied()),
            Self::Read { source, .. } if source.kind() == std::io::ErrorKind::NotFound => {
                Some("a flock is a folder with a file `flock.toml`")
            }
            Self::Missing { key: "sheep", .. } => Some("a flock has at least one; `dreams add` puts it in"),
            Self::NotPlain { .. } => {
                Some("plain are one `key = value` a line under `[[sheep]]` and `[[transition]]`, lines end in `\\n`")
            }
            Self::TooLarge { .. } => Some("several smaller flocks, one for each unit, show the same"),
            Self::Missing { .. } | Self::Read { .. } | Self::Syntax { .. } | Self::Value { .. } => None,
        };
        hint.map(ToOwned::to_owned)
    }
}

fn quoted(words: &[&str]) -> String {
    words.iter().map(|word| format!("`{word}`")).collect::<Vec<_>>().join(", ")
}

/// Most keys that a table has.
pub(crate) const MAX_KEYS: usize = 8;

/// A table of the file, read by key. Keys that are left at [`Table::finish`] are unknown.
pub(crate) struct Table<'t, 'i> {
    source: Source<'t>,
    name: &'static str,
    /// Where it starts, in bytes from the start of the text.
    at: usize,
    entries: Entries<'t, 'i>,
    /// The keys that were read: the first `count` of these.
    asked: [&'static str; MAX_KEYS],
    count: usize,
}

/// The contents of a table, by how it was parsed.
enum Entries<'t, 'i> {
    Parsed(&'t DeTable<'i>),
    Plain(&'t [PlainEntry<'t>]),
}

/// A value and its position.
#[derive(Clone)]
pub(crate) struct Entry<'t, 'i> {
    source: Source<'t>,
    key: &'static str,
    value: Value<'t, 'i>,
}

#[derive(Clone)]
enum Value<'t, 'i> {
    Parsed(&'t Spanned<DeValue<'i>>),
    Plain(PlainEntry<'t>),
}

/// The text a table came from.
#[derive(Clone, Copy)]
pub(crate) struct Source<'t> {
    pub(crate) path: &'t Path,
    pub(crate) text: &'t str,
}

impl Source<'_> {
    fn line(&self, at: usize) -> usize {
        1 + self.text.char_indices().take_while(|&(start, _)| start < at).filter(|&(_, c)| c == '\n').count()
    }

    /// The error of a text that is not plain at byte `at`, of which `bytes` would have to be read as a document.
    pub(crate) fn not_plain(&self, at: usize, bytes: u64, limit: u64) -> ManifestError {
        ManifestError::NotPlain { path: self.path.to_owned(), line: self.line(at), bytes, limit }
    }

    /// The error of a text that is not TOML.
    pub(crate) fn syntax(&self, error: &toml::de::Error) -> ManifestError {
        let line = self.line(error.span().map_or(0, |span| span.start));
        let text = self.text.lines().nth(line - 1).unwrap_or_default();
        let key = excerpt(text.split('=').next().unwrap_or_default().trim());
        ManifestError::Syntax { path: self.path.to_owned(), line, key, message: error.message().replace('\n', ", ") }
    }
}

impl<'t, 'i> Table<'t, 'i> {
    /// The table that the TOML parser found.
    pub(crate) fn new(source: Source<'t>, name: &'static str, table: &'t Spanned<DeTable<'i>>) -> Self {
        Self::of(source, name, table.span().start, Entries::Parsed(table.get_ref()))
    }

    /// A table in plain form.
    pub(crate) fn plain(source: Source<'t>, name: &'static str, block: &'t Block<'t>) -> Self {
        Self::of(source, name, block.at, Entries::Plain(&block.entries))
    }

    fn of(source: Source<'t>, name: &'static str, at: usize, entries: Entries<'t, 'i>) -> Self {
        Self { source, name, at, entries, asked: [""; MAX_KEYS], count: 0 }
    }

    /// The value of `key`, if there is one.
    pub(crate) fn optional(&mut self, key: &'static str) -> Option<Entry<'t, 'i>> {
        self.asked[self.count] = key;
        self.count += 1;
        let value = match self.entries {
            Entries::Parsed(entries) => Value::Parsed(entries.get(key)?),
            Entries::Plain(entries) => Value::Plain(*entries.iter().find(|entry| entry.key == key)?),
        };
        Some(Entry { source: self.source, key, value })
    }

    /// The value of `key`.
    pub(crate) fn required(&mut self, key: &'static str) -> Result<Entry<'t, 'i>, ManifestError> {
        self.optional(key).ok_or_else(|| self.missing(key))
    }

    /// The error of a missing `key`.
    pub(crate) fn missing(&self, key: &'static str) -> ManifestError {
        let (path, line) = (self.source.path.to_owned(), self.source.line(self.at));
        let is_similar = |found: &&str| !self.asked.contains(found) && did_you_mean(found, [key]).is_some();
        let similar = match self.entries {
            Entries::Parsed(entries) => entries.keys().map(|key| key.get_ref().as_ref()).find(is_similar),
            Entries::Plain(entries) => entries.iter().map(|entry| entry.key).find(is_similar),
        };
        ManifestError::Missing { path, line, key, table: self.name, similar: similar.map(excerpt) }
    }

    /// The error of keys that were not read, if there are any.
    pub(crate) fn finish(self) -> Result<(), ManifestError> {
        let asked = &self.asked[..self.count];
        let unknown = |key: &str| !asked.contains(&key);
        let found = match self.entries {
            Entries::Parsed(entries) => {
                let keys = entries.keys().map(|key| (key.span().start, key.get_ref().as_ref()));
                keys.filter(|&(_, key)| unknown(key)).min()
            }
            Entries::Plain(entries) => entries.iter().map(|entry| (entry.at, entry.key)).find(|&(_, key)| unknown(key)),
        };
        let Some((at, key)) = found else { return Ok(()) };
        let known = asked.to_vec();
        let (path, line) = (self.source.path.to_owned(), self.source.line(at));
        Err(ManifestError::UnknownKey { path, line, key: excerpt(key), table: self.name, known })
    }
}

impl<'t, 'i> Entry<'t, 'i> {
    /// The error of a value that is not `wanted`.
    pub(crate) fn refused(&self, wanted: impl Into<String>) -> ManifestError {
        let found = self.source.text.get(self.span()).unwrap_or_default();
        self.error(wanted.into(), format!("`{}`", excerpt(found.lines().next().unwrap_or_default())))
    }

    /// A checked name.
    pub(crate) fn name<T>(&self, parse: impl FnOnce(&str) -> Result<T, NameError>) -> Result<T, ManifestError> {
        let text = self.text()?;
        parse(text).map_err(|error| {
            let said = error.to_string();
            let (wanted, found) = said.rsplit_once(", found ").unwrap_or((&said, text));
            let wanted = wanted.trim_start_matches("wanted ").to_owned();
            self.error(wanted, excerpt(found))
        })
    }

    /// Any text.
    pub(crate) fn text(&self) -> Result<&'t str, ManifestError> {
        let text = match &self.value {
            Value::Parsed(value) => value.get_ref().as_str(),
            Value::Plain(PlainEntry { value: Scalar::Text(text), .. }) => Some(*text),
            Value::Plain(PlainEntry { value: Scalar::Number(_), .. }) => None,
        };
        text.ok_or_else(|| self.refused("a text in quotes"))
    }

    /// A whole number from `least` to `most`.
    pub(crate) fn whole(&self, least: u32, most: u32) -> Result<u32, ManifestError> {
        let number = match &self.value {
            Value::Parsed(value) => whole(value.get_ref()),
            Value::Plain(entry) => plain_number::<u32>(entry),
        };
        number
            .filter(|n| (least..=most).contains(n))
            .ok_or_else(|| self.refused(if least == most { format!("`{least}`") } else { range(least, most) }))
    }

    /// Two whole numbers.
    pub(crate) fn pair(&self) -> Result<(u32, u32), ManifestError> {
        let pair = || match &self.value {
            Value::Parsed(value) => {
                let array = value.get_ref().as_array().filter(|array| array.len() == 2)?;
                let number = |at: usize| array.get(at).and_then(|value| whole(value.get_ref()));
                Some((number(0)?, number(1)?))
            }
            Value::Plain(_) => None,
        };
        pair().ok_or_else(|| self.refused("two whole numbers in brackets"))
    }

    /// A finite number above 0.
    pub(crate) fn positive(&self) -> Result<f64, ManifestError> {
        let number = match &self.value {
            Value::Parsed(value) => number(value.get_ref()),
            Value::Plain(entry) => plain_number::<f64>(entry),
        };
        number.filter(|n| n.is_normal() && *n > 0.0).ok_or_else(|| self.refused("a finite number above 0"))
    }

    /// The tables of `[[key]]`.
    pub(crate) fn tables(&self, name: &'static str) -> Result<Vec<Table<'t, 'i>>, ManifestError> {
        let refused = || self.refused(format!("tables, each headed {name}"));
        let Value::Parsed(value) = &self.value else { return Err(refused()) };
        let table = |value: &'t Spanned<DeValue<'i>>| match value.get_ref().as_table() {
            Some(entries) => Ok(Table::of(self.source, name, value.span().start, Entries::Parsed(entries))),
            None => Err(refused()),
        };
        value.get_ref().as_array().ok_or_else(refused)?.iter().map(table).collect()
    }

    fn span(&self) -> Range<usize> {
        match &self.value {
            Value::Parsed(value) => value.span(),
            Value::Plain(PlainEntry { at, value: Scalar::Number(number), .. }) => *at..at + number.len(),
            Value::Plain(PlainEntry { at, value: Scalar::Text(text), .. }) => *at..at + text.len() + 2,
        }
    }

    fn error(&self, wanted: String, found: String) -> ManifestError {
        let (path, line) = (self.source.path.to_owned(), self.source.line(self.span().start));
        ManifestError::Value { path, line, key: self.key, wanted, found }
    }
}

fn range(least: u32, most: u32) -> String {
    format!("a whole number from {least} to {most}")
}

fn whole(value: &DeValue<'_>) -> Option<u32> {
    let integer = value.as_integer()?;
    u32::from_str_radix(integer.as_str(), integer.radix()).ok()
}

fn number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(integer) => i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|n| n as f64),
        DeValue::String(_) | DeValue::Boolean(_) | DeValue::Datetime(_) | DeValue::Array(_) | DeValue::Table(_) => None,
    }
}

fn plain_number<T: FromStr>(entry: &PlainEntry<'_>) -> Option<T> {
    match entry.value {
        Scalar::Number(number) => number.parse().ok(),
        Scalar::Text(_) => None,
    }
}

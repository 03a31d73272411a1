//! Reading a TOML table key by key, so that every refusal names file, line and key.
//!
//! Owns the errors of a manifest and the small reader that makes them. Never knows which keys a flock has:
//! `manifest.rs` does.

use std::ops::Range;
use std::path::{Path, PathBuf};

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::names::NameError;

/// Why a manifest was not read.
#[derive(Debug, thiserror::Error)]
pub enum ManifestError {
    /// A key that must stand there and does not.
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
    },
    /// The file could not be read.
    #[error("cannot read `{path}`")]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is not TOML.
    #[error("`{path}`, line {line}, key `{key}`: not TOML: {message}")]
    Syntax {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// What stands before the `=` of that line, or the whole line.
        key: String,
        /// What the parser said.
        message: String,
    },
    /// A key that no table of that kind has.
    #[error("`{path}`, line {line}: unknown key `{key}` in {table}, which has {known}")]
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
        known: String,
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
        /// What may stand there.
        wanted: String,
        /// What stands there.
        found: String,
    },
}

impl ManifestError {
    /// What to do about it.
    pub fn hint(&self) -> Option<&'static str> {
        match self {
            Self::Read { source, .. } if source.kind() == std::io::ErrorKind::NotFound => {
                Some("a flock is a folder with a file `flock.toml`")
            }
            Self::Missing { .. }
            | Self::Read { .. }
            | Self::Syntax { .. }
            | Self::UnknownKey { .. }
            | Self::Value { .. } => None,
        }
    }
}

/// One table of the file, read key by key. What is left at [`Table::finish`] is unknown.
pub(crate) struct Table<'t, 'i> {
    source: Source<'t>,
    name: &'static str,
    at: Range<usize>,
    entries: &'t DeTable<'i>,
    asked: Vec<&'static str>,
}

/// A value and where it stands.
#[derive(Clone)]
pub(crate) struct Entry<'t, 'i> {
    source: Source<'t>,
    key: &'static str,
    value: &'t Spanned<DeValue<'i>>,
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

    /// The error of a text that is no TOML.
    pub(crate) fn syntax(&self, error: &toml::de::Error) -> ManifestError {
        let line = self.line(error.span().map_or(0, |span| span.start));
        let text = self.text.lines().nth(line - 1).unwrap_or_default();
        let key = text.split('=').next().unwrap_or_default().trim().to_owned();
        ManifestError::Syntax { path: self.path.to_owned(), line, key, message: error.message().replace('\n', ", ") }
    }
}

impl<'t, 'i> Table<'t, 'i> {
    pub(crate) fn new(source: Source<'t>, name: &'static str, table: &'t Spanned<DeTable<'i>>) -> Self {
        Self { source, name, at: table.span(), entries: table.get_ref(), asked: Vec::new() }
    }

    /// The value of `key`, if it stands there.
    pub(crate) fn optional(&mut self, key: &'static str) -> Option<Entry<'t, 'i>> {
        self.asked.push(key);
        let value = self.entries.get(key)?;
        Some(Entry { source: self.source, key, value })
    }

    /// The value of `key`.
    pub(crate) fn required(&mut self, key: &'static str) -> Result<Entry<'t, 'i>, ManifestError> {
        self.optional(key).ok_or_else(|| self.missing(key))
    }

    /// The error of a `key` that had to stand here.
    pub(crate) fn missing(&self, key: &'static str) -> ManifestError {
        let (path, line) = (self.source.path.to_owned(), self.source.line(self.at.start));
        ManifestError::Missing { path, line, key, table: self.name }
    }

    /// Refuses keys that were not asked for.
    pub(crate) fn finish(self) -> Result<(), ManifestError> {
        let mut unknown: Vec<_> =
            self.entries.keys().filter(|key| !self.asked.contains(&key.get_ref().as_ref())).collect();
        unknown.sort_by_key(|key| key.span().start);
        let Some(key) = unknown.first() else { return Ok(()) };
        let known = self.asked.iter().map(|key| format!("`{key}`")).collect::<Vec<_>>().join(", ");
        Err(ManifestError::UnknownKey {
            path: self.source.path.to_owned(),
            line: self.source.line(key.span().start),
            key: key.get_ref().to_string(),
            table: self.name,
            known,
        })
    }
}

impl<'t, 'i> Entry<'t, 'i> {
    /// The error of a value that is not `wanted`.
    pub(crate) fn refused(&self, wanted: impl Into<String>) -> ManifestError {
        let span = self.value.span();
        let found = self.source.text.get(span.clone()).unwrap_or_default();
        let found = found.lines().next().unwrap_or_default();
        self.error(span.start, wanted.into(), format!("`{found}`"))
    }

    /// A checked name.
    pub(crate) fn name<T>(&self, parse: impl Fn(&str) -> Result<T, NameError>) -> Result<T, ManifestError> {
        let text = self.text()?;
        parse(text).map_err(|error| {
            let said = error.to_string();
            let (wanted, found) = said.rsplit_once(", found ").unwrap_or((&said, text));
            let wanted = wanted.trim_start_matches("wanted ").to_owned();
            self.error(self.value.span().start, wanted, found.to_owned())
        })
    }

    /// Any text.
    pub(crate) fn text(&self) -> Result<&'t str, ManifestError> {
        self.value.get_ref().as_str().ok_or_else(|| self.refused("a text in quotes"))
    }

    /// A whole number from `least` to `most`.
    pub(crate) fn whole(&self, least: u32, most: u32) -> Result<u32, ManifestError> {
        whole(self.value.get_ref())
            .filter(|n| (least..=most).contains(n))
            .ok_or_else(|| self.refused(if least == most { format!("`{least}`") } else { range(least, most) }))
    }

    /// Two whole numbers.
    pub(crate) fn pair(&self) -> Result<(u32, u32), ManifestError> {
        let pair = self.value.get_ref().as_array().filter(|array| array.len() == 2).and_then(|array| {
            let number = |at: usize| array.get(at).and_then(|value| whole(value.get_ref()));
            Some((number(0)?, number(1)?))
        });
        pair.ok_or_else(|| self.refused("two whole numbers in brackets"))
    }

    /// A finite number above 0.
    pub(crate) fn positive(&self) -> Result<f64, ManifestError> {
        let number = match self.value.get_ref() {
            DeValue::Float(float) => float.as_str().parse::<f64>().ok(),
            DeValue::Integer(_) => whole(self.value.get_ref()).map(f64::from),
            DeValue::String(_) | DeValue::Boolean(_) | DeValue::Datetime(_) | DeValue::Array(_) | DeValue::Table(_) => {
                None
            }
        };
        number.filter(|n| n.is_normal() && *n > 0.0).ok_or_else(|| self.refused("a finite number above 0"))
    }

    /// The tables of `[[key]]`.
    pub(crate) fn tables(&self, name: &'static str) -> Result<Vec<Table<'t, 'i>>, ManifestError> {
        let Some(array) = self.value.get_ref().as_array() else {
            return Err(self.refused(format!("tables, each headed {name}")));
        };
        let table = |value: &'t Spanned<DeValue<'i>>| match value.get_ref().as_table() {
            Some(entries) => Ok(Table { source: self.source, name, at: value.span(), entries, asked: Vec::new() }),
            None => Err(self.refused(format!("tables, each headed {name}"))),
        };
        array.iter().map(table).collect()
    }

    fn error(&self, at: usize, wanted: String, found: String) -> ManifestError {
        let (path, line) = (self.source.path.to_owned(), self.source.line(at));
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

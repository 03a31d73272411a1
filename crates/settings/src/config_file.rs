//! Settings in a file of TOML.
//!
//! Owns the reading, and errors with file, line and key. Never knows a key: each program has its own, in `config.rs`.

use bundle::UnitId;
use diagnostics::did_you_mean;
use serde::Deserialize;
use serde::de::{DeserializeOwned, Deserializer, Error as _, Unexpected};
use std::io;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// Bytes that are read, at most: a person's words, and no more. As a TOML document they take up to 560 times as many.
pub const LARGEST: u64 = bundle::limits::SETTINGS;

/// How serde's messages begin that are about keys, not values.
const UNKNOWN: &str = "unknown field";
const TWICE: &str = "duplicate key";

/// Why settings were refused.
#[derive(Debug, thiserror::Error)]
pub enum ConfigError {
    /// The text is no config: an unknown key, a value out of range, no TOML.
    #[error("`{path}` line {line}, key `{key}`: {message}", path = path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// From 1.
        line: usize,
        /// The key of that line.
        key: String,
        /// What is wrong with it.
        message: String,
        /// Of which kind that is.
        mistake: Mistake,
    },
    /// The file cannot be read.
    #[error("cannot read config `{path}`", path = path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the file system says.
        source: io::Error,
    },
}

/// What may be wrong with a line of settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mistake {
    /// The setting is for another, which is not set.
    Alone {
        /// What it is for.
        needs: &'static str,
    },
    /// The key is set a second time.
    Twice,
    /// There is no such key, in this version.
    Unknown,
    /// The value is not one of those that the key can have, or the line is not in the form of TOML.
    Value,
}

/// Has serde read settings from a string, as [`FromStr`](std::str::FromStr) does, whose error is named first.
#[macro_export]
macro_rules! from_string {
    ($error:ty: $($setting:ty),*) => {$(
        impl TryFrom<String> for $setting {
            type Error = $error;

            fn try_from(text: String) -> Result<Self, $error> {
                text.parse()
            }
        }
    )*};
}

/// Makes functions for serde's `deserialize_with`, each of which reads a number that lies in a range.
#[macro_export]
macro_rules! ranged {
    ($($name:ident -> $number:ty: $range:ident;)*) => {$(
        fn $name<'de, D: serde::Deserializer<'de>>(from: D) -> Result<$number, D::Error> {
            $crate::config_file::within(from, &$range)
        }
    )*};
}

/// Reads the name of a unit.
/// Errors: The deserializer's, with what it is not.
pub fn unit<'de, D: Deserializer<'de>>(from: D) -> Result<Option<UnitId>, D::Error> {
    UnitId::new(&String::deserialize(from)?).map(Some).map_err(D::Error::custom)
}

/// Reads a number that lies in `range`.
/// Errors: The deserializer's, with the number and both ends of the range.
pub fn within<'de, D: Deserializer<'de>, T: From<u64>>(from: D, range: &RangeInclusive<u64>) -> Result<T, D::Error> {
    let number = i64::deserialize(from)?;
    u64::try_from(number).ok().filter(|number| range.contains(number)).map(T::from).ok_or_else(|| {
        let expected = format!("a number from {} to {}", range.start(), range.end());
        D::Error::invalid_value(Unexpected::Signed(number), &expected.as_str())
    })
}

/// Reads the settings in the file at `path`. What it does not name keeps its default.
/// Errors: [`ConfigError`], with line and key.
pub fn load<C: DeserializeOwned>(path: &Path) -> Result<C, ConfigError> {
    parse(path, &text_of(path)?)
}

/// The text of the file of settings at `path`.
/// Errors: [`ConfigError::Read`], also if it is longer than settings may be, or no text.
pub fn text_of(path: &Path) -> Result<String, ConfigError> {
    durable::read_plain_text(path, LARGEST).map_err(|source| ConfigError::Read { path: path.to_owned(), source })
}

/// The key that `line` begins with, or the table in brackets; nothing if there is none, for it may be a secret that stands
/// there instead.
fn key_of(line: &str) -> &str {
    let line = line.trim_start();
    let start = line.trim_start_matches('[');
    let (key, rest) =
        start.split_at(start.find(|c: char| !c.is_ascii_alphanumeric() && !"_-.".contains(c)).unwrap_or(start.len()));
    let ends: &[char] = if start.len() < line.len() { &[']'] } else { &['=', ':'] };
    if rest.trim_start().starts_with(ends) { key } else { "" }
}

/// Reads the settings in `text`, which errors say lies at `path`.
/// Errors: [`ConfigError::Malformed`].
pub fn parse<C: DeserializeOwned>(path: &Path, text: &str) -> Result<C, ConfigError> {
    toml::from_str(text).map_err(|error: toml::de::Error| {
        let at = error.span().map_or(0, |span| span.start);
        let line = text[..at].matches('\n').count() + 1;
        let key = key_of(text.lines().nth(line - 1).unwrap_or_default());
        let message = error.message().trim();
        ConfigError::Malformed {
            path: path.to_owned(),
            line,
            key: key.to_owned(),
            message: with_similar(message).replace(char::is_control, " "),
            mistake: mistake_of(message),
        }
    })
}

/// What serde's `message` is about.
fn mistake_of(message: &str) -> Mistake {
    let kinds = [(UNKNOWN, Mistake::Unknown), (TWICE, Mistake::Twice)];
    kinds.into_iter().find(|(begins, _)| message.starts_with(begins)).map_or(Mistake::Value, |(_, mistake)| mistake)
}

/// serde's `message`; if it is about an unknown key, with the known one that is meant.
fn with_similar(message: &str) -> String {
    let mut words = message.split('`').skip(1).step_by(2);
    let similar = words.next().filter(|_| message.starts_with(UNKNOWN)).and_then(|key| did_you_mean(key, words));
    similar.map_or_else(|| message.to_owned(), |question| format!("{message}; {question}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_that_is_mistyped_is_proposed_as_it_is_meant() {
        let message = "unknown field `hour`, expected one of `unit`, `hours`, `wifi`";
        assert_eq!(with_similar(message), format!("{message}; did you mean `hours`?"));
        for other in ["unknown field `colour`, expected `unit`", "invalid value: integer `1`, expected `2`"] {
            assert_eq!(with_similar(other), other);
        }
    }

    #[test]
    fn a_mistake_is_told_from_the_others() {
        #[derive(Debug, Deserialize)]
        #[serde(deny_unknown_fields)]
        struct Settings {
            #[serde(rename = "hours")]
            _hours: u8,
        }
        let read = |text: &str| match parse::<Settings>(Path::new("a.toml"), text).unwrap_err() {
            ConfigError::Malformed { line, key, mistake, .. } => (line, key, mistake),
            ConfigError::Read { .. } => panic!("nothing is read"),
        };
        for (text, wanted) in [
            ("hours = 1\nhour = 1", (2, "hour", Mistake::Unknown)),
            ("hours = 1\n[night.a]\nhours = 2", (2, "night.a", Mistake::Unknown)),
            ("hours = 1\n\nhours = 1", (3, "hours", Mistake::Twice)),
            ("hours = 256", (1, "hours", Mistake::Value)),
            ("hours = eight", (1, "hours", Mistake::Value)),
            ("hours = 1\n[a secret", (2, "", Mistake::Value)),
        ] {
            assert_eq!(read(text), (wanted.0, wanted.1.to_owned(), wanted.2), "{text}");
        }
    }
}

//! Which log lines are kept.
//!
//! Owns the spelling of the levels. Never writes a line.

use serde::Deserialize;
use std::str::FromStr;

/// The least urgent log line that is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(try_from = "String")]
pub struct LogLevel(pub tracing::Level);

/// Why a log level was refused.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is no log level: `error`, `warn`, `info`, `debug` or `trace`")]
pub struct NoLogLevel(String);

impl FromStr for LogLevel {
    type Err = NoLogLevel;

    fn from_str(text: &str) -> Result<Self, NoLogLevel> {
        let known = ["error", "warn", "info", "debug", "trace"].contains(&text);
        let level = text.parse().ok().filter(|_| known);
        level.map(Self).ok_or_else(|| NoLogLevel(text.to_owned()))
    }
}

impl TryFrom<String> for LogLevel {
    type Error = NoLogLevel;

    fn try_from(text: String) -> Result<Self, NoLogLevel> {
        text.parse()
    }
}

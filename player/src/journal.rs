//! Where log lines go: the journal on a unit, the terminal elsewhere.
//!
//! Owns the subscriber, and the spelling of the levels. Never writes a line itself.

use serde::Deserialize;
use std::env;
use std::io::{self, IsTerminal};
use std::str::FromStr;
use tracing::level_filters::LevelFilter;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;

/// The least urgent log line that is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(try_from = "String")]
pub struct LogLevel(pub tracing::Level);

/// Why a log level was refused.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not a valid log level: `error`, `warn`, `info`, `debug` or `trace`")]
pub struct NoLogLevel(String);

impl FromStr for LogLevel {
    type Err = NoLogLevel;

    fn from_str(text: &str) -> Result<Self, NoLogLevel> {
        let known = ["error", "warn", "info", "debug", "trace"].contains(&text);
        let level = text.parse().ok().filter(|_| known);
        level.map(Self).ok_or_else(|| NoLogLevel(text.to_owned()))
    }
}

settings::from_string!(NoLogLevel: LogLevel);

/// Opens the journal if systemd gave us one (it says so in `JOURNAL_STREAM`), else standard error. Lines less urgent
/// than `level` are left out.
pub fn open(level: LogLevel) {
    let registry = tracing_subscriber::registry().with(LevelFilter::from_level(level.0));
    let journal = env::var_os("JOURNAL_STREAM").and_then(|_| tracing_journald::layer().ok());
    let terminal = journal.is_none().then(|| {
        tracing_subscriber::fmt::layer()
            .with_writer(io::stderr)
            .with_ansi(io::stderr().is_terminal())
            .with_target(false)
            .without_time()
            // A terminal that takes no line takes no complaint about that either.
            .log_internal_errors(false)
    });
    registry.with(journal).with(terminal).init();
}

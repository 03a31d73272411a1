//! Where log lines go: the journal on a unit, the terminal elsewhere.
//!
//! Owns the subscriber. Never writes a line itself.

use crate::log_level::LogLevel;
use std::env;
use std::io::{self, IsTerminal};
use tracing::level_filters::LevelFilter;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;

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

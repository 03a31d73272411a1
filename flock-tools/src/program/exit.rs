//! Exit codes, and an error with its causes in one line.
//!
//! Owns [`Exit`] and [`chain`]. Never prints: `fatal.rs` and `print.rs` do.

use std::error::Error;

/// The exit codes of every command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Exit {
    /// Fine.
    Fine = 0,
    /// The answer is no: faults found, a balance unreachable, a bundle refused.
    No = 1,
    /// Bad usage or a malformed file.
    Malformed = 2,
    /// A file, device or network could not be read or written.
    Unreadable = 3,
}

/// An error and its causes, in one line.
pub(crate) fn chain(error: &dyn Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text = format!("{text}: {error}");
        cause = error.source();
    }
    text
}

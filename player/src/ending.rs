//! How a program of the house ends.
//!
//! Owns the exit codes, and the form in which an error is told. Each program has its own errors, in its `report.rs`.

use std::error::Error;
use std::io::{self, Write};

/// The exit codes of every program of the house.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// Fine.
    Fine = 0,
    /// The answer is no.
    No = 1,
    /// Bad usage, or a malformed file.
    Wrong = 2,
    /// A file or a device could not be opened, read or written.
    Unread = 3,
}

/// Tells on standard error why the program ends, and what to do about it.
pub fn fail(error: &dyn Error, hint: &str) {
    // Nobody is left to tell if standard error is closed.
    writeln!(io::stderr(), "error: {}\n\nhint: {hint}", chain(error)).ok();
}

/// The error and everything that caused it, on one line.
pub fn chain(error: &dyn Error) -> String {
    let mut said = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        said = format!("{said}: {error}");
        cause = error.source();
    }
    said
}

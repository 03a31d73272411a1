//! How a program of a unit ends.
//!
//! Owns the exit codes, and the forms in which an answer and an error are printed. Each program has its own answer, and
//! its own errors with their exit codes in `fatal.rs`.

use serde::Serialize;
use std::error::Error;
use std::fmt::Display;
use std::io::{self, Write};

/// The exit codes of every program.
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

/// An answer, and in which form it is wanted.
#[derive(Debug)]
pub struct Output<A> {
    /// The answer.
    pub answer: A,
    /// As one JSON document; else as text.
    pub json: bool,
}

impl<A: Serialize + Display> Output<A> {
    /// Writes the answer to standard output.
    ///
    /// # Errors
    /// What the system says if that is closed.
    pub fn print(&self) -> io::Result<()> {
        let text = if self.json {
            serde_json::to_string_pretty(&self.answer).map_err(io::Error::other)?
        } else {
            self.answer.to_string()
        };
        writeln!(io::stdout(), "{text}")
    }
}

/// Writes to standard error why the program ends, and what to do about it.
pub fn fail(error: &dyn Error, hint: &str) {
    // If standard error is closed there is no other place for it.
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

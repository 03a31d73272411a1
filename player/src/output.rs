//! The answer of a program of a unit, on standard output.
//!
//! Owns its two forms. Each program has its own answer, and its own errors with their exit statuses in `fatal.rs`.

use serde::Serialize;
use std::fmt::Display;
use std::io::{self, Write};

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
    pub fn print(&self) -> io::Result<()> {
        let text = if self.json {
            serde_json::to_string_pretty(&self.answer).map_err(io::Error::other)?
        } else {
            self.answer.to_string()
        };
        writeln!(io::stdout(), "{text}")
    }
}

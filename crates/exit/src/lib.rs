//! How every program ends.
//!
//! Owns the exit statuses, and the form of an error on one line and on standard error. Each program owns its errors, and
//! which status each has.
#![forbid(unsafe_code)]

use std::error::Error;
use std::io::{self, Write};
use std::process::ExitCode;

/// The exit statuses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// Fine.
    Fine = 0,
    /// The answer is no: faults found, a balance unreachable, a bundle refused.
    No = 1,
    /// Bad usage, or a malformed file.
    Malformed = 2,
    /// A file, a device or the network could not be opened, read or written.
    Unreadable = 3,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}

/// Writes `error: ...` with its causes to standard error, and what to do about it below a blank line.
pub fn print_error(error: &dyn Error, hint: Option<&str>) {
    let hint = hint.map(|hint| format!("\n\nhint: {hint}")).unwrap_or_default();
    // If standard error is closed there is no other place for it.
    let _ = writeln!(io::stderr(), "error: {}{hint}", chain(error));
}

/// The error and everything that caused it, on one line.
pub fn chain(error: &dyn Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text = format!("{text}: {error}");
        cause = error.source();
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{Exit, chain};
    use std::io;

    #[test]
    fn an_error_comes_before_its_causes() {
        #[derive(Debug)]
        struct Outer(io::Error);
        impl std::fmt::Display for Outer {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("cannot read `a`")
            }
        }
        impl std::error::Error for Outer {
            fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
                Some(&self.0)
            }
        }
        assert_eq!(chain(&Outer(io::Error::other("no disk"))), "cannot read `a`: no disk");
    }

    #[test]
    fn the_statuses_are_those_of_the_contract() {
        assert_eq!([Exit::Fine, Exit::No, Exit::Malformed, Exit::Unreadable].map(|exit| exit as u8), [0, 1, 2, 3]);
    }
}

//! The manual, made from the same source as the help.
//!
//! Owns the commands that write completions and man pages. Never holds a word of either: both are what `lib.rs` and
//! the commands tell clap.

pub(crate) mod completions;
pub(crate) mod man;

use clap::CommandFactory;

/// The whole command line, as clap knows it.
fn command_line() -> clap::Command {
    let mut command = crate::Args::command();
    command.build();
    command
}

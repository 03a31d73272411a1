//! `dreams-install`: installs a unit on the disk of a computer, from the stick that the computer was started from.
//!
//! Owns the order: the disks that are there, the question on the display, the press of Enter, and only then the work on the
//! disk. A stick that installs has a unit's own partitions; they are copied to the disk as they are.
//!
//! Start at `conversation.rs`, the state machine; `plan.rs` says what is written where, `run.rs` connects both with the machine.
#![forbid(unsafe_code)]

mod conversation;
mod copying;
mod disks;
mod fatal;
mod options;
mod page;
mod pages;
mod plan;
mod run;
mod table;

use clap::Parser;
use options::Options;
use player::{LogLevel, journal};
use std::process::ExitCode;
use tracing::Level;

fn main() -> ExitCode {
    let options = Options::parse();
    journal::open(LogLevel(Level::INFO));
    fatal::finish(run::run(&options))
}

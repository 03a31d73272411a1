//! `dreams-update`: brings a unit a flock or a system, from a stick or a server, whole or not at all.
//!
//! Owns nothing but the order: options, settings, log, errand. Start at `errand.rs`, which is an update from its first
//! look to the switch; what arrives, and in which order it reaches the disk, is decided in `crates/bundle`.
#![forbid(unsafe_code)]

mod answer;
mod bulletin;
mod config;
mod errand;
mod fetch;
mod meter;
mod options;
mod origin;
mod pace;
mod progress;
mod report;
mod schedule;
mod server;
mod slot;
mod statements;
mod system;
mod trouble;
mod words;

use answer::Answer;
use clap::Parser;
use options::Options;
use player::ending::Told;
use player::journal;
use report::Fatal;
use std::process::ExitCode;

fn main() -> ExitCode {
    report::finish(update(Options::parse()))
}

fn update(options: Options) -> Result<Told<Answer>, Fatal> {
    let order = options.order()?; // what this unit was told
    journal::open(order.config.log); // where it speaks
    errand::run(order) // what it is for
}

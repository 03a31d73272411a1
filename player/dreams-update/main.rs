//! `dreams-update`: brings a unit a flock or a system, from a stick or a server, whole or not at all.
//!
//! Owns only the order: options, settings, log, update run. Start at `update_run.rs`, which is an update from its first
//! look to the switch; `crates/bundle` decides what is accepted, and in which order it reaches the disk.
#![forbid(unsafe_code)]

mod answer;
mod astray;
mod config;
mod fatal;
mod fetch;
mod http_source;
mod machine;
mod meter;
mod network_error;
mod options;
mod origin;
mod progress;
mod rate_limit;
mod schedule;
mod sentences;
mod slot;
mod statements;
mod status_report;
mod stick_format;
mod system;
mod tls;
mod update_run;

use answer::Answer;
use clap::Parser;
use fatal::Fatal;
use options::Options;
use player::{Output, journal};
use std::process::ExitCode;

fn main() -> ExitCode {
    fatal::finish(update(Options::parse()))
}

fn update(options: Options) -> Result<Output<Answer>, Fatal> {
    let order = options.order()?; // its settings
    journal::open(order.config.log); // where it logs
    update_run::run(order) // what it is for
}

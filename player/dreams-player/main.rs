//! `dreams-player`: plays a flock for ever, every join frame-exact.
//!
//! Owns only the order: options, settings, log, run. Start at `run.rs`, which connects the threads, then read
//! `pipeline/presenter.rs` (the flip thread) with `playback.rs` and `pacing.rs` (its decisions).
#![forbid(unsafe_code)]

mod control;
mod fatal;
mod pipeline;
mod recording;
mod run;
mod settings;
mod startup;
mod status;
mod stream;

use clap::Parser;
use fatal::Fatal;
use player::journal;
use settings::Options;
use startup::{prelude, still};
use std::process::ExitCode;

fn main() -> ExitCode {
    fatal::finish(play(Options::parse()))
}

fn play(options: Options) -> Result<(), Fatal> {
    let (still, prelude) = (options.still, options.prelude);
    let config = options.settings()?; // its settings
    journal::open(config.log); // where it logs
    match (prelude, still) {
        (true, _) => prelude::play(&config),
        (_, true) => still::hold(&config),
        _ => run::play(&config), // what it is for
    }
}

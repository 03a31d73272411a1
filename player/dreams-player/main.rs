//! `dreams-player`: plays a flock for ever, every join frame-exact.
//!
//! Owns only the order: options, settings, log, run. Start at `run.rs`, which connects the threads, then read
//! `pipeline/presenter.rs` (the flip thread) with `playback.rs` and `pacing.rs` (its decisions).
//!
//! A folder sees only folders above it in this table, and `player/src`; `tests/it/house/folders.rs` holds that.
//!
//! | folder | what is there |
//! |---|---|
//! | `fatal.rs` | why the player ends, and its exit codes |
//! | `settings` | config, command line, and the types of their values |
//! | `stream` | the flock, its clips in their order, and their frames |
//! | `recording` | trace, log lines, counters, faults, and the saved place |
//! | `control` | brightness, hours, and notices over the picture |
//! | `pipeline` | three threads that choose, decode and show |
//! | `startup` | the first picture, its hand-over, and the still picture |
//! | `status` | the status page |
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

use crate::settings::Options;
use clap::Parser;
use fatal::Fatal;
use player::journal;
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

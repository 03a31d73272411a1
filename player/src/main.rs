//! `dreams-player`: plays a flock for ever, every join frame-exact.
//!
//! Owns nothing but the order: options, settings, log, run. Start at `run.rs`, which wires the threads, then read
//! `show.rs` (the flip thread) with `playback.rs` and `pace.rs` (what it decides).
#![forbid(unsafe_code)]

mod black;
mod card;
mod config;
mod decoder;
mod faults;
mod generation;
mod glass;
mod handover;
mod herald;
mod library;
mod lighting;
mod options;
mod pace;
mod placard;
mod place;
mod playback;
mod prelude;
mod report;
mod run;
mod saver;
mod scribe;
mod settings;
mod shelf;
mod show;
mod status;
mod still;
mod take;
mod tally;
mod trace;
mod turn;
mod usher;

use clap::Parser;
use options::Options;
use player::journal;
use report::Fatal;
use std::process::ExitCode;

fn main() -> ExitCode {
    report::finish(play(Options::parse()))
}

fn play(options: Options) -> Result<(), Fatal> {
    let (still, prelude) = (options.still, options.prelude);
    let config = options.settings()?; // what this unit was told
    journal::open(config.log); // where it speaks
    match (prelude, still) {
        (true, _) => prelude::play(&config),
        (_, true) => still::hold(&config),
        _ => run::play(&config), // what it is for
    }
}

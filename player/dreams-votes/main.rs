//! `dreams-votes`: counts the votes of the people before the wall.
//!
//! Owns only the order: options, settings, then one of its works. It is a process of its own, so that what strangers press
//! never meets the player: it reads the input device that its config names, asks the player what is shown, and keeps totals
//! by sheep. `crates/votes` decides what a press counts for.
//!
//! Start at `run.rs`, which counts; `player::input_devices` reads keys, `glass.rs` asks the player.
#![forbid(unsafe_code)]

mod config;
mod fatal;
mod glass;
mod options;
mod run;
mod show;

use clap::Parser;
use fatal::Fatal;
use options::Options;
use player::journal;
use std::process::ExitCode;

fn main() -> ExitCode {
    fatal::finish(work(&Options::parse()))
}

fn work(options: &Options) -> Result<(), Fatal> {
    let config = options.settings()?; // its settings
    match (options.show, &options.copy_to) {
        (true, _) => show::print(&config.store),
        (_, Some(folder)) => show::copy(&config.store, folder),
        _ => {
            journal::open(config.log); // where it logs
            run::count(&config) // what it is for
        }
    }
}

//! `dreams-owner`: does what the owner of a unit has set, as far as that is neither the player's nor the updater's.
//!
//! Owns the command line. What may be set is `settings::owner` and `settings::wifi`. Changes the owner's file only to one
//! that was signed for this unit.
//!
//! Start at `take_in.rs`, which is run when the owner's partition is there, at `from_stick.rs`, which is run when a stick
//! is there, at `install.rs`, which is run when settings have arrived on one, at `connect.rs`, which is run for a radio,
//! at `restart.rs`, which is run when a new system waits for its start, and at `check.rs`, which is run when an image is
//! built.
#![forbid(unsafe_code)]

mod check;
mod connect;
mod from_stick;
mod inbox;
mod install;
mod link;
mod restart;
mod sentences;
mod supplicant;
mod take_in;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// The end of the help. `diagnostics::Exit` has the same four codes.
const EXIT_STATUS: &str = "\
Exit status:
  0  the owner's settings are kept, or there are none; those of the stick wait, or there are none; the unit may restart;
     the file is right
  1  the answer is no: the unit may not restart now, or the settings on the stick are refused
  2  the command line or the owner's file is wrong, or a file that is meant has another name: the last good settings stay
  3  a file could not be read or written, or a program not be run";

/// Take in what the owner of a unit has set in `dreams.toml`, and do it
#[derive(Debug, Parser)]
#[command(name = "dreams-owner", version, after_help = EXIT_STATUS)]
struct Options {
    #[command(subcommand)]
    work: Work,
}

#[derive(Debug, Subcommand)]
enum Work {
    TakeIn(take_in::Options),
    FromStick(from_stick::Options),
    Install(install::Options),
    Connect(connect::Options),
    MayRestart(restart::Options),
    Check(check::Options),
}

fn main() -> ExitCode {
    let exit = match Options::parse().work {
        Work::TakeIn(options) => take_in::run(&options),
        Work::FromStick(options) => from_stick::run(&options),
        Work::Install(options) => install::run(&options),
        Work::Connect(options) => connect::run(&options),
        Work::MayRestart(options) => restart::run(&options),
        Work::Check(options) => check::run(&options),
    };
    ExitCode::from(exit)
}

#[cfg(test)]
mod tests {
    use super::Options;
    use clap::Parser;

    #[test]
    fn the_option_for_the_notice_has_its_earlier_name_too() {
        let take_in = "dreams-owner take-in --keep k --network n --name m --wifi w --card c folder";
        let connect = "dreams-owner connect --keep k --wifi w --card c wlan0";
        for words in [take_in, connect] {
            assert!(Options::try_parse_from(words.split(' ')).is_ok(), "{words}");
        }
    }
}

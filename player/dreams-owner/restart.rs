//! Says whether the unit may restart into a new system now.
//!
//! Owns the answer: the owner's hours allow it, and no flock is on trial, which a restart would count against. Never
//! restarts anything: `dreams-restart.service` does.
//!
//! Start at [`run`].

use bundle::CurrentGeneration;
use clap::Args;
use diagnostics::Exit;
use player::hours::{Brightness, Day};
use player::{Owner, clock_s, up_s};
use std::path::{Path, PathBuf};
use std::thread;
use std::time::Duration;

/// Between two looks.
const OFTEN: Duration = Duration::from_secs(5);

/// Say whether the unit may restart into a new system: while the picture is dark, else from four to five in the morning
#[derive(Debug, Args)]
#[command(after_help = super::EXIT_STATUS)]
pub(crate) struct Options {
    /// Where the last good settings are kept
    #[arg(long, value_name = "FILE")]
    keep: PathBuf,
    /// The flock that plays
    #[arg(long, value_name = "DIR")]
    flock: PathBuf,
    /// Wait until it may
    #[arg(long)]
    wait: bool,
}

/// Answers, or waits until the answer is yes.
pub(crate) fn run(options: &Options) -> Exit {
    loop {
        let is_allowed = day(&options.keep).allows_restart(clock_s(), up_s()) && !is_on_trial(&options.flock);
        if is_allowed {
            return Exit::Fine;
        }
        if !options.wait {
            return Exit::No;
        }
        thread::park_timeout(OFTEN);
    }
}

/// What the owner has set of the unit's days, which may have changed since the last look.
fn day(keep: &Path) -> Day {
    let Owner { hours, night, timezone: zone, .. } = Owner::kept(keep);
    Day { hours, night: night.unwrap_or_default(), brightness: Brightness::full(), zone }
}

/// Whether the flock at `path` is on trial. One that cannot be read is not: the built-in one plays.
fn is_on_trial(path: &Path) -> bool {
    let Ok(Some(playing)) = CurrentGeneration::of(path) else { return false };
    playing.recorder().is_ok_and(|recorder| recorder.is_on_trial(playing.number()))
}

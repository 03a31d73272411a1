//! Says whether the unit may restart into a new system now.
//!
//! Owns the answer: the owner's hours allow it, and no flock is on trial, which a restart would count against. Never
//! restarts anything: `dreams-restart.service` does.
//!
//! Start at [`run`].

use bundle::CurrentGeneration;
use clap::Args;
use diagnostics::Exit;
use player::ClockReader;
use player::clock::{SYNCHRONISED, SYSTEM};
use settings::Owner;
use settings::hours::{Brightness, Day};
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
    /// The os-release file of the running system, which says how old it is
    #[arg(long, value_name = "FILE", default_value = SYSTEM)]
    system: PathBuf,
    /// The file that is there once a time server has set the clock
    #[arg(long, value_name = "FILE", default_value = SYNCHRONISED)]
    synchronised: PathBuf,
    /// Wait until it may
    #[arg(long)]
    wait: bool,
}

/// Answers, or waits until the answer is yes.
pub(crate) fn run(options: &Options) -> Exit {
    let clock = ClockReader::new(&options.system, &options.synchronised);
    loop {
        let now = clock.read();
        let is_allowed = day(&options.keep).allows_restart(now.known_s(), now.up_s) && !is_on_trial(&options.flock);
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
    let Owner { hours, closed, night, timezone: zone, .. } = Owner::kept(keep);
    Day { hours, closed, night: night.unwrap_or_default(), brightness: Brightness::full(), zone }
}

/// Whether the flock at `path` is on trial. One that cannot be read is not: the built-in one plays.
fn is_on_trial(path: &Path) -> bool {
    let Ok(Some(playing)) = CurrentGeneration::of(path) else { return false };
    playing.recorder().is_ok_and(|recorder| recorder.is_on_trial(playing.number()))
}

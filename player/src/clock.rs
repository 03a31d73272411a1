//! The machine's clock, and what a unit knows of the time.
//!
//! Owns the one decision on it: the time is known if a time server has set the clock since the start, or if the clock was
//! kept over the start. The battery of a clock may be dead: it then begins at some past date, and systemd moves it on to the
//! date at which systemd itself was made. So it counts as kept only if it stood later than the date of the unit's system.
//! Never sets a clock, never reads one but through `now.rs`.
//!
//! Start at [`Clock::known_s`].

use crate::now::{clock_s, up_s};
use jiff::Timestamp;
use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use votes::DAY_S;

/// No unit is older: 2026-01-01, in seconds since 1970.
pub const FOUNDED_S: u64 = votes::FOUNDED_DAY as u64 * DAY_S;
/// What an unset clock may show beyond the date of its system at the machine's start, in seconds: packages are made on
/// different machines.
const SLACK_S: u64 = DAY_S;

/// The file that says what the system is; a unit's own also says of which date.
pub const SYSTEM: &str = "/usr/lib/os-release";
/// The file that systemd's time service makes when it has set the clock. Sandboxed services may see it; they may not ask the
/// kernel, since the call that does so also sets clocks.
pub const SYNCHRONISED: &str = "/run/systemd/timesync/synchronized";
/// How the line with the date begins, a time as `2026-11-20T08:00:00Z`: `image-build/build` writes it.
const DATE: &str = "DREAMS_DATE=";
/// Whose date it is where the system does not say one: dead clocks are moved on to it.
const SYSTEMD: &str = "/usr/lib/systemd/systemd";

/// The clock at one moment. All times in seconds: since 1970, or since the machine's start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Clock {
    /// What it shows.
    pub shown_s: u64,
    /// How long the machine has run.
    pub up_s: u64,
    /// The date of the unit's system: it cannot be earlier.
    pub earliest_s: u64,
    /// Whether a time server has set the clock since the start.
    pub is_synchronised: bool,
}

impl Clock {
    /// The time, in seconds since 1970; `None` while the unit does not know it.
    pub fn known_s(&self) -> Option<u64> {
        let is_set = self.is_synchronised && self.shown_s >= self.earliest_s;
        let was_kept = self.shown_s.saturating_sub(self.up_s) > self.earliest_s.saturating_add(SLACK_S);
        (is_set || was_kept).then_some(self.shown_s)
    }

    /// The earliest time that it can be, in seconds since 1970: what the clock shows, but not before the system was made.
    pub fn least_s(&self) -> u64 {
        self.shown_s.max(self.earliest_s)
    }
}

/// Reads the clock, and what is known of it.
#[derive(Clone, Debug)]
pub struct ClockReader {
    earliest_s: u64,
    synchronised: PathBuf,
}

impl ClockReader {
    /// On a machine whose `os-release` is the file `system`, and on which the file `synchronised` is there once a time
    /// server has set the clock.
    pub fn new(system: &Path, synchronised: &Path) -> Self {
        Self { earliest_s: made_s(system), synchronised: synchronised.to_owned() }
    }

    /// On this machine, as systemd has it.
    pub fn of_machine() -> Self {
        Self::new(SYSTEM.as_ref(), SYNCHRONISED.as_ref())
    }

    /// The clock now.
    pub fn read(&self) -> Clock {
        let is_synchronised = self.synchronised.exists();
        Clock { shown_s: clock_s(), up_s: up_s(), earliest_s: self.earliest_s, is_synchronised }
    }
}

/// When the system was made whose `os-release` is the file `system`, in seconds since 1970.
fn made_s(system: &Path) -> u64 {
    let text = fs::read_to_string(system).unwrap_or_default();
    let date = text.lines().find_map(|line| line.strip_prefix(DATE)).map(|date| date.trim_matches('"'));
    let told_s = date.and_then(|date| date.parse::<Timestamp>().ok()).map(Timestamp::as_second);
    let made_s = told_s.or_else(|| fs::metadata(SYSTEMD).ok().map(|file| file.mtime()));
    made_s.and_then(|made_s| u64::try_from(made_s).ok()).unwrap_or_default().max(FOUNDED_S)
}

#[cfg(test)]
mod tests {
    use super::{Clock, DAY_S, FOUNDED_S, made_s};
    use std::fs;

    /// 2026-11-20 08:00 in UTC, in seconds since 1970.
    const MADE_S: u64 = 1_795_161_600;
    const YEAR_S: u64 = 365 * DAY_S;

    #[test]
    fn the_time_is_known_if_a_server_has_set_the_clock_or_it_was_kept_over_the_start() {
        for (shown_s, up_s, is_synchronised, is_known, why) in [
            (60, 60, false, false, "1970"),
            (MADE_S - 200 * DAY_S, 60, false, false, "moved on by systemd, which is older than the system"),
            (MADE_S, 0, false, false, "moved on to the system's own date"),
            (MADE_S + 3 * YEAR_S, 3 * YEAR_S, false, false, "the same, three years later"),
            (MADE_S + DAY_S / 2, 0, false, false, "the system was put together on that day"),
            (MADE_S + 2 * DAY_S, 60, false, true, "a clock with a battery, two days later"),
            (MADE_S + 3 * YEAR_S, 60, false, true, "the same, three years later"),
            (MADE_S + 60, 60, true, true, "set by a server on the first day"),
            (MADE_S + 3 * YEAR_S, 60, true, true, "set by a server"),
            (MADE_S - 1, 60, true, false, "set by a server to a time before the system was made"),
        ] {
            let clock = Clock { shown_s, up_s, earliest_s: MADE_S, is_synchronised };
            assert_eq!(clock.known_s(), is_known.then_some(shown_s), "{why}");
            assert_eq!(clock.least_s(), shown_s.max(MADE_S), "{why}");
        }
    }

    #[test]
    fn a_system_says_of_which_date_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let made_s = |text: &str| {
            fs::write(folder.path().join("os-release"), text).unwrap();
            made_s(&folder.path().join("os-release"))
        };
        assert_eq!(made_s("ID=dreams\nDREAMS_DATE=2026-11-20T08:00:00Z\n"), MADE_S);
        assert_eq!(made_s("DREAMS_DATE=\"2026-11-20T08:00:00Z\"\n"), MADE_S);
        assert_eq!(made_s("DREAMS_DATE=1999-11-20T08:00:00Z\n"), FOUNDED_S, "no unit is older");
        assert!(made_s("ID=debian\nDREAMS_DATE=soon\n") >= FOUNDED_S);
    }
}

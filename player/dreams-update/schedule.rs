//! When a unit looks for updates by itself, and when it reports.
//!
//! Owns the interval, its jitter, the patience after failures, the hours in which it may be, and the times of reports where
//! they have their own. Settings that change end the wait. Time is counted from the machine's start, so that no clock need
//! be right; the hours are kept only where the time is known. Pure, but for the small file that remembers until the next
//! start when the next look is due.
//!
//! Start at [`Schedule::is_due`].

use serde::{Deserialize, Serialize};
use settings::day::{self, DAY_MIN};
use std::io;
use std::path::Path;
use std::str::FromStr;

/// The first wait after a failure, in seconds; it doubles with each further one.
const AGAIN_S: u64 = 60;
/// The most that its file may have, in bytes.
const LARGEST: u64 = 8 << 10;
/// The most characters of an error in it.
const LONGEST_ERROR: usize = 1_000;

/// Hours of the day, in UTC.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(try_from = "String")]
pub(crate) struct Window(day::Window);

/// A text that is no window.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not a valid window: two times of the day in UTC, as in `02:00-05:30`")]
pub(crate) struct NoWindow(String);

/// What is remembered of the last look.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Schedule {
    /// Seconds since the start of the machine at which the next look is due.
    due_s: u64,
    /// Failures in a row.
    failures: u32,
    /// Seconds since the start of the machine at which the next report is due, where reports have times of their own.
    #[serde(default)]
    report_due_s: u64,
    /// Why the last look failed.
    #[serde(default)]
    error: Option<String>,
    /// By which writing of the owner's settings that look went; none before the first.
    #[serde(default)]
    settings: Option<String>,
}

impl Schedule {
    /// What is remembered at `path`. A file that cannot be read is ignored: the unit looks once more.
    pub(crate) fn read(path: &Path) -> Self {
        durable::read_plain(path, LARGEST)
            .ok()
            .and_then(|bytes| serde_json::from_slice(&bytes).ok())
            .unwrap_or_default()
    }

    /// Remembers it at `path`, which need not outlive the machine's next start.
    pub(crate) fn write(&self, path: &Path) -> io::Result<()> {
        durable::write(path, &serde_json::to_vec(self).map_err(io::Error::other)?)
    }

    /// The same by the writing `settings` of the owner's settings. If that is another one than at the last look, the next
    /// look and the next report are due at once, and failures are forgotten: another server may answer.
    #[must_use]
    pub(crate) fn by(self, settings: &str) -> Self {
        let settings = Some(settings.to_owned());
        match self.settings {
            Some(_) if self.settings != settings => Self { settings, error: self.error, ..Self::default() },
            Some(_) | None => Self { settings, ..self },
        }
    }

    /// Whether to look now: `up_s` seconds after the machine's start, at `known_s` seconds since 1970; `None` while the time
    /// is not known.
    pub(crate) fn is_due(&self, up_s: u64, known_s: Option<u64>, window: Option<Window>) -> bool {
        let open = window.zip(known_s).is_none_or(|(window, known_s)| window.includes(known_s));
        up_s >= self.due_s && open
    }

    /// After a look at `up_s`: the next one `every_s` later, give or take a quarter; sooner after a failure, and the more
    /// failures the less soon. `chance` is random, from 0 to below 1.
    #[must_use]
    pub(crate) fn after(&self, is_failure: bool, up_s: u64, every_s: u64, chance: f64) -> Self {
        let failures = if is_failure { self.failures.saturating_add(1) } else { 0 };
        let wait_s = if is_failure {
            AGAIN_S.checked_shl(failures - 1).unwrap_or(every_s).clamp(AGAIN_S.min(every_s), every_s)
        } else {
            every_s
        };
        let jittered = wait_s as f64 * (0.75 + 0.5 * chance);
        Self { due_s: up_s.saturating_add(jittered as u64), failures, ..self.clone() }
    }

    /// The same after a look that ended with `error`, for the reports until the next one.
    #[must_use]
    pub(crate) fn with_error(self, error: Option<&str>) -> Self {
        Self { error: error.map(|error| error.chars().take(LONGEST_ERROR).collect()), ..self }
    }

    /// Why the last look failed.
    pub(crate) fn error(&self) -> Option<&str> {
        self.error.as_deref()
    }

    /// Whether to report now, `up_s` seconds after the machine's start, where reports have times of their own.
    pub(crate) fn is_report_due(&self, up_s: u64) -> bool {
        up_s >= self.report_due_s
    }

    /// After a report at `up_s`: the next one is due `every_s` later.
    #[must_use]
    pub(crate) fn reported(self, up_s: u64, every_s: u64) -> Self {
        Self { report_due_s: up_s.saturating_add(every_s), ..self }
    }
}

impl Window {
    fn includes(self, known_s: u64) -> bool {
        self.0.includes(known_s / 60 % DAY_MIN)
    }
}

impl FromStr for Window {
    type Err = NoWindow;

    fn from_str(text: &str) -> Result<Self, NoWindow> {
        day::Window::parse(text).map(Self).ok_or_else(|| NoWindow(text.to_owned()))
    }
}

settings::from_string!(NoWindow: Window);

#[cfg(test)]
mod tests {
    use super::{Schedule, Window};
    use player::clock::FOUNDED_S;

    const HOUR: u64 = 3_600;

    #[test]
    fn a_unit_looks_at_once_after_its_start_and_then_about_every_so_often() {
        let schedule = Schedule::default();
        assert!(schedule.is_due(3, None, None), "whatever the time");
        for (chance, early, late) in [(0.0, 4 * HOUR, 5 * HOUR), (0.999, 7 * HOUR, 8 * HOUR)] {
            let next = schedule.after(false, 100, 6 * HOUR, chance);
            assert!(!next.is_due(100 + early, None, None) && next.is_due(100 + late, None, None));
        }
    }

    #[test]
    fn failures_are_met_with_growing_patience_and_forgotten_after_a_success() {
        let mut schedule = Schedule::default();
        let mut waits = Vec::new();
        for _ in 0..12 {
            schedule = schedule.after(true, 0, 6 * HOUR, 0.5);
            waits.push(schedule.due_s);
        }
        assert_eq!(waits[..4], [60, 120, 240, 480]);
        assert_eq!(waits[9..], [6 * HOUR; 3], "never less often than without failures");
        assert_eq!(
            schedule.after(true, 0, 6 * HOUR, 0.5).after(false, 0, HOUR, 0.5).after(true, 0, HOUR, 0.5).due_s,
            60
        );
        let patient = Schedule { failures: u32::MAX, ..schedule };
        assert_eq!(patient.after(true, 0, 6 * HOUR, 0.5).due_s, 6 * HOUR);
    }

    #[test]
    fn the_window_is_kept_where_the_time_is_known() {
        let midnight = FOUNDED_S;
        let is_due = |window: &str, known_s| Schedule::default().is_due(0, known_s, Some(window.parse().unwrap()));
        for (window, hour, is_open) in [
            ("02:00-05:30", 1, false),
            ("02:00-05:30", 2, true),
            ("02:00-05:30", 6, false),
            ("22:00-04:00", 23, true),
            ("22:00-04:00", 3, true),
            ("22:00-04:00", 4, false),
        ] {
            assert_eq!(is_due(window, Some(midnight + hour * HOUR)), is_open, "{window} at {hour}");
        }
        assert!(is_due("02:00-05:30", None), "nobody knows whether it is noon");
        for wrong in ["", "2:00-5:30", "02:00", "24:00-25:00", "02:00-02:00", "02:00-05:60", "-1:00-05:00"] {
            assert!(wrong.parse::<Window>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn reports_have_times_of_their_own_and_know_how_the_last_look_ended() {
        let schedule = Schedule::default();
        assert!(schedule.is_report_due(0), "at once after the start");
        let next = schedule.reported(100, HOUR).with_error(Some(&"x".repeat(5_000)));
        assert!(!next.is_report_due(99 + HOUR) && next.is_report_due(100 + HOUR));
        let later = next.after(false, 200, 6 * HOUR, 0.5);
        assert!(!later.is_report_due(99 + HOUR) && later.is_report_due(100 + HOUR), "whenever it looks");
        assert_eq!(later.error().map(str::len), Some(1_000));
        assert_eq!(later.with_error(None).error(), None);
    }

    #[test]
    fn settings_that_change_have_a_unit_look_and_report_at_once_and_once() {
        let schedule = Schedule::default().by("one").after(true, 0, 6 * HOUR, 0.5).after(true, 0, 6 * HOUR, 0.5);
        let schedule = schedule.reported(0, HOUR).with_error(Some("no answer"));
        let same = schedule.clone().by("one");
        assert_eq!(same, schedule);
        assert!(!same.is_due(100, None, None) && !same.is_report_due(100));
        let changed = schedule.by("two");
        assert!(changed.is_due(100, None, None) && changed.is_report_due(100));
        assert_eq!((changed.failures, changed.error()), (0, Some("no answer")));
        let closed = Some("02:00-03:00".parse().unwrap());
        assert!(!changed.is_due(100, Some(FOUNDED_S), closed), "in its window only");
        assert!(!changed.after(false, 100, HOUR, 0.5).by("two").is_due(200, None, None));
    }

    #[test]
    fn what_is_remembered_is_read_and_rubbish_is_forgotten() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("schedule");
        assert_eq!(Schedule::read(&path), Schedule::default());
        let schedule = Schedule::default().after(true, 7, HOUR, 0.5).with_error(Some(&"\u{1}".repeat(1_000)));
        schedule.write(&path).unwrap();
        assert_eq!(Schedule::read(&path), schedule);
        std::fs::write(&path, "{\"due_s\": 7, \"failures\": 0}").unwrap();
        assert!(!Schedule::read(&path).is_due(6, None, None), "that of the program before");
        std::fs::write(&path, "rubbish").unwrap();
        assert_eq!(Schedule::read(&path), Schedule::default());
    }
}

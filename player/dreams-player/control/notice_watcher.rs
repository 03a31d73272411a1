//! The notice watcher: a thread that looks for notices, and how long they are shown.
//!
//! Owns their order and duration. A short notice goes when its file is removed, and a minute after it was last written. A
//! [`Lasting`] one is shown whenever there is no short one, until its file is removed; after these comes, once
//! and for a minute, that the player is too slow, and then what the display does not do as its owner has set it. The flip
//! thread never waits for it. Never writes a notice: the updater,
//! `dreams-owner` and `dreams-mend` do.
//!
//! Start at [`NoticeWatcher::start`].

use crate::control::notice_pane::NoticePane;
use crate::control::pane::{Overlay, Pane};
use crate::recording::{Faults, Kind, SharedView, Slowness};
use player::{Lasting, Notice, ThreadError, threads};
use settings::FileVersion;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread;
use std::time::Duration;
use timing::Nanos;

/// The time between two looks.
const OFTEN: Duration = Duration::from_millis(500);
/// What people read once if frames are late all the time.
const TOO_SLOW: &str = "This frame is too slow for this flock: the picture moves unevenly.";
/// The same for the log.
const LATE: &str = "frames are late all the time: this computer is too slow for the flock, or other programs use it";
/// How long a short notice is shown, if it is not written again.
const SHOWN: Duration = Duration::from_mins(1);

/// What changes after a look.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Change {
    /// What is shown stays.
    None,
    /// Nothing is shown any more.
    Clear,
    /// This is shown from now on; `None` if it cannot be read, or has no room.
    Show(Option<Pane>),
}

/// What is shown, and since when.
#[derive(Debug)]
pub(crate) struct NoticeWatcher {
    path: PathBuf,
    /// The short notice that was seen last. One from long before the run began counts as seen.
    known: Option<FileVersion>,
    /// When that was first seen; `None` if it is not shown any more.
    since: Option<Nanos>,
    /// When the player was first found to be too slow.
    slow: Option<Nanos>,
    /// What is shown, and the size of the pictures that it is laid over.
    shown: Option<(Source, (u32, u32))>,
}

/// Where a notice comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Source {
    /// A file, and its version.
    File(PathBuf, FileVersion),
    /// The player itself.
    Player,
    /// The display itself.
    Display(String),
}

impl NoticeWatcher {
    /// For notices at `path`, when the clock shows `clock_s` seconds since 1970.
    pub(crate) fn new(path: &Path, clock_s: u64) -> Self {
        let is_old =
            |file: &FileVersion| u64::try_from(file.written_s).is_ok_and(|at_s| at_s + SHOWN.as_secs() <= clock_s);
        Self {
            path: path.to_owned(),
            known: FileVersion::of(path).filter(is_old),
            since: None,
            slow: None,
            shown: None,
        }
    }

    /// Starts the thread, which puts what it finds into `overlay` for as long as the process lives.
    pub(crate) fn start(
        mut self,
        view: Arc<SharedView>,
        overlay: Arc<Overlay>,
        faults: Faults,
        now: fn() -> Nanos,
    ) -> Result<(), ThreadError> {
        let work = move || {
            let mut slowness = Slowness::default();
            loop {
                let (tally, refresh) = view.tally_and_refresh();
                let is_slow = slowness.look(tally, refresh, now());
                view.slow(is_slow);
                if is_slow {
                    faults.once(Kind::TooSlow, "", LATE.to_owned());
                    self.slow.get_or_insert_with(now);
                }
                let (size, notes) = view.size_and_notes();
                match self.look(size, notes, now()) {
                    Change::None => {}
                    Change::Show(pane) => overlay.set_notice(pane.map(Arc::new)),
                    Change::Clear => overlay.set_notice(None),
                }
                thread::park_timeout(OFTEN);
            }
        };
        threads::start("notices", work).map(drop)
    }

    /// Looks what is to be shown at `now`, over pictures of this size, on a display with these `notes`.
    fn look(&mut self, size: Option<(u32, u32)>, notes: Vec<String>, now: Nanos) -> Change {
        let Some(size) = size else { return Change::None };
        let display = || notes.into_iter().next().map(Source::Display);
        let wanted = self
            .short(now)
            .or_else(|| self.lasting())
            .or_else(|| self.slow(now))
            .or_else(display)
            .map(|source| (source, size));
        if wanted == self.shown {
            return Change::None;
        }
        let notice = |source: &Source| match source {
            Source::File(path, _) => Notice::read(path),
            Source::Player => Some(Notice { text: TOO_SLOW.to_owned(), thousandths: None }),
            Source::Display(text) => Some(Notice { text: text.clone(), thousandths: None }),
        };
        let drawn = |source: &Source| notice(source).and_then(|notice| NoticePane::draw(&notice, size));
        let seen = wanted.as_ref().map_or(Change::Clear, |(source, _)| Change::Show(drawn(source)));
        self.shown = wanted;
        seen
    }

    /// The notice that was written less than a minute before `now`.
    fn short(&mut self, now: Nanos) -> Option<Source> {
        let found = FileVersion::of(&self.path);
        if found.is_some() && found != self.known {
            (self.known, self.since) = (found, Some(now));
        }
        self.since = self.since.filter(|since| u128::from(now.since(*since)) < SHOWN.as_nanos());
        self.since.and(found).map(|version| Source::File(self.path.clone(), version))
    }

    /// That the player is too slow, if it was found less than a minute before `now`.
    fn slow(&self, now: Nanos) -> Option<Source> {
        self.slow.filter(|since| u128::from(now.since(*since)) < SHOWN.as_nanos()).map(|_| Source::Player)
    }

    /// The most urgent lasting notice.
    fn lasting(&self) -> Option<Source> {
        let mut paths = Lasting::ALL.into_iter().map(|cause| cause.path(&self.path));
        paths.find_map(|path| FileVersion::of(&path).map(|version| Source::File(path, version)))
    }
}

#[cfg(test)]
mod tests {
    use super::{Change, NoticeWatcher, SHOWN, TOO_SLOW};
    use player::{Lasting, Notice};
    use timing::Nanos;

    const SIZE: Option<(u32, u32)> = Some((640, 480));

    #[test]
    fn a_notice_is_shown_when_it_is_told_and_goes_after_a_minute() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("notice");
        let tell = |text: &str| Notice { text: text.to_owned(), thousandths: None }.tell(&path).unwrap();
        let minute = u64::try_from(SHOWN.as_nanos()).unwrap();
        tell("Yesterday.");
        let mut watcher = NoticeWatcher::new(&path, u64::MAX);
        assert_eq!(watcher.look(SIZE, vec![], Nanos(0)), Change::None, "that was before our time");
        assert_eq!(
            NoticeWatcher::new(&path, 0).look(None, vec![], Nanos(0)),
            Change::None,
            "there is no picture to lay it over"
        );
        let mut newcomer = NoticeWatcher::new(&path, 0);
        assert!(matches!(newcomer.look(SIZE, vec![], Nanos(0)), Change::Show(Some(_))), "that was just now");
        tell("Now.");
        let now = watcher.look(SIZE, vec![], Nanos(1));
        assert!(matches!(now, Change::Show(Some(_))));
        assert_eq!(watcher.look(SIZE, vec![], Nanos(2)), Change::None);
        tell("Then.");
        let then = watcher.look(SIZE, vec![], Nanos(3));
        assert!(matches!(then, Change::Show(Some(_))) && then != now);
        assert_eq!(watcher.look(SIZE, vec![], Nanos(2 + minute)), Change::None);
        assert_eq!(watcher.look(SIZE, vec![], Nanos(3 + minute)), Change::Clear);
        assert_eq!(watcher.look(SIZE, vec![], Nanos(4 + minute)), Change::None);
        tell("Larger.");
        let larger = Some((1280, 960));
        let small = watcher.look(SIZE, vec![], Nanos(5));
        let large = watcher.look(larger, vec![], Nanos(6));
        assert!(matches!(large, Change::Show(Some(_))) && large != small, "drawn anew for pictures of another size");
        assert_eq!(watcher.look(larger, vec![], Nanos(4 + minute)), Change::None);
        assert_eq!(watcher.look(larger, vec![], Nanos(5 + minute)), Change::Clear);
        std::fs::write(folder.path().join("new"), "rubbish").unwrap();
        std::fs::rename(folder.path().join("new"), &path).unwrap();
        assert_eq!(
            watcher.look(larger, vec![], Nanos(6 + minute)),
            Change::Show(None),
            "what makes no sense is not shown"
        );
        tell("Wrong.");
        assert!(matches!(watcher.look(larger, vec![], Nanos(7 + minute)), Change::Show(Some(_))));
        std::fs::remove_file(&path).unwrap();
        assert_eq!(watcher.look(larger, vec![], Nanos(8 + minute)), Change::Clear, "it was taken back");
        assert_eq!(watcher.look(larger, vec![], Nanos(9 + minute)), Change::None);
    }

    #[test]
    fn what_is_wrong_is_shown_until_it_is_taken_back_and_again_after_what_is_told_for_a_moment() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("notice");
        let tell = |path: &std::path::Path, text: &str| Notice { text: text.to_owned(), thousandths: None }.tell(path);
        let minute = u64::try_from(SHOWN.as_nanos()).unwrap();
        tell(&Lasting::Settings.path(&path), "dreams.toml is wrong.").unwrap();
        let mut watcher = NoticeWatcher::new(&path, u64::MAX);
        let wrong = watcher.look(SIZE, vec![], Nanos(0));
        assert!(matches!(wrong, Change::Show(Some(_))), "also if it was told long before this run: {wrong:?}");
        assert_eq!(watcher.look(SIZE, vec![], Nanos(100 * minute)), Change::None, "it stays");
        tell(&path, "A new flock is here.").unwrap();
        let news = watcher.look(SIZE, vec![], Nanos(100 * minute + 1));
        assert!(matches!(news, Change::Show(Some(_))) && news != wrong);
        assert_eq!(watcher.look(SIZE, vec![], Nanos(100 * minute + 2)), Change::None);
        assert_eq!(watcher.look(SIZE, vec![], Nanos(101 * minute + 1)), wrong, "it comes back");
        tell(&Lasting::Settings.path(&path), "dreams.toml is still wrong.").unwrap();
        let still = watcher.look(SIZE, vec![], Nanos(101 * minute + 2));
        assert!(matches!(still, Change::Show(Some(_))) && still != wrong);
        Lasting::Settings.take_back(&path).unwrap();
        assert_eq!(watcher.look(SIZE, vec![], Nanos(101 * minute + 3)), Change::Clear);
        Lasting::Settings.take_back(&path).expect("nothing is left to take back");
        assert_eq!(watcher.look(SIZE, vec![], Nanos(101 * minute + 4)), Change::None);
    }

    #[test]
    fn a_player_that_is_too_slow_says_so_once_for_a_minute_where_nothing_is_more_urgent() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("notice");
        let minute = u64::try_from(SHOWN.as_nanos()).unwrap();
        let mut watcher = NoticeWatcher::new(&path, u64::MAX);
        watcher.slow = Some(Nanos(7));
        let slow = watcher.look(SIZE, vec!["There is no connector DP-9.".to_owned()], Nanos(7));
        assert!(matches!(slow, Change::Show(Some(_))));
        Notice { text: "dreams.toml is wrong.".to_owned(), thousandths: None }
            .tell(&Lasting::Settings.path(&path))
            .unwrap();
        assert!(matches!(watcher.look(SIZE, vec![], Nanos(8)), Change::Show(Some(_))));
        Lasting::Settings.take_back(&path).unwrap();
        assert_eq!(watcher.look(SIZE, vec![], Nanos(9)), slow);
        assert_eq!(watcher.look(SIZE, vec![], Nanos(7 + minute)), Change::Clear);
        let notice = Notice { text: TOO_SLOW.to_owned(), thousandths: None };
        assert_eq!(notice.lines(Notice::LARGE_LINE).join(" "), TOO_SLOW, "it has room in large letters");
    }

    #[test]
    fn what_the_display_does_not_do_is_shown_where_nothing_else_is() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("notice");
        let mut watcher = NoticeWatcher::new(&path, u64::MAX);
        let notes = |text: &str| vec![text.to_owned(), "Another.".to_owned()];
        let first = watcher.look(SIZE, notes("There is no connector DP-9."), Nanos(0));
        assert!(matches!(first, Change::Show(Some(_))));
        assert_eq!(watcher.look(SIZE, notes("There is no connector DP-9."), Nanos(1)), Change::None);
        Notice { text: "A new flock.".to_owned(), thousandths: None }.tell(&path).unwrap();
        assert!(matches!(watcher.look(SIZE, notes("There is no connector DP-9."), Nanos(2)), Change::Show(Some(_))));
        std::fs::remove_file(&path).unwrap();
        assert_eq!(watcher.look(SIZE, notes("There is no connector DP-9."), Nanos(3)), first, "it comes back");
        assert_eq!(watcher.look(SIZE, vec![], Nanos(4)), Change::Clear, "it was mended");
    }
}

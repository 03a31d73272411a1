//! The usher: a thread that looks for what people are to be told, and for how long.
//!
//! Owns where a notice comes from and when it goes again. A notice for a moment goes when it is taken back, and a minute
//! after it was last told. A [`Lasting`] one is shown whenever there is no other, until it is taken back; after these comes
//! what the display does not do as its owner has set it. The flip thread never waits for it. Never writes a notice: the
//! updater and `dreams-owner` do.
//!
//! Start at [`Usher::start`].

use crate::control::notice_pane::{Overlay, Placard};
use crate::recording::view::SharedView;
use player::file_version::FileVersion;
use player::notice::{Lasting, Notice};
use player::threads::{self, ThreadError};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread;
use std::time::Duration;
use timing::Nanos;

/// Between two looks.
const OFTEN: Duration = Duration::from_millis(500);
/// How long a notice for a moment is shown, if it is not told again.
const SHOWN: Duration = Duration::from_mins(1);

/// What a look brings.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Seen {
    /// What is shown may stay.
    Nothing,
    /// Nothing is to be shown any more.
    Over,
    /// This is to be shown from now on; `None` for what makes no sense, or has no room.
    Told(Option<Placard>),
}

/// What is shown, and since when.
#[derive(Debug)]
pub(crate) struct Usher {
    path: PathBuf,
    /// The telling for a moment that was seen last. One from long before the run began counts as seen.
    known: Option<FileVersion>,
    /// When that was first seen; `None` if it is not to be shown any more.
    since: Option<Nanos>,
    /// What is shown, and the size of the pictures that it is laid over.
    shown: Option<(Source, (u32, u32))>,
}

/// Where a notice comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Source {
    /// A file, and which telling of it.
    File(PathBuf, FileVersion),
    /// The display itself.
    Display(String),
}

impl Usher {
    /// An usher for notices at `path`, when the clock shows `clock_s` seconds since 1970.
    pub(crate) fn new(path: &Path, clock_s: u64) -> Self {
        let is_old =
            |file: &FileVersion| u64::try_from(file.written_s).is_ok_and(|at_s| at_s + SHOWN.as_secs() <= clock_s);
        Self { path: path.to_owned(), known: FileVersion::of(path).filter(is_old), since: None, shown: None }
    }

    /// Starts the thread, which shows what it finds on `overlay` for as long as the process lives.
    ///
    /// # Errors
    /// [`ThreadError`].
    pub(crate) fn start(
        mut self,
        view: Arc<SharedView>,
        overlay: Arc<Overlay>,
        now: fn() -> Nanos,
    ) -> Result<(), ThreadError> {
        let work = move || {
            loop {
                let (size, notes) = view.size_and_notes();
                match self.look(size, notes, now()) {
                    Seen::Nothing => {}
                    Seen::Told(placard) => overlay.set(placard.map(Arc::new)),
                    Seen::Over => overlay.set(None),
                }
                thread::park_timeout(OFTEN);
            }
        };
        threads::start("notices", work).map(drop)
    }

    /// Looks what is to be shown at `now`, over pictures of this size, on a display with these `notes`.
    fn look(&mut self, size: Option<(u32, u32)>, notes: Vec<String>, now: Nanos) -> Seen {
        let Some(size) = size else { return Seen::Nothing };
        let display = || notes.into_iter().next().map(Source::Display);
        let wanted = self.for_a_moment(now).or_else(|| self.lasting()).or_else(display).map(|source| (source, size));
        if wanted == self.shown {
            return Seen::Nothing;
        }
        let notice = |source: &Source| match source {
            Source::File(path, _) => Notice::read(path),
            Source::Display(text) => Some(Notice { text: text.clone(), thousandths: None }),
        };
        let drawn = |source: &Source| notice(source).and_then(|notice| Placard::draw(&notice, size));
        let seen = wanted.as_ref().map_or(Seen::Over, |(source, _)| Seen::Told(drawn(source)));
        self.shown = wanted;
        seen
    }

    /// The notice that was told less than a minute before `now`.
    fn for_a_moment(&mut self, now: Nanos) -> Option<Source> {
        let found = FileVersion::of(&self.path);
        if found.is_some() && found != self.known {
            (self.known, self.since) = (found, Some(now));
        }
        self.since = self.since.filter(|since| u128::from(now.since(*since)) < SHOWN.as_nanos());
        self.since.and(found).map(|version| Source::File(self.path.clone(), version))
    }

    /// The most urgent notice that stays until it is taken back.
    fn lasting(&self) -> Option<Source> {
        let mut paths = Lasting::ALL.into_iter().map(|cause| cause.path(&self.path));
        paths.find_map(|path| FileVersion::of(&path).map(|version| Source::File(path, version)))
    }
}

#[cfg(test)]
mod tests {
    use super::{SHOWN, Seen, Usher};
    use player::notice::{Lasting, Notice};
    use timing::Nanos;

    const SIZE: Option<(u32, u32)> = Some((640, 480));

    #[test]
    fn a_notice_is_shown_when_it_is_told_and_goes_after_a_minute() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("card");
        let tell = |text: &str| Notice { text: text.to_owned(), thousandths: None }.tell(&path).unwrap();
        let minute = u64::try_from(SHOWN.as_nanos()).unwrap();
        tell("Yesterday.");
        let mut usher = Usher::new(&path, u64::MAX);
        assert_eq!(usher.look(SIZE, vec![], Nanos(0)), Seen::Nothing, "that was before our time");
        assert_eq!(
            Usher::new(&path, 0).look(None, vec![], Nanos(0)),
            Seen::Nothing,
            "there is no picture to lay it over"
        );
        let mut newcomer = Usher::new(&path, 0);
        assert!(matches!(newcomer.look(SIZE, vec![], Nanos(0)), Seen::Told(Some(_))), "that was just now");
        tell("Now.");
        let now = usher.look(SIZE, vec![], Nanos(1));
        assert!(matches!(now, Seen::Told(Some(_))));
        assert_eq!(usher.look(SIZE, vec![], Nanos(2)), Seen::Nothing);
        tell("Then.");
        let then = usher.look(SIZE, vec![], Nanos(3));
        assert!(matches!(then, Seen::Told(Some(_))) && then != now);
        assert_eq!(usher.look(SIZE, vec![], Nanos(2 + minute)), Seen::Nothing);
        assert_eq!(usher.look(SIZE, vec![], Nanos(3 + minute)), Seen::Over);
        assert_eq!(usher.look(SIZE, vec![], Nanos(4 + minute)), Seen::Nothing);
        tell("Larger.");
        let larger = Some((1280, 960));
        let small = usher.look(SIZE, vec![], Nanos(5));
        let large = usher.look(larger, vec![], Nanos(6));
        assert!(matches!(large, Seen::Told(Some(_))) && large != small, "drawn anew for pictures of another size");
        assert_eq!(usher.look(larger, vec![], Nanos(4 + minute)), Seen::Nothing);
        assert_eq!(usher.look(larger, vec![], Nanos(5 + minute)), Seen::Over);
        std::fs::write(folder.path().join("new"), "rubbish").unwrap();
        std::fs::rename(folder.path().join("new"), &path).unwrap();
        assert_eq!(usher.look(larger, vec![], Nanos(6 + minute)), Seen::Told(None), "what makes no sense is not shown");
        tell("Wrong.");
        assert!(matches!(usher.look(larger, vec![], Nanos(7 + minute)), Seen::Told(Some(_))));
        std::fs::remove_file(&path).unwrap();
        assert_eq!(usher.look(larger, vec![], Nanos(8 + minute)), Seen::Over, "it was taken back");
        assert_eq!(usher.look(larger, vec![], Nanos(9 + minute)), Seen::Nothing);
    }
    #[test]
    fn what_is_wrong_is_shown_until_it_is_taken_back_and_again_after_what_is_told_for_a_moment() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("card");
        let tell = |path: &std::path::Path, text: &str| Notice { text: text.to_owned(), thousandths: None }.tell(path);
        let minute = u64::try_from(SHOWN.as_nanos()).unwrap();
        tell(&Lasting::Settings.path(&path), "dreams.toml is wrong.").unwrap();
        let mut usher = Usher::new(&path, u64::MAX);
        let wrong = usher.look(SIZE, vec![], Nanos(0));
        assert!(matches!(wrong, Seen::Told(Some(_))), "also if it was told long before this run: {wrong:?}");
        assert_eq!(usher.look(SIZE, vec![], Nanos(100 * minute)), Seen::Nothing, "it stays");
        tell(&path, "A new flock is here.").unwrap();
        let news = usher.look(SIZE, vec![], Nanos(100 * minute + 1));
        assert!(matches!(news, Seen::Told(Some(_))) && news != wrong);
        assert_eq!(usher.look(SIZE, vec![], Nanos(100 * minute + 2)), Seen::Nothing);
        assert_eq!(usher.look(SIZE, vec![], Nanos(101 * minute + 1)), wrong, "it comes back");
        tell(&Lasting::Settings.path(&path), "dreams.toml is still wrong.").unwrap();
        let still = usher.look(SIZE, vec![], Nanos(101 * minute + 2));
        assert!(matches!(still, Seen::Told(Some(_))) && still != wrong);
        Lasting::Settings.take_back(&path).unwrap();
        assert_eq!(usher.look(SIZE, vec![], Nanos(101 * minute + 3)), Seen::Over);
        Lasting::Settings.take_back(&path).expect("nothing is left to take back");
        assert_eq!(usher.look(SIZE, vec![], Nanos(101 * minute + 4)), Seen::Nothing);
    }

    #[test]
    fn what_the_display_does_not_do_is_shown_where_nothing_else_is() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("card");
        let mut usher = Usher::new(&path, u64::MAX);
        let notes = |text: &str| vec![text.to_owned(), "Another.".to_owned()];
        let first = usher.look(SIZE, notes("There is no connector DP-9."), Nanos(0));
        assert!(matches!(first, Seen::Told(Some(_))));
        assert_eq!(usher.look(SIZE, notes("There is no connector DP-9."), Nanos(1)), Seen::Nothing);
        Notice { text: "A new flock.".to_owned(), thousandths: None }.tell(&path).unwrap();
        assert!(matches!(usher.look(SIZE, notes("There is no connector DP-9."), Nanos(2)), Seen::Told(Some(_))));
        std::fs::remove_file(&path).unwrap();
        assert_eq!(usher.look(SIZE, notes("There is no connector DP-9."), Nanos(3)), first, "it comes back");
        assert_eq!(usher.look(SIZE, vec![], Nanos(4)), Seen::Over, "it was mended");
    }
}

//! A unit whose files are damaged by chance while it plays and updates.
//!
//! Owns the claim that the picture goes on, or comes back within half a minute, whatever happens to the player's state, the
//! store, its clips, the owner's settings and sticks; that the next good stick is installed; that nothing signed by a stranger
//! is played; and that no file outside the unit is changed. `DAMAGES` in the environment sets their number, and `DAMAGE_SEED` the chance.
//!
//! Start at [`the_picture_survives_damage_to_all_that_a_unit_reads`].

use claims::editions::edition;
use claims::flocks::{Flock, SMALL};
use claims::mutator::{Dice, varied};
use claims::owner::Settings;
use claims::player_run::{PlayerRun, RunningPlayer};
use claims::programs::claims_folder;
use claims::trace::Trace;
use claims::unit::Unit;
use claims::wait;
use rustix::fs::{CWD, FileType, Mode, mknodat};
use std::collections::BTreeMap;
use std::env;
use std::fs;
use std::io::{self, ErrorKind};
use std::mem;
use std::os::unix::fs::{MetadataExt, symlink};
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::Duration;
use tempfile::TempDir;

/// How many damages, unless `DAMAGES` says otherwise.
const DAMAGES: u64 = 20;
/// How long the picture may stand still, in seconds.
const PATIENCE_S: u32 = 30;
/// Frames after which it goes on: more than are decoded in advance.
const FRAMES: usize = 40;
/// How often the player may end in a row.
const ENDS: usize = 5;
/// How long an update may take, in seconds.
const UPDATE_S: u32 = 60;
/// One in so many damages is followed by a stick of a stranger, by a good one, and by a look at the store.
const STRANGER: u64 = 7;
const GOOD: u64 = 10;
/// An owner's file.
const OWNERS: &str = "unit = \"lobby\"\nrotate = 90\nhours = \"00:00-23:59\"\nclosed = [\"1999-12-31\"]\nntp = [\"ntp.example.org\"]\n\
                      brightness = \"07:00 100, 20:00 40\"\nmargin = 3\nurl = \"https://example.org/flocks\"\n";

/// Where damage is done.
#[derive(Clone, Copy, Debug)]
enum Place {
    State,
    Store,
    Clips,
    Settings,
    Stick,
}

const PLACES: [Place; 5] = [Place::State, Place::Store, Place::Clips, Place::Settings, Place::Stick];

/// Files that no program of a unit may change.
struct Outside {
    folder: TempDir,
    before: BTreeMap<PathBuf, (Vec<u8>, u32, i64)>,
}

impl Outside {
    fn new() -> Self {
        let folder = tempfile::tempdir_in(claims_folder()).unwrap();
        for name in ["passwd", "shadow", "flock.toml", "state"] {
            fs::write(folder.path().join(name), format!("{name} of the machine\n")).unwrap();
        }
        let before = Self::found(folder.path());
        Self { folder, before }
    }

    fn found(folder: &Path) -> BTreeMap<PathBuf, (Vec<u8>, u32, i64)> {
        files_below(folder)
            .into_iter()
            .map(|path| {
                let about = fs::symlink_metadata(&path).unwrap();
                (path.clone(), (fs::read(&path).unwrap(), about.mode(), about.mtime_nsec()))
            })
            .collect()
    }

    fn is_untouched(&self) -> bool {
        Self::found(self.folder.path()) == self.before
    }

    fn one(&self, dice: &mut Dice) -> PathBuf {
        dice.of_these(&self.before.keys().cloned().collect::<Vec<_>>()).clone()
    }
}

/// All that is no folder below `folder`.
fn files_below(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let mut found: Vec<_> = entries
        .flatten()
        .flat_map(
            |entry| if entry.file_type().unwrap().is_dir() { files_below(&entry.path()) } else { vec![entry.path()] },
        )
        .collect();
    found.sort();
    found
}

/// A unit with a player that runs.
struct Wall {
    unit: Unit,
    settings: Settings,
    outside: Outside,
    flock: Flock,
    playing: PlayerRun,
    running: RunningPlayer,
    /// Of the newest bundle.
    sequence: u64,
    /// How often the player was started again.
    starts: usize,
}

impl Wall {
    fn new() -> Self {
        let (flock, unit, settings) = (SMALL.flock(), Unit::new(), Settings::new());
        for (name, bytes) in edition(&flock, "spare") {
            let path = unit.path("spare").join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, bytes).unwrap();
        }
        let (code, said) = settings.set(OWNERS);
        assert_eq!(code, Some(0), "{said}");
        let [spare, owner] = [unit.path("spare"), settings.path("kept/dreams.toml")];
        let playing = PlayerRun::of(&unit.path("store/current"))
            .with(&["--screen", "virtual:320x240@60", "--status", "off", "--seed", "5", "--timezone", "UTC"])
            .with(&["--spare", spare.to_str().unwrap(), "--owner", owner.to_str().unwrap()]);
        let running = playing.start();
        let outside = Outside::new();
        let mut wall = Self { unit, settings, outside, flock, playing, running, sequence: 0, starts: 0 };
        wall.shows_good_stick("the first start");
        wall
    }

    /// Does one damage; returns which.
    fn damage(&self, place: Place, dice: &mut Dice) -> String {
        let store = self.unit.path("store");
        let is_clip = |path: &Path| path.starts_with(store.join("objects"));
        let mut paths = match place {
            Place::State => files_below(&self.playing.path("state")),
            Place::Store | Place::Clips => files_below(&store),
            Place::Settings => files_below(&self.settings.path("kept")),
            Place::Stick => files_below(&self.unit.stick()),
        };
        match place {
            Place::Store => paths.retain(|path| !is_clip(path)),
            Place::Clips => paths.retain(|path| is_clip(path)),
            Place::State | Place::Settings | Place::Stick => {}
        }
        if paths.is_empty() {
            return format!("nothing left of {place:?}");
        }
        let path = dice.of_these(&paths);
        let done = if dice.below(3) > 0 && fs::symlink_metadata(path).unwrap().is_file() {
            let mut bytes = fs::read(path).unwrap();
            let done = varied(&mut bytes, dice);
            fs::write(path, bytes).unwrap();
            done
        } else {
            self.replace(path, dice)
        };
        format!("{place:?} `{}`: {done}", path.display())
    }

    fn replace(&self, path: &Path, dice: &mut Dice) -> String {
        match dice.below(5) {
            0 => {
                put_instead(path, || Ok(()));
                "removed".to_owned()
            }
            1 => {
                put_instead(path, || Ok(mknodat(CWD, path, FileType::Fifo, Mode::from_raw_mode(0o644), 0)?));
                "a pipe instead".to_owned()
            }
            2 => {
                let to = self.outside.one(dice);
                put_instead(path, || symlink(&to, path));
                format!("a link to `{}` instead", to.display())
            }
            // What a program cannot write anew any more is not found again here.
            3 if path.starts_with(self.unit.path("")) => {
                put_instead(path, || fs::create_dir(path));
                "a folder instead".to_owned()
            }
            _ => {
                put_instead(path, || fs::write(path, ""));
                "an empty file instead".to_owned()
            }
        }
    }

    /// Has `dreams-update` look at the stick; returns its exit code.
    fn update(&self, what: &str) -> i32 {
        let mut command = self.unit.update_from(Some(&self.unit.stick()));
        let child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let said = wait::output(&format!("an update after {what}"), UPDATE_S, child);
        let error = String::from_utf8_lossy(&said.stderr);
        let code = said.status.code().unwrap_or_else(|| panic!("the update was killed after {what}: {error}"));
        assert!((0..=3).contains(&code), "the update ended with {code} after {what}: {error}");
        code
    }

    /// A stick that is as new.
    fn empty_stick(&self) {
        fs::remove_dir_all(self.unit.stick()).unwrap();
        fs::create_dir(self.unit.stick()).unwrap();
    }

    /// A new bundle of the artist, which the unit installs whatever its store has met.
    fn shows_good_stick(&mut self, what: &str) {
        self.sequence += 1;
        self.empty_stick();
        let files = edition(&self.flock, &format!("good-{}", self.sequence));
        self.unit.maker.bundle(&self.unit.stick(), &files, &[], self.sequence);
        assert_eq!(self.update(&format!("a good stick after {what}")), 0, "a good stick is installed after {what}");
    }

    /// A newer bundle, signed by a stranger.
    fn shows_strangers_stick(&self) {
        self.empty_stick();
        let files = edition(&self.flock, "stranger");
        self.unit.maker.forgery(&self.unit.stick(), &files, &[], self.sequence + 1_000);
        assert_ne!(self.update("a stranger's stick"), 0, "a stranger's stick is refused");
    }

    /// Has the owner's file damaged, too, which is then taken, or refused with a reason.
    fn set_damaged(&self, dice: &mut Dice) {
        let mut text = OWNERS.as_bytes().to_vec();
        varied(&mut text, dice);
        fs::write(self.settings.path("partition/dreams.toml"), text).unwrap();
        let child = self.settings.taking().stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let said = wait::output("the owner's settings", UPDATE_S, child);
        let error = String::from_utf8_lossy(&said.stderr);
        assert!(said.status.code().is_some_and(|code| (0..=3).contains(&code)), "{:?}: {error}", said.status);
    }

    /// The picture goes on, or comes back in time, and shows only what may be shown.
    fn goes_on(&mut self, what: &str) {
        let (mut shown, mut ends) = (0, 0);
        self.running.catch_up();
        while shown < FRAMES {
            let Some(line) = self.running.line_within(PATIENCE_S, what) else {
                ends += 1;
                assert!(ends <= ENDS, "the player ends again and again after {what}");
                self.start_again(what);
                continue;
            };
            for flip in Trace::parse(&line).flips {
                let is_allowed = ["spare/", "good-"].iter().any(|edition| flip.clip.starts_with(edition));
                assert!(is_allowed, "`{}` is shown after {what}", flip.clip);
                shown += 1;
            }
        }
    }

    /// As systemd does it, a second after it has ended.
    fn start_again(&mut self, what: &str) {
        self.starts += 1;
        std::thread::park_timeout(Duration::from_secs(1));
        let (code, _) = mem::replace(&mut self.running, self.playing.start()).end_within(1);
        assert!(code.is_none_or(|code| code != 101 && code != 2), "the player ended with {code:?} after {what}");
    }
}

/// Removes the file at `path` and has `put` put something in its place. The player may write it anew in between: then once
/// more.
fn put_instead(path: &Path, put: impl Fn() -> io::Result<()>) {
    let unless = |done: io::Result<()>, kind: ErrorKind| match done {
        Err(error) if error.kind() != kind => panic!("cannot damage `{}`: {error}", path.display()),
        other => other.is_ok(),
    };
    loop {
        unless(fs::remove_file(path), ErrorKind::NotFound);
        if unless(put(), ErrorKind::AlreadyExists) {
            return;
        }
    }
}

/// A number from the environment.
fn number(name: &str, otherwise: u64) -> u64 {
    env::var(name).map_or(otherwise, |text| text.parse().unwrap_or_else(|_| panic!("{name} is no number: {text}")))
}

#[test]
fn the_picture_survives_damage_to_all_that_a_unit_reads() {
    let (count, seed) = (number("DAMAGES", DAMAGES), number("DAMAGE_SEED", 1));
    let mut wall = Wall::new();
    wall.goes_on("the start");
    for at in 1..=count {
        let mut dice = Dice::of(seed << 32 | at);
        let place = PLACES[at as usize % PLACES.len()];
        let what = format!("damage {at} of seed {seed}: {}", wall.damage(place, &mut dice));
        if matches!(place, Place::Stick) {
            wall.update(&what);
        }
        if matches!(place, Place::Settings) && dice.chance(50) {
            wall.set_damaged(&mut dice);
        }
        if at % STRANGER == 0 {
            wall.shows_strangers_stick();
        }
        if at % GOOD == 0 {
            wall.settings.set(OWNERS);
            wall.shows_good_stick(&what);
        }
        wall.goes_on(&what);
        assert!(wall.outside.is_untouched(), "a file outside of the unit was changed after {what}");
    }
    println!("{count} damages; the player was started again {} times", wall.starts);
}

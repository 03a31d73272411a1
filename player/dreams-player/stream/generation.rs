//! The flock that is played: a plain folder, or a generation of the unit's store, perhaps on trial.
//!
//! Owns the course of a trial: so many joins shown win it, the first bad clip loses it; and when another flock is to be
//! played: the store has it, or the manifest of a plain folder is another one.
//! Never chooses a clip, never installs anything: the updater does, and moves the link that is read here.
//!
//! Start at [`Generation::open`].

use bundle::{CurrentGeneration, StoreError, TrialRecorder, Verdict};
use diagnostics::chain;
use flock::{Flock, Manifest, ManifestError};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use std::{fs, io, thread};
use timing::{Nanos, Rate};
use tracing::{info, warn};
use video::Form;

/// How often, and after which pause, a manifest is looked at that is about to be written.
const LOOKS_FOR_EDIT: u32 = 60;
const LOOK_PAUSE: Duration = Duration::from_millis(50);
/// How long another flock is played for one of which no clip can be, before that is tried again: storage may come back.
const STAND_IN_NS: u64 = 600_000_000_000;

/// A flock that can be played.
#[derive(Debug)]
pub(crate) struct Generation {
    pub(crate) flock: Arc<Flock>,
    pub(crate) folder: PathBuf,
    /// `None` for a plain folder.
    playing: Option<CurrentGeneration>,
    /// The manifest of a plain folder as it was when it was read.
    manifest: Option<ManifestFile>,
    /// The flock that this one is played for; `None` if it is itself what was asked for.
    awaited: Option<Awaited>,
    /// Its trial; `None` if it has passed.
    pub(crate) trial: Option<Arc<Trial>>,
}

/// The file of a manifest. Whoever edits it changes its length or its time.
#[derive(Debug)]
struct ManifestFile {
    /// The folder that it is in.
    folder: PathBuf,
    identity: Option<FileIdentity>,
}

/// A flock that another one is played for.
#[derive(Debug)]
struct Awaited {
    /// Where it is to be.
    path: PathBuf,
    /// If no clip of it could be played: its manifest, and when it is tried again all the same.
    barren: Option<(ManifestFile, Nanos)>,
}

/// Length, and the time of the last change in seconds and nanoseconds.
type FileIdentity = (u64, i64, i64);

/// What a screen is to show; size and rate until a flock of others comes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StreamFormat {
    /// The flock's frames per second.
    pub(crate) fps: Rate,
    /// Its pictures' size.
    pub(crate) size: (u32, u32),
    /// Whether the screen flips as fast as frames come, instead of by the time.
    pub(crate) free: bool,
}

impl StreamFormat {
    /// Of `flock`.
    pub(crate) fn of(flock: &Flock, free: bool) -> Self {
        Self { fps: flock.manifest().fps, size: flock.manifest().size, free }
    }
}

/// A trial that was on when this run came to the flock.
#[derive(Debug)]
pub(crate) struct Trial {
    recorder: TrialRecorder,
    number: u64,
    is_over: AtomicBool,
    is_excused: AtomicBool,
}

impl Generation {
    /// The flock at `path`; while there is none that can be read, the one at `spare`, if that can be.
    /// Errors: [`ManifestError`] of what is at `path`.
    pub(crate) fn open_or(path: &Path, spare: &Path) -> Result<Self, ManifestError> {
        Self::open(path).or_else(|error| {
            let Ok(standing_in) = Self::open(spare) else { return Err(error) };
            warn!(error = chain(&error), spare = %spare.display(), "cannot read the flock, playing the spare flock");
            Ok(standing_in.for_another(Awaited { path: path.to_owned(), barren: None }))
        })
    }

    /// The flock at `spare`, for the one at `path`, of which no clip can be played `now`. `None` if it cannot be read, or
    /// is played already.
    pub(crate) fn standing_in(&self, path: &Path, spare: &Path, now: Nanos) -> Option<Self> {
        let standing_in = Self::open(spare).ok().filter(|_| self.awaited.is_none())?;
        warn!(spare = %spare.display(), "the flock cannot be played, playing the spare flock");
        let barren = Some((ManifestFile::now(path), Nanos(now.0.saturating_add(STAND_IN_NS))));
        Some(standing_in.for_another(Awaited { path: path.to_owned(), barren }))
    }

    /// This one, played for another, which is the only one to go over to.
    fn for_another(self, awaited: Awaited) -> Self {
        Self { awaited: Some(awaited), manifest: None, ..self }
    }

    /// The flock at `path`: a folder, or the `current` of a store. A generation on trial that no player can read, or
    /// that was begun too often, has lost, and the one that comes back is opened.
    /// Errors: [`ManifestError`] if there is no flock to be read.
    pub(crate) fn open(path: &Path) -> Result<Self, ManifestError> {
        loop {
            let Some(playing) = playing(path) else {
                // Before it is read: an edit meanwhile, or a link that is moved, makes it another file.
                let manifest = Some(ManifestFile::now(path));
                // Whatever becomes of a link on the way, the clips are those of one flock.
                let folder = path.canonicalize().unwrap_or_else(|_| path.to_owned());
                let flock = Arc::new(Flock::new(Manifest::read_on_unit(&folder)?));
                return Ok(Self { flock, folder, playing: None, manifest, awaited: None, trial: None });
            };
            let trial = Trial::of(&playing);
            match (Manifest::read_on_unit(&playing.folder()), trial) {
                (Ok(manifest), trial) => {
                    let (flock, folder) = (Arc::new(Flock::new(manifest)), playing.folder());
                    let trial = trial.map(Arc::new);
                    return Ok(Self { flock, folder, playing: Some(playing), manifest: None, awaited: None, trial });
                }
                (Err(error), Some(trial)) if trial.lost(&chain(&error)) => {}
                (Err(error), _) => return Err(error),
            }
        }
    }

    /// The player begins to play it. `false` if it was begun too often: another one is to be played.
    pub(crate) fn begin(&mut self) -> bool {
        let verdict = self.trial.as_ref().map_or(Ok(Verdict::Open), |trial| trial.recorder.record_start(trial.number));
        match verdict {
            Ok(Verdict::Open | Verdict::Won) => true,
            Ok(Verdict::Lost) => {
                warn!("the new flock failed to start too often, going back to the previous one");
                self.trial = None;
                false
            }
            Err(error) => {
                not_recorded(&error);
                true
            }
        }
    }

    /// The form of its clips.
    pub(crate) fn form(&self) -> Form {
        Form { size: self.flock.manifest().size, fps: self.flock.manifest().fps }
    }

    /// Whether another flock is to be played `now`.
    pub(crate) fn is_over(&self, now: Nanos) -> bool {
        self.playing.as_ref().is_some_and(CurrentGeneration::is_replaced)
            || self.manifest.as_ref().is_some_and(ManifestFile::is_replaced)
            || self.awaited.as_ref().is_some_and(|awaited| awaited.has_come(now))
    }

    /// Whether the store has no flock any more: this one was its first, and failed its trial.
    pub(crate) fn is_withdrawn(&self) -> bool {
        self.playing.as_ref().is_some_and(CurrentGeneration::is_withdrawn)
    }

    /// Whether `next`, which comes after it, is the same folder with pictures of another size or rate. Its clips are still the
    /// old ones: they are rendered only after such an edit.
    pub(crate) fn is_to_be_rendered(&self, next: &Self) -> bool {
        self.manifest.is_some() && next.folder == self.folder && next.form() != self.form()
    }

    /// Whether a clip that is not the manifest's is another manifest's: who replaces a clip of a plain folder writes its hash
    /// next. Waits for that a while.
    pub(crate) fn is_being_replaced(&self) -> bool {
        let Some(manifest) = &self.manifest else { return false };
        for _ in 0..LOOKS_FOR_EDIT {
            if manifest.is_replaced() {
                return Manifest::read_on_unit(&manifest.folder).is_ok();
            }
            thread::park_timeout(LOOK_PAUSE);
        }
        false
    }

    /// A clip of it is not what it should be.
    pub(crate) fn failed(&mut self) {
        if let Some(trial) = self.trial.take() {
            trial.lost("a clip of it is bad");
        }
    }
}

impl Awaited {
    fn has_come(&self, now: Nanos) -> bool {
        let may_be_played = |(manifest, again): &(ManifestFile, Nanos)| manifest.is_replaced() || now >= *again;
        self.path.join(flock::FILE_NAME).is_file() && self.barren.as_ref().is_none_or(may_be_played)
    }
}

impl ManifestFile {
    /// That of the flock in `folder`.
    fn now(folder: &Path) -> Self {
        Self { folder: folder.to_owned(), identity: Self::identity(folder) }
    }

    fn identity(folder: &Path) -> Option<FileIdentity> {
        let about = fs::metadata(folder.join(flock::FILE_NAME)).ok()?;
        Some((about.len(), about.mtime(), about.mtime_nsec()))
    }

    /// Whether it is another file by now; not while there is none.
    fn is_replaced(&self) -> bool {
        let now = Self::identity(&self.folder);
        now.is_some() && now != self.identity
    }
}

impl Trial {
    fn of(playing: &CurrentGeneration) -> Option<Self> {
        let (recorder, number) = (playing.recorder().ok()?, playing.number());
        let no = || AtomicBool::new(false);
        recorder.is_on_trial(number).then_some(Self { recorder, number, is_over: no(), is_excused: no() })
    }

    /// A clip of it was on the glass to its end, as it should be.
    pub(crate) fn shown(&self) {
        if self.is_over.load(Ordering::Relaxed) {
            return;
        }
        match self.recorder.record_clip(self.number) {
            Ok(Verdict::Won) => {
                self.is_over.store(true, Ordering::Relaxed);
                info!(generation = self.number, "the new flock passed its trial");
            }
            Ok(Verdict::Open | Verdict::Lost) => {}
            Err(error) => not_recorded(&error),
        }
    }

    /// That this start shows nothing is not its fault: there is no display, or the run ended as it was told to.
    pub(crate) fn excused(&self) {
        let is_done = self.is_excused.swap(true, Ordering::Relaxed) || self.is_over.load(Ordering::Relaxed);
        if !is_done && let Err(error) = self.recorder.excuse_start(self.number) {
            not_recorded(&error);
        }
    }

    /// It cannot be played: the one before comes back. `false` if it is not on trial any more, or if that could not be
    /// written down.
    pub(crate) fn lost(&self, why: &str) -> bool {
        self.is_over.store(true, Ordering::Relaxed);
        match self.recorder.reject(self.number) {
            Ok(true) => {
                warn!(generation = self.number, why, "the new flock failed its trial, going back to the previous one");
                true
            }
            Ok(false) => false,
            Err(error) => {
                not_recorded(&error);
                false
            }
        }
    }
}

/// The generation that `path` names, if it is the link of a store.
fn playing(path: &Path) -> Option<CurrentGeneration> {
    match CurrentGeneration::of(path) {
        Ok(playing) => playing,
        // Reading the flock says what is missing.
        Err(error) if error.kind() == io::ErrorKind::NotFound => None,
        Err(error) => {
            warn!(path = %path.display(), error = chain(&error), "cannot read the store of flocks");
            None
        }
    }
}

fn not_recorded(error: &StoreError) {
    warn!(error = chain(error), "cannot record the state of the trial in the store of flocks");
}

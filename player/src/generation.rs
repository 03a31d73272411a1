//! The flock at hand: a plain folder, or a generation of the unit's store, perhaps on trial.
//!
//! Owns how a trial goes: it is won by playing so many joins, lost by the first clip that is not what it should be.
//! Never chooses a clip, never installs anything: the updater does, and moves the link that is read here.
//!
//! Start at [`Generation::open`].

use crate::report::chain;
use bundle::{Judge, Playing, StoreError, Verdict};
use flock::{Flock, Manifest, ManifestError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tracing::{info, warn};

/// The joins that win a trial.
const JOINS: u64 = 20;

/// A flock that can be played.
#[derive(Debug)]
pub(crate) struct Generation {
    pub(crate) flock: Arc<Flock>,
    pub(crate) folder: PathBuf,
    /// `None` for a plain folder.
    playing: Option<Playing>,
    /// Where the flock is to be that this one is played for; `None` if it is itself what was asked for.
    awaited: Option<PathBuf>,
    trial: Option<Trial>,
}

/// A trial that is on.
#[derive(Debug)]
pub(crate) struct Trial {
    judge: Judge,
    number: u64,
    joins: u64,
}

impl Generation {
    /// The flock at `path`; while there is none that can be read, the one at `spare`, if that can be.
    ///
    /// # Errors
    /// [`ManifestError`] of what is at `path`.
    pub(crate) fn open_or(path: &Path, spare: &Path) -> Result<Self, ManifestError> {
        Self::open(path).or_else(|error| {
            let Ok(standing_in) = Self::open(spare) else { return Err(error) };
            warn!(error = chain(&error), spare = %spare.display(), "the flock cannot be read: another one stands in");
            Ok(Self { awaited: Some(path.to_owned()), ..standing_in })
        })
    }

    /// The flock at `path`: a folder, or the `current` of a store. A generation on trial that no player can read, or
    /// that was begun too often, has lost, and the one that comes back is opened.
    ///
    /// # Errors
    /// [`ManifestError`] if there is no flock to be read.
    pub(crate) fn open(path: &Path) -> Result<Self, ManifestError> {
        loop {
            let Some(playing) = playing(path) else {
                // Whatever becomes of a link on the way, the clips are those of one flock.
                let folder = path.canonicalize().unwrap_or_else(|_| path.to_owned());
                let flock = Arc::new(Flock::new(Manifest::read(path)?));
                return Ok(Self { flock, folder, playing: None, awaited: None, trial: None });
            };
            let trial = Trial::of(&playing);
            match (Manifest::read(&playing.folder()), trial) {
                (Ok(manifest), trial) => {
                    let (flock, folder) = (Arc::new(Flock::new(manifest)), playing.folder());
                    return Ok(Self { flock, folder, playing: Some(playing), awaited: None, trial });
                }
                (Err(error), Some(trial)) if trial.lost(&chain(&error)) => {}
                (Err(error), _) => return Err(error),
            }
        }
    }

    /// The player begins to play it. `false` if it was begun too often: another one is to be played.
    pub(crate) fn begin(&mut self) -> bool {
        let verdict = self.trial.as_ref().map_or(Ok(Verdict::Open), |trial| trial.judge.started(trial.number));
        match verdict {
            Ok(Verdict::Open) => true,
            Ok(Verdict::Lost) => {
                warn!("the new flock was begun too often without success: the one before comes back");
                self.trial = None;
                false
            }
            Err(error) => {
                untold(&error);
                true
            }
        }
    }

    /// Whether another flock is to be played by now.
    pub(crate) fn is_over(&self) -> bool {
        let has_come = |path: &PathBuf| path.join(flock::FILE_NAME).is_file();
        self.playing.as_ref().is_some_and(Playing::is_over) || self.awaited.as_ref().is_some_and(has_come)
    }

    /// A clip of it was played to its end, as it should be.
    pub(crate) fn joined(&mut self) {
        let Some(trial) = &mut self.trial else { return };
        trial.joins += 1;
        if trial.joins < JOINS {
            return;
        }
        match trial.judge.won(trial.number) {
            Ok(()) => info!(generation = trial.number, "the new flock has proved itself"),
            Err(error) => untold(&error),
        }
        self.trial = None;
    }

    /// A clip of it is not what it should be. Returns whether that has lost a trial.
    pub(crate) fn failed(&mut self) -> bool {
        self.trial.take().is_some_and(|trial| trial.lost("a clip of it is bad"))
    }

    /// Its trial, to be judged by whoever cannot show it at all.
    pub(crate) fn trial(&self) -> Option<Trial> {
        self.playing.as_ref().and_then(Trial::of)
    }
}

impl Trial {
    fn of(playing: &Playing) -> Option<Self> {
        let (judge, number) = (playing.judge().ok()?, playing.number());
        judge.is_on_trial(number).then_some(Self { judge, number, joins: 0 })
    }

    /// It cannot be played: the one before comes back. `false` if that could not be written down.
    pub(crate) fn lost(&self, why: &str) -> bool {
        match self.judge.lost(self.number) {
            Ok(()) => {
                warn!(generation = self.number, why, "the new flock does not play: the one before comes back");
                true
            }
            Err(error) => {
                untold(&error);
                false
            }
        }
    }
}

/// The generation that `path` names, if it is the link of a store.
fn playing(path: &Path) -> Option<Playing> {
    match Playing::of(path) {
        Ok(playing) => playing,
        // Whoever reads the flock next says what is missing.
        Err(error) if error.kind() == io::ErrorKind::NotFound => None,
        Err(error) => {
            warn!(path = %path.display(), error = chain(&error), "the store cannot be looked at");
            None
        }
    }
}

fn untold(error: &StoreError) {
    warn!(error = chain(error), "the store does not learn how the trial of the new flock goes");
}

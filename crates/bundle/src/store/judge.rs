//! The player's side of a store: which generation plays, and how its trial goes.
//!
//! Owns what the player may do beside an updater that is at work: hold the generation that it plays, so that nobody
//! clears it away, and say that the one on trial was begun, was shown or is lost. Needs no keys, repairs nothing: a
//! store whose state is damaged is left to the updater.
//!
//! Start at [`Playing::of`], then [`Judge`].

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use crate::limits;
use crate::names::plain;
use crate::seal::Seal;
use crate::store::disk::{Disk, LocalDisk};
use crate::store::slots::{Read, Slots};
use crate::store::state::{State, Verdict};
use crate::store::{CURRENT, StoreError, at, flock_folder, follow, generation_folder};

/// How often the link is read again if its generation is cleared away just then.
const TRIES: u32 = 3;

/// A generation that is played. While this lives it stays on the disk.
#[derive(Debug)]
pub struct Playing {
    number: u64,
    store: PathBuf,
    /// Held for the lock on it.
    _folder: File,
}

/// Who says how a trial goes.
#[derive(Debug)]
pub struct Judge {
    disk: LocalDisk,
}

impl Playing {
    /// The generation that the link at `path` names, the `current` of a store; `None` if that is no such link, as with
    /// a flock in a plain folder.
    ///
    /// # Errors
    /// What the disk says; [`io::ErrorKind::NotFound`] if there is nothing at `path`.
    pub fn of(path: &Path) -> io::Result<Option<Self>> {
        let Some(store) = path.parent().filter(|_| path.ends_with(CURRENT)) else { return Ok(None) };
        let mut failed = io::Error::from(io::ErrorKind::NotFound);
        for _ in 0..TRIES {
            let disk = LocalDisk::beside(store)?;
            let Some(target) = disk.pointed(CURRENT)? else {
                // A folder of that name is a flock as any other.
                return if path.is_dir() { Ok(None) } else { Err(failed) };
            };
            let named = target.strip_prefix("generations/").and_then(|rest| plain(rest.strip_suffix("/flock")?));
            let Some(number) = named else { return Ok(None) };
            match disk.play(&generation_folder(number)) {
                Ok(folder) if disk.pointed(CURRENT)?.as_deref() == Some(&target) => {
                    return Ok(Some(Self { number, store: store.to_owned(), _folder: folder }));
                }
                Ok(_) => {}
                Err(error) => failed = error,
            }
        }
        Err(failed)
    }

    /// Its number.
    pub fn number(&self) -> u64 {
        self.number
    }

    /// The folder of its flock.
    pub fn folder(&self) -> PathBuf {
        self.store.join(flock_folder(self.number))
    }

    /// Its seal, as it was verified when it was installed, and whether it is on trial; `None` if the store does not say.
    pub fn standing(&self) -> Option<(Seal, bool)> {
        let disk = LocalDisk::beside(&self.store).ok()?;
        let Read::State { state, .. } = Slots::read(&disk).1 else { return None };
        let generation = state.kept().find(|generation| generation.number == self.number)?;
        let bytes = disk.read(&format!("{}/seal", generation_folder(self.number)), limits::SEAL).ok()?;
        let seal = Seal::kept(bytes, generation.signer, generation.seal).ok()?;
        Some((seal, on_trial(&state, self.number)))
    }

    /// Whether another one is to be played by now.
    pub fn is_over(&self) -> bool {
        let named = std::fs::read_link(self.store.join(CURRENT));
        named.is_ok_and(|target| target != Path::new(&flock_folder(self.number)))
    }

    /// Who judges it.
    ///
    /// # Errors
    /// What the disk says.
    pub fn judge(&self) -> io::Result<Judge> {
        Ok(Judge { disk: LocalDisk::beside(&self.store)? })
    }
}

impl Judge {
    /// Whether the generation `number` is on trial.
    pub fn is_on_trial(&self, number: u64) -> bool {
        match Slots::read(&self.disk).1 {
            Read::State { state, .. } => on_trial(&state, number),
            Read::Nothing | Read::Damaged | Read::Unread(_) => false,
        }
    }

    /// The player begins to play the generation `number`. A trial that was begun too often is lost by that.
    ///
    /// # Errors
    /// [`StoreError::Disk`].
    pub fn started(&self, number: u64) -> Result<Verdict, StoreError> {
        self.judge(number, State::started)
    }

    /// The last start of the generation `number` is not held against it, if it is still on trial.
    ///
    /// # Errors
    /// [`StoreError::Disk`]; the start counts then.
    pub fn excused(&self, number: u64) -> Result<(), StoreError> {
        self.change(number, State::excused).map(drop)
    }

    /// A clip of the generation `number` was on the glass to its end. A trial in which that was so often enough is won.
    ///
    /// # Errors
    /// [`StoreError::Disk`]; the clip does not count then.
    pub fn shown(&self, number: u64) -> Result<Verdict, StoreError> {
        self.judge(number, State::shown)
    }

    /// The generation `number` has proved itself, if it is still on trial.
    ///
    /// # Errors
    /// [`StoreError::Disk`]; the trial goes on then.
    pub fn won(&self, number: u64) -> Result<(), StoreError> {
        self.change(number, State::won).map(drop)
    }

    /// The generation `number` does not play: if it is still on trial, the last good one comes back, and the bundle
    /// is marked bad. Returns whether it was on trial.
    ///
    /// # Errors
    /// [`StoreError::Disk`]; the trial goes on then.
    pub fn lost(&self, number: u64) -> Result<bool, StoreError> {
        self.change(number, State::lost)
    }

    fn judge(&self, number: u64, judged: impl FnOnce(State) -> (State, Verdict)) -> Result<Verdict, StoreError> {
        let mut verdict = Verdict::Open;
        self.change(number, |state| {
            let (state, said) = judged(state);
            verdict = said;
            state
        })?;
        Ok(verdict)
    }

    /// Changes the state if the generation `number` is on trial; returns whether it is.
    fn change(&self, number: u64, change: impl FnOnce(State) -> State) -> Result<bool, StoreError> {
        let held = self.disk.hold().map_err(at("hold the state of", ""))?;
        let (mut slots, Read::State { state, .. }) = Slots::read(&self.disk) else { return Ok(false) };
        if !on_trial(&state, number) {
            return Ok(false);
        }
        let before = state.clone();
        let state = change(*state);
        if state == *before {
            return Ok(true);
        }
        slots.write(&self.disk, &state).map_err(at("write the state of", ""))?;
        let followed = follow(&self.disk, &state);
        drop(held);
        followed.map(|()| true)
    }
}

fn on_trial(state: &State, number: u64) -> bool {
    state.trial.as_ref().is_some_and(|trial| trial.generation.number == number)
}

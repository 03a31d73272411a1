//! The player's part of the store: the current generation, and its trial.
//!
//! Owns what the player does while an updater may be running: it locks the generation that it plays against removal,
//! and records the progress of its trial. It needs no keys and repairs nothing: a damaged state is left to the updater.
//!
//! Start at [`CurrentGeneration::of`], then [`TrialRecorder`].
#![allow(clippy::missing_errors_doc, reason = "a function that does not say otherwise fails with `StoreError::Disk`")]

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use durable::{Copies, Found, Storage};

use crate::limits;
use crate::names::parse_plain;
use crate::seal::Seal;
use crate::store::disk::{Disk, LocalDisk};
use crate::store::state::{State, Verdict};
use crate::store::{CURRENT, StoreError, at, flock_folder, generation_folder, update_link};

/// How often the link is read again if its generation is removed at the same time.
const TRIES: u32 = 3;

/// A generation that is played. It is not removed while this lives.
#[derive(Debug)]
pub struct CurrentGeneration {
    number: u64,
    store: PathBuf,
    /// Held for the lock on it.
    _folder: File,
}

/// Who says how a trial goes.
#[derive(Debug)]
pub struct TrialRecorder {
    disk: LocalDisk,
}

impl CurrentGeneration {
    /// The generation of the link at `path`, a store's `current`; `None` if it is not such a link, as with a flock in a
    /// plain folder.
    ///
    /// # Errors
    /// The disk's error; [`io::ErrorKind::NotFound`] if there is nothing at `path`.
    pub fn of(path: &Path) -> io::Result<Option<Self>> {
        let Some(store) = path.parent().filter(|_| path.ends_with(CURRENT)) else { return Ok(None) };
        let mut failed = io::Error::from(io::ErrorKind::NotFound);
        for _ in 0..TRIES {
            let disk = LocalDisk::open_shared(store)?;
            let Some(target) = disk.read_link(CURRENT)? else {
                // A folder of that name is an ordinary flock.
                return if path.is_dir() { Ok(None) } else { Err(failed) };
            };
            let named = target.strip_prefix("generations/").and_then(|rest| parse_plain(rest.strip_suffix("/flock")?));
            let Some(number) = named else { return Ok(None) };
            match disk.lock_generation(&generation_folder(number)) {
                Ok(folder) if disk.read_link(CURRENT)?.as_deref() == Some(&target) => {
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

    /// Its seal, which was verified at installation, and whether it is on trial; `None` if the store does not know it.
    pub fn status(&self) -> Option<(Seal, bool)> {
        let disk = LocalDisk::open_shared(&self.store).ok()?;
        let Found::<State>::State { state, .. } = Copies::read(&disk).1 else { return None };
        let generation = state.kept().find(|generation| generation.number == self.number)?;
        let bytes = disk.read(&format!("{}/seal", generation_folder(self.number)), limits::SEAL).ok()?;
        let seal = Seal::kept(bytes, generation.signer, generation.seal).ok()?;
        Some((seal, on_trial(&state, self.number)))
    }

    /// Whether another generation is current by now.
    pub fn is_replaced(&self) -> bool {
        let named = std::fs::read_link(self.store.join(CURRENT));
        named.is_ok_and(|target| target != Path::new(&flock_folder(self.number)))
    }

    /// Whether no generation is current by now: this one was the first, and was rejected.
    pub fn is_withdrawn(&self) -> bool {
        let named = std::fs::symlink_metadata(self.store.join(CURRENT));
        named.is_err_and(|error| error.kind() == io::ErrorKind::NotFound)
    }

    /// Who judges it.
    pub fn recorder(&self) -> io::Result<TrialRecorder> {
        Ok(TrialRecorder { disk: LocalDisk::open_shared(&self.store)? })
    }
}

impl TrialRecorder {
    /// Whether the generation `number` is on trial.
    pub fn is_on_trial(&self, number: u64) -> bool {
        match Copies::read(&self.disk).1 {
            Found::State { state, .. } => on_trial(&state, number),
            Found::Nothing | Found::Damaged | Found::Unreadable(_) => false,
        }
    }

    /// Records a start of the generation `number`. After too many starts it is rejected.
    pub fn record_start(&self, number: u64) -> Result<Verdict, StoreError> {
        self.recorder(number, State::record_start)
    }

    /// Takes the last start of the generation `number` back, if it is still on trial.
    ///
    /// # Errors
    /// [`StoreError::Disk`]; the start counts then.
    pub fn excuse_start(&self, number: u64) -> Result<(), StoreError> {
        self.change(number, State::excuse_start).map(drop)
    }

    /// Records a complete clip of the generation `number`. After enough of them it is accepted.
    ///
    /// # Errors
    /// [`StoreError::Disk`]; the clip does not count then.
    pub fn record_clip(&self, number: u64) -> Result<Verdict, StoreError> {
        self.recorder(number, State::record_clip)
    }

    /// Accepts the generation `number`, if it is still on trial.
    ///
    /// # Errors
    /// [`StoreError::Disk`]; the trial continues then.
    pub fn accept(&self, number: u64) -> Result<(), StoreError> {
        self.change(number, State::accept).map(drop)
    }

    /// Rejects the generation `number`: if it is still on trial, the last good one comes back, and the bundle is marked
    /// bad. Returns whether it was on trial.
    ///
    /// # Errors
    /// [`StoreError::Disk`]; the trial continues then.
    pub fn reject(&self, number: u64) -> Result<bool, StoreError> {
        self.change(number, State::reject)
    }

    fn recorder(&self, number: u64, judged: impl FnOnce(State) -> (State, Verdict)) -> Result<Verdict, StoreError> {
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
        let held = self.disk.lock_state().map_err(at("lock the state of", ""))?;
        let (mut copies, Found::State { state, .. }) = Copies::<State>::read(&self.disk) else { return Ok(false) };
        if !on_trial(&state, number) {
            return Ok(false);
        }
        let before = state.clone();
        let state = change(state);
        if state == before {
            return Ok(true);
        }
        copies.write_both(&self.disk, &state).map_err(at("write the state of", ""))?;
        let followed = update_link(&self.disk, &state);
        drop(held);
        followed.map(|()| true)
    }
}

fn on_trial(state: &State, number: u64) -> bool {
    state.trial.as_ref().is_some_and(|trial| trial.generation.number == number)
}

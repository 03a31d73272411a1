//! The store of a unit: content, shared by the flocks that were installed.
//!
//! Owns the order of writes. Objects are stored by digest, read-only; a *generation* is a folder of hard links to them,
//! in the layout of a flock; one symbolic link names the generation that plays. [`State`] decides its target, is saved
//! first, and is applied again at every [`Store::open`]. After a power cut at any step the unit has a complete,
//! verified flock: the old one or the new one. The updater decides when to act, and fetches.
//!
//! ```text
//! objects/3f/a91c...                     content, 0444, under fs-verity where there is that
//! aside/3fa91c...                        content that a look found damaged, until other has taken its place
//! incoming/3fa91c...                     content on its way: its length is how far it got
//! generations/12/{seal,contents,statements}   what vouched for it
//! generations/12/flock/...               the flock, as the player opens it
//! current -> generations/12/flock        what the player opens
//! state.0, state.1                       what is known, twice
//! system/...                             what is known of systems
//! ```
//!
//! An update: [`Store::admit`], [`Store::plan`], [`Store::intake`] for each object, [`Store::install`]; then
//! [`Store::accept`] or [`Store::reject`]; and when the player has switched, [`Store::collect`].
//!
//! Start at [`Store::open`].
#![allow(clippy::missing_errors_doc, reason = "a function that does not say otherwise fails with `StoreError::Disk`")]

mod disk;
mod install;
mod intake;
mod learned;
mod plan;
mod repair;
mod state;
mod state_file;
mod systems;
mod trial;
mod upkeep;

use std::collections::BTreeSet;
use std::io;

use durable::{Copies, Found};

use crate::contents::VerifiedBundle;
use crate::key::PublicKey;
use crate::limits;
use crate::names::{Addressees, ObjectId, UnitId};
use crate::refusal::Refusal;
use crate::seal::{Seal, UnverifiedSeal};
use crate::store::repair::QUARANTINE;
use crate::trust::{Trust, TrustUpdate};

pub use disk::{Disk, LocalDisk, Protection};
pub use intake::Intake;
pub use learned::with_learned;
pub use plan::{FetchItem, FetchPlan, Presence, Shortfall, plan};
pub use state::{Admission, Consent, Generation, JOINS, STARTS, State, Trial, Unknown, Verdict};
pub use systems::{StagedSystems, SystemAdmission};
pub use trial::{CurrentGeneration, TrialRecorder};
pub use upkeep::{Scrub, UnreadableObject};

/// The link to the flock that plays.
pub const CURRENT: &str = "current";
const INCOMING: &str = "incoming";
const GENERATIONS: &str = "generations";

/// The store of a unit.
pub struct Store {
    disk: Box<dyn Disk>,
    copies: Copies<State>,
    state: State,
    pinned: Trust,
    trust: Trust,
    /// The owner's keys for systems, without learned statements.
    system_pinned: Trust,
}

/// Errors of the store. The generation that plays stays.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The received data have the wrong digest and were removed.
    #[error("`{name}` was received damaged (expected digest {expected}, found {found})")]
    Damaged {
        /// Its name for people.
        name: String,
        /// Its digest as listed.
        expected: ObjectId,
        /// The digest of what arrived.
        found: ObjectId,
    },
    /// The disk failed.
    #[error("cannot {doing} `{path}`")]
    Disk {
        /// The failed operation.
        doing: &'static str,
        /// On what, within the store.
        path: String,
        /// The disk's error.
        source: io::Error,
    },
    /// The disk is failing.
    #[error("cannot read {unread} files of the store; the check was stopped")]
    Failing {
        /// How many files it did not give.
        unread: usize,
    },
    /// The source ended early. The partial file stays.
    #[error("`{name}` ended after {have} of {size} bytes")]
    Incomplete {
        /// Its name for people.
        name: String,
        /// How much there is.
        have: u64,
        /// How much there must be.
        size: u64,
    },
    /// Objects are missing for the installation.
    #[error("cannot install the flock: {missing} of its {objects} objects are missing")]
    Missing {
        /// How many are missing.
        missing: usize,
        /// How many it has.
        objects: usize,
    },
    /// The generation's files in the store are damaged.
    #[error("generation {number} of the store is damaged")]
    Generation {
        /// Which.
        number: u64,
        /// The cause.
        source: Refusal,
    },
    /// The bundle is refused.
    #[error("the bundle is refused")]
    Refused(#[source] Refusal),
    /// More bytes were received than listed. The file was removed.
    #[error("`{name}` is longer than its {size} bytes")]
    TooLong {
        /// Its name for people.
        name: String,
        /// How much there must be.
        size: u64,
    },
}

impl Store {
    /// Opens the store on `disk`, which may be empty, and completes what a power cut interrupted. `pinned` are the keys
    /// that the owner trusts.
    pub fn open(disk: Box<dyn Disk>, pinned: Trust) -> Result<Self, StoreError> {
        let _held = disk.lock_state().map_err(at("lock the state of", ""))?;
        for folder in ["objects", INCOMING, GENERATIONS, QUARANTINE] {
            disk.make_folder(folder).map_err(at("make folder", folder))?;
        }
        disk.sync_folder("").map_err(at("sync", ""))?;
        let (copies, found) = Copies::read(&*disk);
        let (trust, system_pinned) = (pinned.clone(), pinned.clone());
        let mut store = Self { disk, copies, state: State::default(), trust, pinned, system_pinned };
        match found {
            Found::Nothing => return Ok(store),
            Found::State { state, both } => {
                store.trust = trust_from(&store.pinned, &state.statements);
                store.state = state;
                if !both {
                    store.write()?;
                }
            }
            Found::Unreadable(error) => return Err(at("read the state of", "")(error)),
            Found::Damaged => {
                store.rebuild()?;
                store.write()?;
            }
        }
        store.learn_addressees()?;
        store.check_playing()?;
        update_link(&*store.disk, &store.state)?;
        Ok(store)
    }

    /// The state of the store.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// The keys that this unit trusts, with all learned statements.
    pub fn trust(&self) -> &Trust {
        &self.trust
    }

    /// Accepts systems only from `keys` and those that they have added: a separate role.
    #[must_use]
    pub fn with_system_keys(self, keys: Trust) -> Self {
        Self { system_pinned: keys, ..self }
    }

    /// The keys whose systems this unit accepts, with all learned statements.
    pub fn system_trust(&self) -> Trust {
        trust_from(&self.system_pinned, &self.state.statements)
    }

    /// Learns a bundle's statements; returns the changes, and the statements above quota. Statements of keys without
    /// permission are ignored.
    ///
    /// # Errors
    /// [`StoreError::Disk`] if they could not be saved; nothing was learned then.
    pub fn learn(&mut self, file: &[u8]) -> Result<TrustUpdate, StoreError> {
        let mut trust = self.trust.clone();
        let lesson = trust.learn_all(file);
        if !lesson.news.is_empty() {
            let counted: BTreeSet<&str> = self.trust.said().collect();
            // Statements of a key that the owner has removed are kept, because the key may come back.
            let silent = self.state.statements.iter().filter(|text| !counted.contains(text.as_str())).cloned();
            let statements: Vec<String> = silent.chain(trust.said().map(str::to_owned)).collect();
            self.change(|state| State { statements, ..state })?;
        }
        Ok(lesson)
    }

    /// Whether the bundle behind `seal` may be installed on `unit`.
    ///
    /// # Errors
    /// [`Refusal::ForEverybody`], [`Refusal::ForOthers`], [`Refusal::MarkedBad`] or [`Refusal::Older`].
    pub fn admit(&self, seal: &Seal, unit: &UnitId, consent: Consent) -> Result<Admission, Refusal> {
        self.state.admit(seal, unit, consent)
    }

    /// Whether `unverified` is the seal of the generation that plays.
    pub fn is_current(&self, unverified: &UnverifiedSeal) -> bool {
        self.state.playing().is_some_and(|playing| playing.seal == ObjectId::of(unverified.bytes()))
    }

    /// The objects to fetch for the bundle.
    pub fn plan(&self, bundle: &VerifiedBundle) -> Result<FetchPlan, StoreError> {
        plan(bundle.contents(), |file| self.presence(&file.id, file.size))
    }

    /// The room that is left, in bytes.
    pub fn free_bytes(&self) -> Result<u64, StoreError> {
        self.disk.free_bytes().map_err(at("measure the room of", ""))
    }

    /// Records a start of the current generation. After too many starts it is rejected.
    pub fn record_start(&mut self) -> Result<Verdict, StoreError> {
        let mut verdict = Verdict::Open;
        self.change(|state| {
            let (state, said) = state.record_start();
            verdict = said;
            state
        })?;
        Ok(verdict)
    }

    /// Accepts the generation on trial: it is the last good one from now on.
    ///
    /// # Errors
    /// [`StoreError::Disk`]; the trial continues then.
    pub fn accept(&mut self) -> Result<(), StoreError> {
        self.change(State::accept)
    }

    /// Rejects the generation on trial: the last good one comes back, and the bundle is marked bad.
    pub fn reject(&mut self) -> Result<(), StoreError> {
        self.change(State::reject)
    }

    /// Drops the last good generation, which cannot be repaired: the one before it comes back, if there is one.
    pub fn drop_good(&mut self) -> Result<(), StoreError> {
        self.change(State::drop_good)
    }

    /// Drops the generation before the last good one, for its space. [`Store::collect`] frees it.
    pub fn drop_reserve(&mut self) -> Result<(), StoreError> {
        self.change(State::drop_before)
    }

    /// Changes the state, saves it, and then updates the link.
    fn change(&mut self, change: impl FnOnce(State) -> State) -> Result<(), StoreError> {
        let held = self.disk.lock_state().map_err(at("lock the state of", ""))?;
        if held.is_some()
            && let (copies, Found::State { state, .. }) = Copies::read(&*self.disk)
        {
            // The player may have judged since.
            (self.copies, self.state) = (copies, state);
        }
        let state = change(self.state.clone());
        if state == self.state {
            return Ok(());
        }
        let before = std::mem::replace(&mut self.state, state);
        if let Err(error) = self.write() {
            self.state = before;
            return Err(error);
        }
        self.trust = trust_from(&self.pinned, &self.state.statements);
        update_link(&*self.disk, &self.state)
    }

    fn write(&mut self) -> Result<(), StoreError> {
        self.copies.write_both(&*self.disk, &self.state).map_err(at("write the state of", ""))
    }

    /// Reads the addressees of generations from their seals, where an older program did not save them.
    fn learn_addressees(&mut self) -> Result<(), StoreError> {
        let state = self.state.clone().addressed(|generation| self.sealed_for(generation));
        if state == self.state {
            return Ok(());
        }
        self.state = state;
        self.write()
    }

    /// The addressees in the seal of `generation`, if it can be read.
    fn sealed_for(&self, generation: &Generation) -> Option<Addressees> {
        let bytes = self.disk.read(&format!("{}/seal", generation_folder(generation.number)), limits::SEAL).ok()?;
        let seal = Seal::kept(bytes, generation.signer, generation.seal).ok()?;
        Some(seal.letter().addressees.clone())
    }

    /// Drops the generation that plays if its folder is missing, after damage of the file system, and cannot be restored.
    fn check_playing(&mut self) -> Result<(), StoreError> {
        while let Some(playing) = self.state.playing().cloned() {
            let toml = format!("{}/{}", flock_folder(playing.number), flock::FILE_NAME);
            let is_there = || self.disk.length(&toml).map_err(at("look at", &toml));
            if is_there()?.is_some() {
                break;
            }
            if let Ok(bundle) = self.bundle(&playing) {
                self.link_again(&playing, &bundle)?;
            }
            if is_there()?.is_some() {
                break;
            }
            self.state = self.state.clone().drop_playing();
            self.write()?;
        }
        Ok(())
    }

    fn presence(&self, id: &ObjectId, size: u64) -> Result<Presence, StoreError> {
        let length = |path: &str| self.disk.length(path).map_err(at("look at", path));
        if length(&id.path())? == Some(size) {
            return Ok(Presence::Whole);
        }
        Ok(length(&incoming(id))?.map_or(Presence::Nothing, Presence::Part))
    }

    /// Rebuilds the state from the generations, if both copies of it are damaged.
    fn rebuild(&mut self) -> Result<(), StoreError> {
        let pointed = self.disk.read_link(CURRENT).map_err(at("read link", CURRENT))?;
        for name in self.disk.list(GENERATIONS).map_err(at("list", GENERATIONS))? {
            let Some(number) = crate::names::parse_plain(&name) else { continue };
            self.state.newest = self.state.newest.max(number);
            let Some(generation) = self.verified_generation(number)? else { continue };
            let floor = self.state.floors.entry(generation.signer).or_insert(generation.sequence);
            *floor = generation.sequence.max(*floor);
            let plays = pointed.as_deref() == Some(&flock_folder(number));
            let newer = |good: &Generation| generation.number > good.number;
            if plays {
                self.state.before = self.state.good.replace(generation);
            } else if self.state.before.as_ref().is_none_or(newer) {
                self.state.before = Some(generation);
            }
        }
        if self.state.good.is_none() {
            self.state.good = self.state.before.take();
        }
        self.state.addressees = self.state.good.as_ref().and_then(|good| good.addressees.clone());
        Ok(())
    }

    /// The generation in the folder `number`, if its signature is valid.
    fn verified_generation(&mut self, number: u64) -> Result<Option<Generation>, StoreError> {
        let folder = generation_folder(number);
        let said = self.read_if_present(&format!("{folder}/statements"), limits::STATE)?.unwrap_or_default();
        self.trust.relearn(&said);
        self.state.statements = self.trust.said().map(str::to_owned).collect();
        let bytes = self.read_if_present(&format!("{folder}/seal"), limits::SEAL)?;
        let Some(Ok(seal)) = bytes.map(|bytes| UnverifiedSeal::new(bytes).verify(&self.trust)) else { return Ok(None) };
        let (letter, id) = (seal.letter(), seal.id());
        let (flock, signer, sequence) = (letter.flock.clone(), seal.signer(), letter.sequence);
        let addressees = Some(letter.addressees.clone());
        Ok(Some(Generation { number, flock, signer, sequence, seal: id, addressees, unknown: Unknown::new() }))
    }

    /// The file at `path`; `None` if there is none, or it is too large.
    fn read_if_present(&self, path: &str, limit: u64) -> Result<Option<Vec<u8>>, StoreError> {
        match self.disk.read(path, limit) {
            Ok(bytes) => Ok(Some(bytes)),
            // A read error may pass, so it does not count as missing.
            Err(error) if error.raw_os_error() == Some(rustix::io::Errno::IO.raw_os_error()) => {
                Err(at("read", path)(error))
            }
            Err(_) => Ok(None),
        }
    }
}

impl std::fmt::Debug for Store {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let keys: Vec<_> = self.trust.keys().map(PublicKey::id).collect();
        f.debug_struct("Store").field("state", &self.state).field("keys", &keys).finish_non_exhaustive()
    }
}

/// Updates the link from the state.
fn update_link(disk: &dyn Disk, state: &State) -> Result<(), StoreError> {
    let wanted = state.playing().map(|generation| flock_folder(generation.number));
    let found = disk.read_link(CURRENT).map_err(at("read link", CURRENT))?;
    if wanted == found {
        return Ok(());
    }
    let switch = || -> io::Result<()> {
        match &wanted {
            Some(target) => {
                let temporary = format!("{CURRENT}.new");
                disk.remove(&temporary)?;
                disk.symlink(&temporary, target)?;
                disk.rename(&temporary, CURRENT)?;
            }
            None => disk.remove(CURRENT)?,
        }
        disk.sync_folder("")
    };
    switch().map_err(at("switch", CURRENT))
}

/// The owner's keys with the learned statements.
fn trust_from(pinned: &Trust, statements: &[String]) -> Trust {
    let mut trust = pinned.clone();
    trust.relearn(statements.concat().as_bytes());
    trust
}

fn generation_folder(number: u64) -> String {
    format!("{GENERATIONS}/{number}")
}

fn flock_folder(number: u64) -> String {
    format!("{GENERATIONS}/{number}/flock")
}

fn incoming(id: &ObjectId) -> String {
    format!("{INCOMING}/{id}")
}

/// The error of `doing` on `path`.
fn at(doing: &'static str, path: &str) -> impl FnOnce(io::Error) -> StoreError {
    let path = path.to_owned();
    move |source| StoreError::Disk { doing, path, source }
}

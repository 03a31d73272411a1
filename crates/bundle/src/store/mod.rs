//! The store of a unit: content, shared by the flocks that were installed.
//!
//! Owns the order in which things reach the disk. Content lies under its digest, read-only; a *generation* is a folder
//! of hard links to it, in the shape of a flock; one symbolic link says which generation plays. What that link must
//! say is decided in [`State`], written down first, and made true again at every [`Store::open`]. Whatever step the
//! power fails at, the unit has a complete, verified flock: the old one or the new one. Never decides when to act,
//! never fetches: the updater does both.
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
//! [`Store::won`] or [`Store::lost`]; and when the player has changed over, [`Store::collect`].
//!
//! Start at [`Store::open`].

mod disk;
mod install;
mod intake;
mod judge;
mod plan;
mod repair;
mod slots;
mod state;
mod systems;
mod upkeep;

use std::collections::BTreeSet;
use std::io;

use crate::contents::Verified;
use crate::key::PublicKey;
use crate::limits;
use crate::names::{Addressees, ObjectId, UnitId};
use crate::refused::Refused;
use crate::seal::{Seal, Unverified};
use crate::store::repair::ASIDE;
use crate::store::slots::{Read, Slots};
use crate::trust::{Lesson, Trust};

pub use disk::{Append, Disk, Frozen, LocalDisk};
pub use intake::Intake;
pub use judge::{Judge, Playing};
pub use plan::{Held, Plan, Shortfall, Wanted, plan};
pub use state::{Admission, Consent, Generation, JOINS, STARTS, State, Trial, Unknown, Verdict};
pub use systems::SystemAdmission;
pub use upkeep::{Scrubbed, Unread};

/// The link that says which flock plays.
pub const CURRENT: &str = "current";
const INCOMING: &str = "incoming";
const GENERATIONS: &str = "generations";

/// The store of a unit.
pub struct Store {
    disk: Box<dyn Disk>,
    slots: Slots,
    state: State,
    pinned: Trust,
    trust: Trust,
    /// Who may sign systems, before anything was learned.
    system_pinned: Trust,
}

/// Why the store could not do it. What plays is what played before.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// What arrived is not what was listed. It was thrown away.
    #[error("`{name}` arrived damaged (expected {expected}, found {found})")]
    Damaged {
        /// What people know it by.
        name: String,
        /// Its digest as listed.
        expected: ObjectId,
        /// The digest of what arrived.
        found: ObjectId,
    },
    /// The disk failed.
    #[error("cannot {doing} `{path}`")]
    Disk {
        /// What was tried.
        doing: &'static str,
        /// On what, within the store.
        path: String,
        /// What the disk says.
        source: io::Error,
    },
    /// The disk does not give what it holds.
    #[error("cannot read {unread} files of the store, and looked at no more")]
    Failing {
        /// How many files it did not give.
        unread: usize,
    },
    /// It ended before it was whole. What there is stays, to be continued.
    #[error("`{name}` ended after {have} of {size} bytes")]
    Incomplete {
        /// What people know it by.
        name: String,
        /// How much there is.
        have: u64,
        /// How much there must be.
        size: u64,
    },
    /// Not everything was fetched before it was to be installed.
    #[error("cannot install the flock: {missing} of its {objects} objects are missing")]
    Missing {
        /// How many are missing.
        missing: usize,
        /// How many it has.
        objects: usize,
    },
    /// What lies in the store is not what was verified once.
    #[error("generation {number} of the store is damaged")]
    Generation {
        /// Which.
        number: u64,
        /// What is wrong with it.
        source: Refused,
    },
    /// The bundle is refused.
    #[error("the bundle is refused")]
    Refused(#[source] Refused),
    /// More bytes arrived than were listed. They were thrown away.
    #[error("`{name}` is longer than its {size} bytes")]
    TooLong {
        /// What people know it by.
        name: String,
        /// How much there must be.
        size: u64,
    },
}

impl Store {
    /// Opens the store on `disk`, which may be empty, and makes true again what a power cut left half done. `pinned`
    /// are the keys that the owner trusts.
    ///
    /// # Errors
    /// [`StoreError::Disk`].
    pub fn open(disk: Box<dyn Disk>, pinned: Trust) -> Result<Self, StoreError> {
        let _held = disk.hold().map_err(at("hold the state of", ""))?;
        for folder in ["objects", INCOMING, GENERATIONS, ASIDE] {
            disk.make_folder(folder).map_err(at("make folder", folder))?;
        }
        disk.sync_folder("").map_err(at("sync", ""))?;
        let (slots, read) = Slots::read(&*disk);
        let (trust, system_pinned) = (pinned.clone(), pinned.clone());
        let mut store = Self { disk, slots, state: State::default(), trust, pinned, system_pinned };
        match read {
            Read::Nothing => return Ok(store),
            Read::State { state, both } => {
                store.trust = trusting(&store.pinned, &state.statements);
                store.state = *state;
                if !both {
                    store.write()?;
                }
            }
            Read::Unread(error) => return Err(at("read the state of", "")(error)),
            Read::Damaged => {
                store.rebuild()?;
                store.write()?;
            }
        }
        store.learn_addressees()?;
        store.stand()?;
        follow(&*store.disk, &store.state)?;
        Ok(store)
    }

    /// What is known of the flocks of this unit.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Whom this unit trusts, all statements learned so far taken into account.
    pub fn trust(&self) -> &Trust {
        &self.trust
    }

    /// Takes systems from `keys` and from whom they have taken in, and from nobody else: a role of its own.
    #[must_use]
    pub fn with_system_keys(self, keys: Trust) -> Self {
        Self { system_pinned: keys, ..self }
    }

    /// Whose systems this unit takes, all statements learned so far taken into account.
    pub fn system_trust(&self) -> Trust {
        trusting(&self.system_pinned, &self.state.statements)
    }

    /// Learns from the file of statements that a bundle carries; returns what was new, and what was too much. What is
    /// said by someone who may not say it is passed over.
    ///
    /// # Errors
    /// [`StoreError::Disk`] if it could not be kept; it was not learned then.
    pub fn learn(&mut self, file: &[u8]) -> Result<Lesson, StoreError> {
        let mut trust = self.trust.clone();
        let lesson = trust.learn_all(file);
        if !lesson.news.is_empty() {
            let counted: BTreeSet<&str> = self.trust.said().collect();
            // The owner may have taken away the key that said so, and may give it back.
            let silent = self.state.statements.iter().filter(|text| !counted.contains(text.as_str())).cloned();
            let statements: Vec<String> = silent.chain(trust.said().map(str::to_owned)).collect();
            self.change(|state| State { statements, ..state })?;
        }
        Ok(lesson)
    }

    /// Whether the bundle behind `seal` may be installed on `unit`.
    ///
    /// # Errors
    /// [`Refused::ForEverybody`], [`Refused::ForOthers`], [`Refused::MarkedBad`] or [`Refused::Older`].
    pub fn admit(&self, seal: &Seal, unit: &UnitId, consent: Consent) -> Result<Admission, Refused> {
        self.state.admit(seal, unit, consent)
    }

    /// Whether `unverified` is the seal of the generation that plays: there is no news then.
    pub fn is_no_news(&self, unverified: &Unverified) -> bool {
        self.state.playing().is_some_and(|playing| playing.seal == ObjectId::of(unverified.bytes()))
    }

    /// What has to be fetched for the bundle.
    ///
    /// # Errors
    /// [`StoreError::Disk`].
    pub fn plan(&self, bundle: &Verified) -> Result<Plan, StoreError> {
        plan(bundle.contents(), |file| self.held(&file.id, file.size))
    }

    /// The room that is left, in bytes.
    ///
    /// # Errors
    /// [`StoreError::Disk`].
    pub fn room(&self) -> Result<u64, StoreError> {
        self.disk.room().map_err(at("measure the room of", ""))
    }

    /// Whoever plays begins to play what is current. A trial that was begun too often is lost by that.
    ///
    /// # Errors
    /// [`StoreError::Disk`].
    pub fn started(&mut self) -> Result<Verdict, StoreError> {
        let mut verdict = Verdict::Open;
        self.change(|state| {
            let (state, said) = state.started();
            verdict = said;
            state
        })?;
        Ok(verdict)
    }

    /// The generation on trial has proved itself: it is the last good one from now on.
    ///
    /// # Errors
    /// [`StoreError::Disk`]; the trial goes on then.
    pub fn won(&mut self) -> Result<(), StoreError> {
        self.change(State::won)
    }

    /// The generation on trial does not play: the last good one comes back, and the bundle is marked bad.
    ///
    /// # Errors
    /// [`StoreError::Disk`].
    pub fn lost(&mut self) -> Result<(), StoreError> {
        self.change(State::lost)
    }

    /// The last good generation is beyond repair: the one before it comes back, if there is one.
    ///
    /// # Errors
    /// [`StoreError::Disk`].
    pub fn good_is_gone(&mut self) -> Result<(), StoreError> {
        self.change(State::good_is_gone)
    }

    /// Gives up the reserve, the generation before the last good one, for its room. [`Store::collect`] frees it.
    ///
    /// # Errors
    /// [`StoreError::Disk`].
    pub fn give_up_reserve(&mut self) -> Result<(), StoreError> {
        self.change(State::without_reserve)
    }

    /// Changes the state as it stands now, writes it down, and then makes the disk follow.
    fn change(&mut self, change: impl FnOnce(State) -> State) -> Result<(), StoreError> {
        let held = self.disk.hold().map_err(at("hold the state of", ""))?;
        if held.is_some()
            && let (slots, Read::State { state, .. }) = Slots::read(&*self.disk)
        {
            // The player may have judged since.
            (self.slots, self.state) = (slots, *state);
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
        self.trust = trusting(&self.pinned, &self.state.statements);
        follow(&*self.disk, &self.state)
    }

    fn write(&mut self) -> Result<(), StoreError> {
        self.slots.write(&*self.disk, &self.state).map_err(at("write the state of", ""))
    }

    /// Learns from their seals for whom the generations are of which an older program did not write it down.
    fn learn_addressees(&mut self) -> Result<(), StoreError> {
        let state = self.state.clone().addressed(|generation| self.sealed_for(generation));
        if state == self.state {
            return Ok(());
        }
        self.state = state;
        self.write()
    }

    /// For whom the seal says that `generation` is, if it can be read.
    fn sealed_for(&self, generation: &Generation) -> Option<Addressees> {
        let bytes = self.disk.read(&format!("{}/seal", generation_folder(generation.number)), limits::SEAL).ok()?;
        let seal = Seal::kept(bytes, generation.signer, generation.seal).ok()?;
        Some(seal.letter().addressees.clone())
    }

    /// Gives up what plays if its folder is gone, which only a damaged file system can have done, and nothing in the
    /// store mends it.
    fn stand(&mut self) -> Result<(), StoreError> {
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
            self.state = self.state.clone().vanished();
            self.write()?;
        }
        Ok(())
    }

    fn held(&self, id: &ObjectId, size: u64) -> Result<Held, StoreError> {
        let length = |path: &str| self.disk.length(path).map_err(at("look at", path));
        if length(&id.path())? == Some(size) {
            return Ok(Held::Whole);
        }
        Ok(length(&incoming(id))?.map_or(Held::Nothing, Held::Part))
    }

    /// What is known, from the generations themselves: both copies of the state are damaged.
    fn rebuild(&mut self) -> Result<(), StoreError> {
        let pointed = self.disk.pointed(CURRENT).map_err(at("read link", CURRENT))?;
        for name in self.disk.list(GENERATIONS).map_err(at("list", GENERATIONS))? {
            let Some(number) = crate::names::plain(&name) else { continue };
            self.state.newest = self.state.newest.max(number);
            let Some(generation) = self.vouched(number)? else { continue };
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

    /// The generation in the folder `number`, as far as its signature can tell; `None` if it cannot.
    fn vouched(&mut self, number: u64) -> Result<Option<Generation>, StoreError> {
        let folder = generation_folder(number);
        let said = self.paper(&format!("{folder}/statements"), limits::STATE)?.unwrap_or_default();
        self.trust.recall(&said);
        self.state.statements = self.trust.said().map(str::to_owned).collect();
        let bytes = self.paper(&format!("{folder}/seal"), limits::SEAL)?;
        let Some(Ok(seal)) = bytes.map(|bytes| Unverified::new(bytes).verify(&self.trust)) else { return Ok(None) };
        let (letter, id) = (seal.letter(), seal.id());
        let (flock, signer, sequence) = (letter.flock.clone(), seal.signer(), letter.sequence);
        let addressees = Some(letter.addressees.clone());
        Ok(Some(Generation { number, flock, signer, sequence, seal: id, addressees, unknown: Unknown::new() }))
    }

    /// What lies at `path`; `None` if there is nothing, or nothing that can be what it should.
    fn paper(&self, path: &str, limit: u64) -> Result<Option<Vec<u8>>, StoreError> {
        match self.disk.read(path, limit) {
            Ok(bytes) => Ok(Some(bytes)),
            // A disk that does not answer may do so later: nothing is given up for that.
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

/// Makes the link say what the state says.
fn follow(disk: &dyn Disk, state: &State) -> Result<(), StoreError> {
    let wanted = state.playing().map(|generation| flock_folder(generation.number));
    let found = disk.pointed(CURRENT).map_err(at("read link", CURRENT))?;
    if wanted == found {
        return Ok(());
    }
    let switch = || -> io::Result<()> {
        match &wanted {
            Some(target) => {
                let temporary = format!("{CURRENT}.new");
                disk.remove(&temporary)?;
                disk.point(&temporary, target)?;
                disk.rename(&temporary, CURRENT)?;
            }
            None => disk.remove(CURRENT)?,
        }
        disk.sync_folder("")
    };
    switch().map_err(at("switch", CURRENT))
}

/// Whom the owner trusts, and whom they vouched for since.
fn trusting(pinned: &Trust, statements: &[String]) -> Trust {
    let mut trust = pinned.clone();
    trust.recall(statements.concat().as_bytes());
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

/// The error of trying `doing` on `path`.
fn at(doing: &'static str, path: &str) -> impl FnOnce(io::Error) -> StoreError {
    let path = path.to_owned();
    move |source| StoreError::Disk { doing, path, source }
}

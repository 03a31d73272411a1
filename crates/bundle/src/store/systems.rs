//! Systems in the store, before they are written to a slot.
//!
//! Owns the admission of systems and the seals of those received: that of a complete system is *staged*, and *written*
//! once it is in a slot. Each system is written only once: one that does not start is replaced by the one before, and
//! is not tried again. Another user than the store's writes the slot, through [`StagedSystems`]: it reads the store, and
//! changes nothing but names in the folder `system`, which its group may write to.
//!
//! ```text
//! system/staged         the seal of a system whose halves are here, to be written
//! system/written.KEY    the seal of the last one of that key that was written
//! system/dropped        the seal of one that is not to be written, until its halves are removed
//! ```
//!
//! Start at [`Store::admit_system`] and [`StagedSystems::open`].
#![allow(clippy::missing_errors_doc, reason = "a function that does not say otherwise fails with `StoreError::Disk`")]

use std::io::{self, ErrorKind, Read};

use durable::{Copies, Found, Storage, parent, replace};

use crate::limits;
use crate::names::{ObjectId, UnitId, Version};
use crate::refusal::Refusal;
use crate::store::disk::Disk;
use crate::store::plan::{FetchPlan, plan_of};
use crate::store::state::{Consent, Generation, State};
use crate::store::{LocalDisk, Store, StoreError, at, trust_from};
use crate::system::{System, UnverifiedSystem};
use crate::trust::Trust;

const FOLDER: &str = "system";
const STAGED: &str = "system/staged";
const DROPPED: &str = "system/dropped";

/// The decision on a system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SystemAdmission {
    /// It, or a newer one, is running, staged, or was written before.
    Known,
    /// It is to be fetched and staged.
    New,
}

impl Store {
    /// Whether `unit`, which runs the version `running`, may fetch `system`.
    ///
    /// # Errors
    /// [`StoreError::Refused`] if it is for other units, or not newer than the last one of its key; [`StoreError::Disk`].
    pub fn admit_system(
        &self,
        system: &System,
        unit: &UnitId,
        running: &Version,
        consent: Consent,
    ) -> Result<SystemAdmission, StoreError> {
        let (release, signer) = (system.release(), system.signer());
        let refused = |refused| Err(StoreError::Refused(refused));
        // Systems for all units are admitted also by units that have flocks of their own.
        release.addressees.admit(unit, None).map_err(StoreError::Refused)?;
        if release.version <= *running {
            return Ok(SystemAdmission::Known);
        }
        if self.staged()?.is_some_and(|staged| staged == *system) {
            return Ok(SystemAdmission::Known);
        }
        let written = self.sealed(&written(system))?.filter(|_| consent == Consent::Newer);
        match written {
            Some(written) if written == *system => Ok(SystemAdmission::Known),
            Some(written) if written.release().sequence >= release.sequence => {
                let (sequence, floor) = (release.sequence, written.release().sequence);
                refused(Refusal::Older { sequence, floor, signer })
            }
            Some(_) | None => Ok(SystemAdmission::New),
        }
    }

    /// The objects to fetch for the system.
    pub fn plan_system(&self, system: &System) -> Result<FetchPlan, StoreError> {
        plan_of(&system.halves(), |half| self.presence(&half.id, half.size))
    }

    /// Stages the system, whose halves must have been fetched, for writing. It replaces one that was staged before.
    ///
    /// # Errors
    /// [`StoreError::Missing`], or [`StoreError::Disk`].
    pub fn stage(&self, system: &System) -> Result<(), StoreError> {
        let plan = self.plan_system(system)?;
        if !plan.wanted.is_empty() {
            return Err(StoreError::Missing { missing: plan.wanted.len(), objects: plan.objects });
        }
        let lay = |disk: &dyn Disk| -> io::Result<()> {
            disk.make_folder(FOLDER)?;
            for half in system.halves() {
                disk.sync_folder(parent(&half.id.path()))?;
            }
            disk.sync_folder("objects")?;
            replace(disk, STAGED, system.bytes())?;
            disk.sync_folder("")
        };
        lay(&*self.disk).map_err(at("stage", FOLDER))
    }

    /// The staged system, if its signature is trusted.
    pub fn staged(&self) -> Result<Option<System>, StoreError> {
        self.sealed(STAGED)
    }

    /// Removes the halves of a system that was dropped, so that they are fetched again, and then its seal.
    pub fn remove_dropped(&self) -> Result<(), StoreError> {
        let Some(dropped) = self.sealed(DROPPED)? else { return Ok(()) };
        let halves = dropped.halves().map(|half| half.id.path());
        for path in halves.iter().map(String::as_str).chain([DROPPED]) {
            self.disk.remove(path).map_err(at("remove", path))?;
        }
        self.disk.sync_folder(FOLDER).map_err(at("sync", FOLDER))
    }

    /// The system whose seal lies at `path`.
    fn sealed(&self, path: &str) -> Result<Option<System>, StoreError> {
        sealed(&*self.disk, path, &self.system_trust())
    }
}

/// The systems that wait in a store, for the user that writes slots. Holds the updater's lock.
pub struct StagedSystems {
    disk: LocalDisk,
    state: State,
    trust: Trust,
}

impl StagedSystems {
    /// Opens the store on `disk`, which is only read; accepts systems of `keys` and of those that they have added.
    ///
    /// # Errors
    /// [`StoreError::Disk`], also if the state of the store is damaged: which keys are revoked is unknown then.
    pub fn open(disk: LocalDisk, keys: &Trust) -> Result<Self, StoreError> {
        let state = match Copies::read(&disk).1 {
            Found::State { state, .. } => state,
            Found::Nothing => State::default(),
            Found::Unreadable(error) => return Err(at("read the state of", "")(error)),
            Found::Damaged => {
                let damaged = io::Error::new(ErrorKind::InvalidData, "both copies are damaged");
                return Err(at("read the state of", "")(damaged));
            }
        };
        let trust = trust_from(keys, &state.statements);
        Ok(Self { disk, state, trust })
    }

    /// The generation that plays.
    pub fn playing(&self) -> Option<&Generation> {
        self.state.playing()
    }

    /// The staged system, if its signature is trusted.
    pub fn staged(&self) -> Result<Option<System>, StoreError> {
        sealed(&self.disk, STAGED, &self.trust)
    }

    /// Opens an object, such as half a system, for reading.
    pub fn object(&self, id: &ObjectId) -> Result<Box<dyn Read + '_>, StoreError> {
        Disk::open(&self.disk, &id.path()).map_err(at("open", &id.path()))
    }

    /// Marks the staged system as written. When this returns, that survives a power cut.
    pub fn mark_written(&self, system: &System) -> Result<(), StoreError> {
        self.rename_staged(&written(system))
    }

    /// Drops the staged system. [`Store::remove_dropped`] removes its halves.
    pub fn drop_staged(&self) -> Result<(), StoreError> {
        self.rename_staged(DROPPED)
    }

    fn rename_staged(&self, to: &str) -> Result<(), StoreError> {
        let moved = self.disk.rename(STAGED, to).and_then(|()| self.disk.sync_folder(FOLDER));
        moved.map_err(at("rename", to))
    }
}

/// The system whose seal lies at `path`, if `trust` trusts its signature.
fn sealed<D: Disk + ?Sized>(disk: &D, path: &str, trust: &Trust) -> Result<Option<System>, StoreError> {
    match disk.read(path, limits::SEAL) {
        Ok(bytes) => Ok(UnverifiedSystem::new(bytes).verify(trust).ok()),
        Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::FileTooLarge) => Ok(None),
        Err(error) => Err(at("read", path)(error)),
    }
}

/// The path of the seal of the last written system of the same key.
fn written(system: &System) -> String {
    format!("{FOLDER}/written.{}", system.signer())
}

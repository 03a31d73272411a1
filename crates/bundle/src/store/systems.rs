//! Systems on their way through the store.
//!
//! Owns which system may come, and what is remembered of those that came: the seal of one that is complete is *staged*,
//! and *written* once it lies in a slot. A system is written once, whatever becomes of it there: one that does not start
//! gives way to the one before, and is not tried for ever. Never touches a slot: the updater does.
//!
//! ```text
//! system/staged         the seal of a system whose halves are here, to be written
//! system/written.KEY    the seal of the last one of that key that was written
//! ```
//!
//! Start at [`Store::admit_system`].

use std::io::{self, ErrorKind, Read};

use crate::limits;
use crate::names::{ObjectId, UnitId, Version};
use crate::refused::Refused;
use crate::store::disk::{Disk, folder_of, replace};
use crate::store::plan::{Plan, plan_of};
use crate::store::state::Consent;
use crate::store::{Store, StoreError, at};
use crate::system::{System, UnverifiedSystem};

const FOLDER: &str = "system";
const STAGED: &str = "system/staged";

/// What becomes of a system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SystemAdmission {
    /// It runs, or a newer one does; or it waits to be written, or had its chance.
    Known,
    /// It is to be fetched and staged.
    New,
}

impl Store {
    /// Whether `system` may come to `unit`, which runs the version `running`.
    ///
    /// # Errors
    /// [`StoreError::Refused`] if it is for others, or not newer than another one of its key; [`StoreError::Disk`].
    pub fn admit_system(
        &self,
        system: &System,
        unit: &UnitId,
        running: &Version,
        consent: Consent,
    ) -> Result<SystemAdmission, StoreError> {
        let (release, signer) = (system.release(), system.signer());
        let refused = |refused| Err(StoreError::Refused(refused));
        // Whoever has flocks of its own is mended like all others: a system says nothing about what is on the wall.
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
                refused(Refused::Older { sequence, floor, signer })
            }
            Some(_) | None => Ok(SystemAdmission::New),
        }
    }

    /// What has to be fetched for the system.
    ///
    /// # Errors
    /// [`StoreError::Disk`].
    pub fn plan_system(&self, system: &System) -> Result<Plan, StoreError> {
        plan_of(&system.halves(), |half| self.held(&half.id, half.size))
    }

    /// The system, whose halves must have been taken in, is to be written. It takes the place of one that was not yet.
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
                disk.sync_folder(folder_of(&half.id.path()))?;
            }
            disk.sync_folder("objects")?;
            replace(disk, STAGED, system.bytes())?;
            disk.sync_folder("")
        };
        lay(&*self.disk).map_err(at("stage", FOLDER))
    }

    /// The system that is to be written. What a trusted key did not sign is not one.
    ///
    /// # Errors
    /// [`StoreError::Disk`].
    pub fn staged(&self) -> Result<Option<System>, StoreError> {
        self.sealed(STAGED)
    }

    /// Opens an object that is here, such as half a system, to be read from end to end.
    ///
    /// # Errors
    /// [`StoreError::Disk`].
    pub fn object(&self, id: &ObjectId) -> Result<Box<dyn Read + '_>, StoreError> {
        self.disk.open(&id.path()).map_err(at("open", &id.path()))
    }

    /// The staged system lies in its slot. When this returns, no power cut brings it there again.
    ///
    /// # Errors
    /// [`StoreError::Disk`].
    pub fn settle(&self, system: &System) -> Result<(), StoreError> {
        let written = written(system);
        let moved = self.disk.rename(STAGED, &written).and_then(|()| self.disk.sync_folder(FOLDER));
        moved.map_err(at("rename", &written))
    }

    /// The staged system can't be written: what is here of it goes, so that it is fetched anew.
    ///
    /// # Errors
    /// [`StoreError::Disk`].
    pub fn unstage(&self, system: &System) -> Result<(), StoreError> {
        let paths = system.halves().map(|half| half.id.path());
        for path in [STAGED].into_iter().chain(paths.iter().map(String::as_str)) {
            self.disk.remove(path).map_err(at("remove", path))?;
        }
        self.disk.sync_folder(FOLDER).map_err(at("sync", FOLDER))
    }

    /// The system whose seal lies at `path`.
    fn sealed(&self, path: &str) -> Result<Option<System>, StoreError> {
        match self.disk.read(path, limits::SEAL) {
            Ok(bytes) => Ok(UnverifiedSystem::new(bytes).verify(&self.system_trust()).ok()),
            Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::FileTooLarge) => Ok(None),
            Err(error) => Err(at("read", path)(error)),
        }
    }
}

/// Where the seal of the last written system of the same key lies.
fn written(system: &System) -> String {
    format!("{FOLDER}/written.{}", system.signer())
}

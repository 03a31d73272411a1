//! An object that is being fetched into the store.
//!
//! Owns its partial file, and verifies it before it becomes an object. It can be dropped at any moment and continued later.
//!
//! Start at [`Store::intake`](crate::Store::intake).
#![allow(clippy::missing_errors_doc, reason = "a function that does not say otherwise fails with `StoreError::Disk`")]

use std::io;

use durable::{Append, parent};

use crate::names::ObjectId;
use crate::store::disk::{Disk, Protection};
use crate::store::plan::FetchItem;
use crate::store::{Store, StoreError, at, incoming};

/// Bytes between two syncs: a power cut loses no more than that, and the player's reads do not wait for gigabytes of
/// dirty pages.
const FLUSH_EVERY: u64 = 8 << 20;

/// An object that is being taken in.
pub struct Intake<'s> {
    disk: &'s dyn Disk,
    wanted: FetchItem,
    path: String,
    /// `None` if it is complete and read-only already.
    file: Option<Box<dyn Append + 's>>,
    hasher: blake3::Hasher,
    have: u64,
    unsynced: u64,
}

impl Store {
    /// Starts to fetch an object, or continues an earlier attempt.
    pub fn intake(&self, wanted: &FetchItem) -> Result<Intake<'_>, StoreError> {
        let (disk, path) = (&*self.disk, incoming(&wanted.id));
        let mut hasher = blake3::Hasher::new();
        let there = disk.length(&path).map_err(at("look at", &path))?;
        if there.is_some() {
            // A partial file that cannot be read, or is too long, is started again.
            let read = disk.open(&path).and_then(|reader| hasher.update_reader(reader).map(|_| ()));
            if read.is_err() || hasher.count() > wanted.size {
                hasher.reset();
                disk.remove(&path).map_err(at("remove", &path))?;
            }
        }
        let file = match disk.append(&path) {
            // It was made read-only, and the power failed before the rename.
            Err(error) if error.kind() == io::ErrorKind::PermissionDenied => {
                if digest(&hasher) == wanted.id {
                    Ok(None)
                } else {
                    hasher.reset();
                    disk.remove(&path).and_then(|()| disk.append(&path)).map(Some)
                }
            }
            file => file.map(Some),
        };
        let (file, have) = (file.map_err(at("open", &path))?, hasher.count());
        Ok(Intake { disk, wanted: wanted.clone(), path, file, hasher, have, unsynced: 0 })
    }
}

impl Intake<'_> {
    /// Bytes received so far: the offset at which to continue.
    pub fn have(&self) -> u64 {
        self.have
    }

    /// How many bytes are missing.
    pub fn missing(&self) -> u64 {
        self.wanted.size - self.have
    }

    /// Takes the next bytes.
    ///
    /// # Errors
    /// [`StoreError::TooLong`], or [`StoreError::Disk`]. After an error the intake must be dropped; the partial file
    /// stays valid.
    pub fn append(&mut self, bytes: &[u8]) -> Result<(), StoreError> {
        if bytes.len() as u64 > self.missing() {
            self.discard()?;
            return Err(StoreError::TooLong { name: self.name(), size: self.wanted.size });
        }
        let Some(file) = &mut self.file else { return Ok(()) };
        self.hasher.update(bytes);
        file.write_all(bytes).map_err(at("write", &self.path))?;
        self.have += bytes.len() as u64;
        self.unsynced += bytes.len() as u64;
        if self.unsynced >= FLUSH_EVERY { self.sync() } else { Ok(()) }
    }

    /// Verifies the complete file and makes it a read-only object.
    ///
    /// # Errors
    /// [`StoreError::Incomplete`] if bytes are missing: the partial file stays. [`StoreError::Damaged`] if the digest
    /// is wrong: it is removed. [`StoreError::Disk`].
    pub fn finish(mut self) -> Result<Protection, StoreError> {
        if self.missing() > 0 {
            self.sync()?;
            return Err(StoreError::Incomplete { name: self.name(), have: self.have, size: self.wanted.size });
        }
        let found = digest(&self.hasher);
        if found != self.wanted.id {
            self.discard()?;
            return Err(StoreError::Damaged { name: self.name(), expected: self.wanted.id, found });
        }
        self.sync()?;
        let Self { disk, wanted, path, file, .. } = self;
        // fs-verity requires that the file is not open for writing.
        drop(file);
        let frozen = disk.make_read_only(&path).map_err(at("freeze", &path))?;
        let object = wanted.id.path();
        let publish = || -> io::Result<()> {
            disk.make_folder(parent(&object))?;
            disk.rename(&path, &object)
        };
        publish().map_err(at("keep", &object))?;
        Ok(frozen)
    }

    fn sync(&mut self) -> Result<(), StoreError> {
        self.unsynced = 0;
        // After a failed sync the data on the disk are unknown: the page cache may still show what is lost.
        let synced = self.file.as_mut().map_or(Ok(()), |file| file.sync());
        if synced.is_err() {
            self.discard()?;
        }
        synced.map_err(at("sync", &self.path))
    }

    fn discard(&self) -> Result<(), StoreError> {
        self.disk.remove(&self.path).map_err(at("remove", &self.path))
    }

    fn name(&self) -> String {
        self.wanted.path.to_string()
    }
}

/// The digest of the bytes received so far.
fn digest(hasher: &blake3::Hasher) -> ObjectId {
    ObjectId::new(*hasher.finalize().as_bytes())
}

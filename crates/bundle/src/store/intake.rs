//! One object on its way into the store.
//!
//! Owns the file that grows, and that nothing but the right bytes ever becomes an object. It can be dropped at any
//! moment and taken up again where it was. Never knows where the bytes come from.
//!
//! Start at [`Store::intake`](crate::Store::intake).

use std::io;

use crate::names::ObjectId;
use crate::store::disk::{Append, Disk, Frozen, folder_of};
use crate::store::plan::Wanted;
use crate::store::{Store, StoreError, at, incoming};

/// After so many bytes, what was written is sent to the disk: a power cut costs no more than that, and the player never
/// waits for its clips behind gigabytes of ours.
const FLUSH_EVERY: u64 = 8 << 20;

/// An object that is being taken in.
pub struct Intake<'s> {
    disk: &'s dyn Disk,
    wanted: Wanted,
    path: String,
    /// `None` if all is there already, and nobody may write to it any more.
    file: Option<Box<dyn Append + 's>>,
    hasher: blake3::Hasher,
    have: u64,
    unsynced: u64,
}

impl Store {
    /// Begins to take in an object, or goes on where that was left.
    ///
    /// # Errors
    /// [`StoreError::Disk`].
    pub fn intake(&self, wanted: &Wanted) -> Result<Intake<'_>, StoreError> {
        let (disk, path) = (&*self.disk, incoming(&wanted.id));
        let mut hasher = blake3::Hasher::new();
        let there = disk.length(&path).map_err(at("look at", &path))?;
        if there.is_some() {
            // A part that cannot be read, or is longer than it can be, is begun again.
            let read = disk.open(&path).and_then(|reader| hasher.update_reader(reader).map(|_| ()));
            if read.is_err() || hasher.count() > wanted.size {
                hasher.reset();
                disk.remove(&path).map_err(at("remove", &path))?;
            }
        }
        let file = match disk.append(&path) {
            // It was frozen, and the power failed before it got its name.
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
    /// How many bytes there are: where to go on.
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
    /// [`StoreError::TooLong`] if they are more than there can be, or [`StoreError::Disk`]. After an error the intake
    /// must be dropped; what is kept of it is sound.
    pub fn take(&mut self, bytes: &[u8]) -> Result<(), StoreError> {
        if bytes.len() as u64 > self.missing() {
            self.throw_away()?;
            return Err(StoreError::TooLong { name: self.name(), size: self.wanted.size });
        }
        let Some(file) = &mut self.file else { return Ok(()) };
        self.hasher.update(bytes);
        file.write_all(bytes).map_err(at("write", &self.path))?;
        self.have += bytes.len() as u64;
        self.unsynced += bytes.len() as u64;
        if self.unsynced >= FLUSH_EVERY { self.sync() } else { Ok(()) }
    }

    /// Ends the intake when all bytes are there: checks them, and makes them an object that will not change.
    ///
    /// # Errors
    /// [`StoreError::Incomplete`] if there are not enough: what there is stays. [`StoreError::Damaged`] if they are
    /// others than were listed: they are thrown away. [`StoreError::Disk`].
    pub fn finish(mut self) -> Result<Frozen, StoreError> {
        if self.missing() > 0 {
            self.sync()?;
            return Err(StoreError::Incomplete { name: self.name(), have: self.have, size: self.wanted.size });
        }
        let found = digest(&self.hasher);
        if found != self.wanted.id {
            self.throw_away()?;
            return Err(StoreError::Damaged { name: self.name(), expected: self.wanted.id, found });
        }
        self.sync()?;
        let Self { disk, wanted, path, file, .. } = self;
        // fs-verity wants nobody to have the file open for writing.
        drop(file);
        let frozen = disk.freeze(&path).map_err(at("freeze", &path))?;
        let object = wanted.id.path();
        let publish = || -> io::Result<()> {
            disk.make_folder(folder_of(&object))?;
            disk.rename(&path, &object)
        };
        publish().map_err(at("keep", &object))?;
        Ok(frozen)
    }

    fn sync(&mut self) -> Result<(), StoreError> {
        self.unsynced = 0;
        // When the disk fails here, nobody knows what it has: memory would read back what is lost.
        let synced = self.file.as_mut().map_or(Ok(()), |file| file.sync());
        if synced.is_err() {
            self.throw_away()?;
        }
        synced.map_err(at("sync", &self.path))
    }

    fn throw_away(&self) -> Result<(), StoreError> {
        self.disk.remove(&self.path).map_err(at("remove", &self.path))
    }

    fn name(&self) -> String {
        self.wanted.path.to_string()
    }
}

/// Which object it is, if it ends here.
fn digest(hasher: &blake3::Hasher) -> ObjectId {
    ObjectId::new(*hasher.finalize().as_bytes())
}

//! A bundle in a folder: on a stick, for a web server, or beside its flock.
//!
//! Writes it so that a reader at the same time, or after the stick was pulled, finds the old bundle or the new one:
//! objects are written and synced first, then the seals, each by a rename. Existing objects are not written again. No file
//! is a hard link to one elsewhere: whoever writes into it, or into its original, changes nothing else. File systems
//! without links or with limited file size (FAT) are supported. Reading goes through [`Source`].
//!
//! Start at [`Folder::create`] and [`Folder::open`].
#![allow(clippy::missing_errors_doc, reason = "every operation fails with `FolderError`")]

mod parts;
mod seals;
mod statements;
mod upkeep;

use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::os::fd::AsFd;
use std::path::{Path, PathBuf};

use durable::Storage;
use rustix::fs::{Mode, OFlags};

use crate::beneath::Root;
use crate::limits;
use crate::names::ObjectId;
use crate::source::Source;
use parts::{FAT_LARGEST, Parts, part_path, parts};

pub use upkeep::Sweep;

/// What `statfs` calls FAT.
const FAT: i64 = 0x4d44;
/// How much is copied at a time.
const CHUNK: usize = 256 << 10;

/// A folder that holds bundles.
#[derive(Debug)]
pub struct Folder {
    root: Root,
    path: PathBuf,
    /// The largest file that it can hold.
    largest: u64,
}

/// How an object came into a folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PutMethod {
    /// Its blocks are shared with the original, until one of the two is written to.
    Cloned,
    /// Its bytes were copied.
    Copied,
    /// It was there.
    Kept,
}

/// Errors of reading or writing a folder of bundles.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    /// The source has changed, or is damaged.
    #[error("`{path}` has changed (expected digest {expected}, found {found})")]
    Changed {
        /// The file.
        path: PathBuf,
        /// Its digest as listed.
        expected: ObjectId,
        /// The digest of what was read.
        found: ObjectId,
    },
    /// It could not be read.
    #[error("cannot read `{path}`")]
    Read {
        /// What.
        path: PathBuf,
        /// The system error.
        source: io::Error,
    },
    /// It could not be written.
    #[error("cannot write `{path}`")]
    Write {
        /// What.
        path: PathBuf,
        /// The system error.
        source: io::Error,
    },
}

impl Folder {
    /// Opens the folder at `path` for reading.
    pub fn open(path: &Path) -> Result<Self, FolderError> {
        let root = Root::open(path).map_err(|source| FolderError::Read { path: path.to_owned(), source })?;
        let kind = rustix::fs::fstatfs(&root).map(|status| status.f_type).unwrap_or_default();
        let largest = if kind == FAT { FAT_LARGEST } else { u64::MAX };
        Ok(Self { root, path: path.to_owned(), largest })
    }

    /// Opens the folder at `path` for writing, and creates it if necessary.
    pub fn create(path: &Path) -> Result<Self, FolderError> {
        fs::create_dir_all(path).map_err(|source| FolderError::Write { path: path.to_owned(), source })?;
        Self::open(path)
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether the object is there, judged by its size. A file with a second name is not: what is written to one would
    /// change the other.
    pub fn holds(&self, id: &ObjectId, size: u64) -> bool {
        self.is_complete(&id.path(), size)
    }

    /// Whether `file` can be cloned into this folder, which takes no room.
    pub fn clones(&self, file: &File) -> bool {
        // A file without a name, so that an interrupted run leaves nothing.
        let probe = self.root.at(".", OFlags::WRONLY | OFlags::TMPFILE, 0o600);
        probe.is_ok_and(|probe| rustix::fs::ioctl_ficlone(probe, file).is_ok())
    }

    /// Adds the file at `from`: by a reflink where the file system has that, otherwise by a copy. Later changes of one of
    /// the two do not change the other. `moved` is called with the bytes copied or read.
    ///
    /// # Errors
    /// [`FolderError`]; the object was not added.
    pub fn put_file(
        &self,
        id: &ObjectId,
        size: u64,
        from: &Path,
        moved: &mut dyn FnMut(u64),
    ) -> Result<PutMethod, FolderError> {
        let path = id.path();
        if self.is_complete(&path, size) {
            return Ok(PutMethod::Kept);
        }
        let unread = |source| FolderError::Read { path: from.to_owned(), source };
        let mut file = File::open(from).map_err(unread)?;
        if size <= self.largest {
            self.room_for(&path)?;
            let temporary = temporary(&path);
            if self.clone(&file, &temporary).is_ok() {
                self.verify_clone(id, &temporary, from, moved)?;
                self.rename(&temporary, &path)?;
                return Ok(PutMethod::Cloned);
            }
            self.clear(&temporary)?;
        }
        self.put(id, size, &mut file, from, moved)
    }

    /// Adds the contents of `from`. `moved` is called with the bytes copied; `name` is used in errors.
    ///
    /// # Errors
    /// [`FolderError`]; the object was not added.
    pub fn put(
        &self,
        id: &ObjectId,
        size: u64,
        from: &mut dyn Read,
        name: &Path,
        moved: &mut dyn FnMut(u64),
    ) -> Result<PutMethod, FolderError> {
        let path = id.path();
        if self.is_complete(&path, size) {
            return Ok(PutMethod::Kept);
        }
        self.room_for(&path)?;
        let mut hasher = blake3::Hasher::new();
        let parts: Vec<(String, u64)> = parts(&path, size, self.largest);
        let copy =
            |(part, length): &(String, u64)| self.copy(&temporary(part), *length, from, name, &mut hasher, moved);
        let copied = parts.iter().try_for_each(copy).and_then(|()| check_id(id, &hasher, name));
        if copied.is_err() {
            // A partial object is removed, to free its space.
            for (part, _) in &parts {
                self.clear(&temporary(part)).ok();
            }
        }
        copied?;
        // The first part is renamed last: without it the object does not exist.
        for (part, _) in parts.iter().rev() {
            self.rename(&temporary(part), part)?;
        }
        Ok(PutMethod::Copied)
    }

    /// Syncs all added objects.
    pub fn sync(&self) -> Result<(), FolderError> {
        rustix::fs::syncfs(&self.root).map_err(|error| self.unwritten("")(error.into()))
    }

    /// Whether `path`, or its parts together, have `size` bytes, and no second name.
    fn is_complete(&self, path: &str, size: u64) -> bool {
        match self.root.length(path) {
            Ok(Some(length)) => length == size && self.root.has_one_name(path).unwrap_or(false),
            Ok(None) => {
                let lengths =
                    (0..limits::PARTS).map_while(|part| self.root.length(&part_path(path, part)).ok().flatten());
                let lengths: Vec<u64> = lengths.collect();
                !lengths.is_empty() && lengths.iter().sum::<u64>() == size
            }
            Err(_) => false,
        }
    }

    fn room_for(&self, path: &str) -> Result<(), FolderError> {
        let mut folder = String::new();
        for part in path.split('/').take(path.split('/').count() - 1) {
            if !folder.is_empty() {
                folder.push('/');
            }
            folder.push_str(part);
            let made = self
                .root
                .parent(&folder)
                .and_then(|(parent, name)| Ok(rustix::fs::mkdirat(parent, name, Mode::from_raw_mode(0o755))?));
            match made {
                Err(error) if error.kind() != io::ErrorKind::AlreadyExists => {
                    return Err(self.unwritten(&folder)(error));
                }
                Ok(()) | Err(_) => {}
            }
        }
        Ok(())
    }

    fn clone(&self, from: &File, to: &str) -> io::Result<()> {
        let to = self.new_file(to)?;
        rustix::fs::ioctl_ficlone(&to, from)?;
        Ok(())
    }

    fn copy(
        &self,
        to: &str,
        length: u64,
        from: &mut dyn Read,
        name: &Path,
        hasher: &mut blake3::Hasher,
        moved: &mut dyn FnMut(u64),
    ) -> Result<(), FolderError> {
        let mut file = self.new_file(to).map_err(self.unwritten(to))?;
        let mut chunk = vec![0; CHUNK];
        let mut rest = length;
        while rest > 0 {
            let most = usize::try_from(rest).map_or(CHUNK, |rest| rest.min(CHUNK));
            let count = match from.read(&mut chunk[..most]) {
                Ok(0) => break,
                Ok(count) => count,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                Err(source) => return Err(FolderError::Read { path: name.to_owned(), source }),
            };
            file.write_all(&chunk[..count]).map_err(self.unwritten(to))?;
            hasher.update(&chunk[..count]);
            moved(count as u64);
            rest -= count as u64;
        }
        // Synced before the rename: a resumed writer would take a file under its final name for complete.
        file.sync_data().map_err(self.unwritten(to))
    }

    /// Verifies the digest of a file that was cloned to `temporary`, and syncs it.
    fn verify_clone(
        &self,
        id: &ObjectId,
        temporary: &str,
        name: &Path,
        moved: &mut dyn FnMut(u64),
    ) -> Result<(), FolderError> {
        let mut hasher = blake3::Hasher::new();
        let mut look = || -> io::Result<()> {
            let file = self.root.file(temporary)?;
            hasher.update_reader(&file)?;
            file.sync_data()
        };
        let looked = look().map_err(|source| FolderError::Read { path: name.to_owned(), source });
        let vouched = looked.and_then(|()| check_id(id, &hasher, name));
        if vouched.is_err() {
            self.clear(temporary)?;
        }
        moved(hasher.count());
        vouched
    }

    /// Creates a new file. One of an interrupted run is removed, not overwritten: it may be a hard link.
    fn new_file(&self, path: &str) -> io::Result<File> {
        self.root.remove(path)?;
        Ok(File::from(self.root.at(path, OFlags::WRONLY | OFlags::CREATE | OFlags::EXCL, 0o644)?))
    }

    fn replace(&self, path: &str, bytes: &[u8]) -> Result<(), FolderError> {
        self.room_for(path)?;
        durable::replace(&self.root, path, bytes).map_err(self.unwritten(path))
    }

    fn rename(&self, from: &str, to: &str) -> Result<(), FolderError> {
        self.root.rename(from, to).map_err(self.unwritten(to))
    }

    fn clear(&self, path: &str) -> Result<(), FolderError> {
        self.root.remove(path).map_err(self.unwritten(path))
    }

    fn unwritten(&self, path: &str) -> impl FnOnce(io::Error) -> FolderError {
        let path = self.path.join(path);
        move |source| FolderError::Write { path, source }
    }
}

impl Source for Folder {
    fn small(&mut self, path: &str, _limit: u64) -> io::Result<Box<dyn Read + '_>> {
        Ok(Box::new(self.root.file(path)?))
    }

    fn object(&mut self, id: &ObjectId, size: u64, from: u64) -> io::Result<Box<dyn Read + '_>> {
        let path = id.path();
        match self.root.file(&path) {
            Ok(mut file) => {
                io::Seek::seek(&mut file, io::SeekFrom::Start(from))?;
                Ok(Box::new(file))
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                Ok(Box::new(Parts::open(&self.root, path, from, size)?))
            }
            Err(error) => Err(error),
        }
    }
}

impl AsFd for Folder {
    fn as_fd(&self) -> std::os::fd::BorrowedFd<'_> {
        self.root.as_fd()
    }
}

/// Checks that the digest of `name` is the object `id`.
fn check_id(id: &ObjectId, hasher: &blake3::Hasher, name: &Path) -> Result<(), FolderError> {
    let found = ObjectId::new(*hasher.finalize().as_bytes());
    if found == *id { Ok(()) } else { Err(FolderError::Changed { path: name.to_owned(), expected: *id, found }) }
}

fn temporary(path: &str) -> String {
    format!("{path}.new")
}

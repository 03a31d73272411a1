//! The disk operations of the store.
//!
//! Owns the trait [`Disk`], so that tests can inject an error or a power cut at each operation, and [`LocalDisk`],
//! which is used on a unit and is limited to one folder. All paths are relative to that folder.
//!
//! Start at [`Disk`].
#![allow(clippy::missing_errors_doc, reason = "every operation fails with the error of the disk")]

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use composefs_ioctls::fsverity::{EnableVerityError, fs_ioc_enable_verity};
use durable::{Append, Locked, Storage, plain};
use rustix::fs::{Advice, AtFlags, FileType, FlockOperation, Mode, OFlags};
use rustix::io::Errno;

use crate::beneath::{Root, ignore_error, none_if_missing};

/// fs-verity with SHA-256 and 4 KiB pages, which every kernel supports.
const VERITY_SHA256: u8 = 1;
const VERITY_PAGE: u32 = 4096;

/// How well an object is protected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Protection {
    /// It is read-only; its file system has no fs-verity.
    ReadOnly,
    /// The kernel verifies every page as it is read, and the file cannot be changed.
    Verity,
}

/// A disk, or a model of one in a test: what an atomic write needs, and what a store needs besides.
pub trait Disk: Storage + Send {
    /// Opens a file for sequential reading.
    fn open(&self, path: &str) -> io::Result<Box<dyn Read + '_>>;

    /// The size of a plain file in bytes; `None` if there is none, or something else in its place.
    fn length(&self, path: &str) -> io::Result<Option<u64>>;

    /// The names in a folder, in any order; none if there is no such folder, or something else in its place.
    fn list(&self, folder: &str) -> io::Result<Vec<String>>;

    /// Creates a folder, unless it exists.
    fn make_folder(&self, path: &str) -> io::Result<()>;

    /// Creates a hard link. It is an error if `to` exists.
    fn link(&self, from: &str, to: &str) -> io::Result<()>;

    /// Removes an empty folder, if it exists.
    fn remove_folder(&self, path: &str) -> io::Result<()>;

    /// Creates a symbolic link at `path`.
    fn symlink(&self, path: &str, target: &str) -> io::Result<()>;

    /// The target of the symbolic link at `path`; `None` if there is none.
    fn read_link(&self, path: &str) -> io::Result<Option<String>>;

    /// Makes a file read-only, under fs-verity where there is that, and syncs it.
    fn make_read_only(&self, path: &str) -> io::Result<Protection>;

    /// The room that is left, in bytes.
    fn free_bytes(&self) -> io::Result<u64>;

    /// Waits for the lock on the store's state, and holds it while the result lives; `None` on a disk without other users.
    fn lock_state(&self) -> io::Result<Option<File>>;

    /// Whether a player uses the generation in this folder.
    fn is_in_use(&self, folder: &str) -> io::Result<bool>;
}

/// A folder on a real disk, locked against a second updater. The player may record its trial at the same time.
///
/// All names in it are the store's. Where a damaged file system or another program has put a pipe, a link or a folder in
/// the place of a file, or a file in the place of a folder, the next write replaces it.
#[derive(Debug)]
pub struct LocalDisk {
    root: Root,
    /// Holds the updater's lock; `None` without.
    _lock: Option<Locked>,
}

impl LocalDisk {
    /// Opens the folder at `path`, creates it if necessary, and locks it.
    ///
    /// # Errors
    /// The disk's error; [`io::ErrorKind::WouldBlock`] if another process holds the lock.
    pub fn open(path: &Path) -> io::Result<Self> {
        std::fs::create_dir_all(path)?;
        let unlocked = Self { root: Root::open(path)?, _lock: None };
        let lock = unlocked.plain_file("lock", OFlags::RDWR)?;
        rustix::fs::flock(&lock, FlockOperation::NonBlockingLockExclusive)?;
        Ok(Self { _lock: Some(Locked::new(lock)), ..unlocked })
    }

    /// Opens the existing folder at `path`, and locks it: as [`LocalDisk::open`], for a user that may only read it.
    ///
    /// # Errors
    /// Those of [`LocalDisk::open`]; [`io::ErrorKind::NotFound`] if no updater has worked there.
    pub fn open_to_read(path: &Path) -> io::Result<Self> {
        let root = Root::open(path)?;
        let lock = File::from(root.at("lock", OFlags::RDONLY, 0)?);
        rustix::fs::flock(&lock, FlockOperation::NonBlockingLockExclusive)?;
        Ok(Self { root, _lock: Some(Locked::new(lock)) })
    }

    /// Opens the existing folder at `path` without the updater's lock.
    pub(crate) fn open_shared(path: &Path) -> io::Result<Self> {
        Ok(Self { root: Root::open(path)?, _lock: None })
    }

    /// Opens a generation's folder, and marks it as in use while the result lives.
    pub(crate) fn lock_generation(&self, folder: &str) -> io::Result<File> {
        let folder = File::from(self.root.folder(folder)?);
        rustix::fs::flock(&folder, FlockOperation::LockShared)?;
        Ok(folder)
    }

    /// Opens the plain file at `path` for writing, creates it if it is missing, and replaces anything else there.
    fn plain_file(&self, path: &str, flags: OFlags) -> io::Result<File> {
        let flags = flags | OFlags::CREATE | OFlags::NONBLOCK;
        let open = || self.root.at(path, flags, 0o644).map(File::from).and_then(plain);
        self.replacing(path, FileType::RegularFile, open)
    }

    /// Does `work`; if it fails and something other than `expected` is at `path`, removes that and does it again.
    fn replacing<T>(&self, path: &str, expected: FileType, work: impl Fn() -> io::Result<T>) -> io::Result<T> {
        match work() {
            Err(error) if self.kind(path).is_none_or(|found| found == expected) => Err(error),
            Err(_) => {
                remove_tree(self, path)?;
                work()
            }
            done => done,
        }
    }

    /// The kind of what is at `path`; `None` if there is nothing, or it cannot be found out.
    fn kind(&self, path: &str) -> Option<FileType> {
        let (folder, name) = self.root.parent(path).ok()?;
        let status = rustix::fs::statat(folder, name, AtFlags::SYMLINK_NOFOLLOW).ok()?;
        Some(FileType::from_raw_mode(status.st_mode))
    }
}

impl Storage for LocalDisk {
    fn read(&self, path: &str, limit: u64) -> io::Result<Vec<u8>> {
        self.root.read(path, limit)
    }

    fn append(&self, path: &str) -> io::Result<Box<dyn Append + '_>> {
        Ok(Box::new(self.plain_file(path, OFlags::WRONLY | OFlags::APPEND)?))
    }

    fn rename(&self, from: &str, to: &str) -> io::Result<()> {
        match self.root.rename(from, to) {
            Err(error) if error.kind() == io::ErrorKind::IsADirectory => {
                remove_tree(self, to)?;
                self.root.rename(from, to)
            }
            renamed => renamed,
        }
    }

    fn remove(&self, path: &str) -> io::Result<()> {
        self.root.remove(path)
    }

    fn sync_folder(&self, path: &str) -> io::Result<()> {
        self.root.sync_folder(path)
    }
}

impl Disk for LocalDisk {
    fn open(&self, path: &str) -> io::Result<Box<dyn Read + '_>> {
        let file = self.root.file(path)?;
        rustix::fs::fadvise(&file, 0, None, Advice::Sequential)?;
        Ok(Box::new(file))
    }

    fn length(&self, path: &str) -> io::Result<Option<u64>> {
        self.root.length(path).or_else(|error| if is_of_another_kind(&error) { Ok(None) } else { Err(error) })
    }

    fn list(&self, folder: &str) -> io::Result<Vec<String>> {
        let folder = match self.root.folder(folder) {
            Err(error) if error.kind() == io::ErrorKind::NotFound || is_of_another_kind(&error) => {
                return Ok(Vec::new());
            }
            folder => folder?,
        };
        let mut names = Vec::new();
        for entry in rustix::fs::Dir::read_from(&folder)? {
            let entry = entry?;
            // Names that are not UTF-8 are not ours.
            names
                .extend(entry.file_name().to_str().ok().filter(|name| !matches!(*name, "." | "..")).map(str::to_owned));
        }
        Ok(names)
    }

    fn make_folder(&self, path: &str) -> io::Result<()> {
        self.replacing(path, FileType::Directory, || {
            let (folder, name) = self.root.parent(path)?;
            let made = rustix::fs::mkdirat(folder, name, Mode::from_raw_mode(0o755));
            ignore_error(made, io::ErrorKind::AlreadyExists)?;
            self.root.folder(path).map(|_| ())
        })
    }

    fn link(&self, from: &str, to: &str) -> io::Result<()> {
        self.replacing(to, FileType::RegularFile, || {
            let ((from, old), (to, new)) = (self.root.parent(from)?, self.root.parent(to)?);
            Ok(rustix::fs::linkat(from, old, to, new, AtFlags::empty())?)
        })
    }

    fn remove_folder(&self, path: &str) -> io::Result<()> {
        let Some((folder, name)) = none_if_missing(self.root.parent(path))? else { return Ok(()) };
        ignore_error(rustix::fs::unlinkat(folder, name, AtFlags::REMOVEDIR), io::ErrorKind::NotFound)
    }

    fn symlink(&self, path: &str, target: &str) -> io::Result<()> {
        let (folder, name) = self.root.parent(path)?;
        Ok(rustix::fs::symlinkat(target, folder, name)?)
    }

    fn read_link(&self, path: &str) -> io::Result<Option<String>> {
        let (folder, name) = self.root.parent(path)?;
        match rustix::fs::readlinkat(folder, name, Vec::new()) {
            Ok(target) => Ok(target.into_string().ok()),
            // Nothing there, or not a link.
            Err(Errno::NOENT | Errno::INVAL) => Ok(None),
            Err(error) => Err(error.into()),
        }
    }

    fn make_read_only(&self, path: &str) -> io::Result<Protection> {
        let file = self.root.file(path)?;
        // Enabling fs-verity needs write permission.
        let sealed = fs_ioc_enable_verity(&file, VERITY_SHA256, VERITY_PAGE);
        rustix::fs::fchmod(&file, Mode::from_raw_mode(0o444))?;
        file.sync_all()?;
        // It was read only for verification: its pages are dropped from the cache.
        rustix::fs::fadvise(&file, 0, None, Advice::DontNeed)?;
        Ok(match sealed {
            Ok(()) | Err(EnableVerityError::AlreadyEnabled) => Protection::Verity,
            Err(_) => Protection::ReadOnly,
        })
    }

    fn free_bytes(&self) -> io::Result<u64> {
        let status = rustix::fs::fstatvfs(&self.root)?;
        Ok(status.f_bavail.saturating_mul(status.f_frsize))
    }

    fn lock_state(&self) -> io::Result<Option<File>> {
        let file = self.plain_file("state.lock", OFlags::RDWR)?;
        rustix::fs::flock(&file, FlockOperation::LockExclusive)?;
        Ok(Some(file))
    }

    fn is_in_use(&self, folder: &str) -> io::Result<bool> {
        let folder = match self.root.folder(folder) {
            Err(error) if error.kind() == io::ErrorKind::NotADirectory => return Ok(false),
            folder => folder?,
        };
        match rustix::fs::flock(&folder, FlockOperation::NonBlockingLockExclusive) {
            Err(Errno::WOULDBLOCK) => Ok(true),
            locked => Ok(locked.map(|()| false)?),
        }
    }
}

/// Whether something of another kind than expected is at the path of `error`, or in the place of a folder on the way.
fn is_of_another_kind(error: &io::Error) -> bool {
    let is_link = error.raw_os_error() == Some(Errno::LOOP.raw_os_error());
    is_link || matches!(error.kind(), io::ErrorKind::InvalidData | io::ErrorKind::NotADirectory)
}

/// Removes a file, or a folder with its contents, if it exists.
pub(crate) fn remove_tree(disk: &dyn Disk, path: &str) -> io::Result<()> {
    match disk.remove(path) {
        Err(error) if error.kind() == io::ErrorKind::IsADirectory => {
            for name in disk.list(path)? {
                remove_tree(disk, &format!("{path}/{name}"))?;
            }
            disk.remove_folder(path)
        }
        removed => removed,
    }
}

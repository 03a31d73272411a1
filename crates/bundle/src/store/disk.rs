//! What the store does to a disk, each step by itself.
//!
//! Owns the few operations that a store is made of, so that each can fail, and the machine die at each, in a test. On
//! a unit they are [`LocalDisk`]'s: beneath one folder and nowhere else. All paths are relative to that folder.
//!
//! Start at [`Disk`].

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::Path;

use composefs_ioctls::fsverity::{EnableVerityError, fs_ioc_enable_verity};
use rustix::fs::{Advice, AtFlags, FlockOperation, Mode, OFlags};

use crate::beneath::{self, Root};

/// SHA-256 and pages of 4 KiB, the fs-verity that every kernel knows.
const VERITY_SHA256: u8 = 1;
const VERITY_PAGE: u32 = 4096;

/// How well an object is protected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Frozen {
    /// It is read-only; its file system knows no fs-verity.
    ReadOnly,
    /// The kernel checks every page as it is read, and nobody can change it.
    Verity,
}

/// A file that grows.
pub trait Append: Write {
    /// Returns when the disk has it all.
    ///
    /// # Errors
    /// What the disk says. What was written since the last time may be lost for good, and this must not be tried again.
    fn sync(&mut self) -> io::Result<()>;
}

/// A disk, or what stands for one in a test. Nothing but what was synced survives a power cut: a file's bytes by its
/// own sync, its name by that of its folder. A rename happens as a whole or not at all.
pub trait Disk: Send {
    /// The bytes of a small file.
    ///
    /// # Errors
    /// What the disk says; [`io::ErrorKind::FileTooLarge`] if there are more than `limit`.
    fn read(&self, path: &str, limit: u64) -> io::Result<Vec<u8>>;

    /// Opens a file to be read from end to end, once.
    ///
    /// # Errors
    /// What the disk says.
    fn open(&self, path: &str) -> io::Result<Box<dyn Read + '_>>;

    /// The size of a file in bytes; `None` if there is none.
    ///
    /// # Errors
    /// What the disk says.
    fn length(&self, path: &str) -> io::Result<Option<u64>>;

    /// The names in a folder, in any order; none if there is no such folder.
    ///
    /// # Errors
    /// What the disk says.
    fn list(&self, folder: &str) -> io::Result<Vec<String>>;

    /// Opens a file at its end; makes it if there is none.
    ///
    /// # Errors
    /// What the disk says.
    fn append(&self, path: &str) -> io::Result<Box<dyn Append + '_>>;

    /// Makes a folder; that there is one already is fine.
    ///
    /// # Errors
    /// What the disk says.
    fn make_folder(&self, path: &str) -> io::Result<()>;

    /// Gives a file a second name. That the name is taken is an error.
    ///
    /// # Errors
    /// What the disk says.
    fn link(&self, from: &str, to: &str) -> io::Result<()>;

    /// Gives a file another name; who had that name before loses it.
    ///
    /// # Errors
    /// What the disk says.
    fn rename(&self, from: &str, to: &str) -> io::Result<()>;

    /// Takes a file's name away; that there is none is fine.
    ///
    /// # Errors
    /// What the disk says.
    fn remove(&self, path: &str) -> io::Result<()>;

    /// Removes an empty folder; that there is none is fine.
    ///
    /// # Errors
    /// What the disk says.
    fn remove_folder(&self, path: &str) -> io::Result<()>;

    /// Makes a symbolic link at `path`.
    ///
    /// # Errors
    /// What the disk says.
    fn point(&self, path: &str, target: &str) -> io::Result<()>;

    /// Where the symbolic link at `path` points; `None` if there is none.
    ///
    /// # Errors
    /// What the disk says.
    fn pointed(&self, path: &str) -> io::Result<Option<String>>;

    /// Returns when the disk has all names in the folder.
    ///
    /// # Errors
    /// What the disk says.
    fn sync_folder(&self, path: &str) -> io::Result<()>;

    /// Makes a file read-only, under fs-verity where there is that, and syncs it.
    ///
    /// # Errors
    /// What the disk says.
    fn freeze(&self, path: &str) -> io::Result<Frozen>;

    /// The room that is left, in bytes.
    ///
    /// # Errors
    /// What the disk says.
    fn room(&self) -> io::Result<u64>;

    /// Waits until nobody else changes the state of the store, and lets nobody do so while the result lives; `None` on
    /// a disk that nobody else reaches.
    ///
    /// # Errors
    /// What the disk says.
    fn hold(&self) -> io::Result<Option<File>>;

    /// Whether somebody plays the generation in this folder.
    ///
    /// # Errors
    /// What the disk says.
    fn is_played(&self, folder: &str) -> io::Result<bool>;
}

/// The folder that the file at `path` lies in.
pub(crate) fn folder_of(path: &str) -> &str {
    path.rsplit_once('/').map_or("", |(folder, _)| folder)
}

/// Has the file at `path` hold `bytes`: as a whole or not at all, and on the disk when this returns.
pub(crate) fn replace(disk: &dyn Disk, path: &str, bytes: &[u8]) -> io::Result<()> {
    let new = format!("{path}.new");
    disk.remove(&new)?;
    let mut file = disk.append(&new)?;
    file.write_all(bytes)?;
    file.sync()?;
    drop(file);
    disk.rename(&new, path)?;
    disk.sync_folder(folder_of(path))
}

/// A folder on a real disk, locked against a second updater. The player may judge meanwhile.
#[derive(Debug)]
pub struct LocalDisk {
    root: Root,
    /// Held for the lock on it; `None` beside an updater.
    _lock: Option<File>,
}

impl LocalDisk {
    /// Opens the folder at `path`, makes it if it is not there, and locks it.
    ///
    /// # Errors
    /// What the disk says; [`io::ErrorKind::WouldBlock`] if another process holds the lock.
    pub fn open(path: &Path) -> io::Result<Self> {
        std::fs::create_dir_all(path)?;
        let root = Root::open(path)?;
        let lock = File::from(root.at("lock", OFlags::RDWR | OFlags::CREATE, 0o644)?);
        rustix::fs::flock(&lock, FlockOperation::NonBlockingLockExclusive)?;
        Ok(Self { root, _lock: Some(lock) })
    }

    /// Opens the folder at `path`, which must be there, beside an updater that may be at work on it.
    pub(crate) fn beside(path: &Path) -> io::Result<Self> {
        Ok(Self { root: Root::open(path)?, _lock: None })
    }

    /// Opens a folder and says that it is played for as long as the result lives.
    pub(crate) fn play(&self, folder: &str) -> io::Result<File> {
        let folder = File::from(self.root.folder(folder)?);
        rustix::fs::flock(&folder, FlockOperation::LockShared)?;
        Ok(folder)
    }
}

impl Disk for LocalDisk {
    fn read(&self, path: &str, limit: u64) -> io::Result<Vec<u8>> {
        beneath::read_all(self.root.file(path)?, limit)
    }

    fn open(&self, path: &str) -> io::Result<Box<dyn Read + '_>> {
        let file = self.root.file(path)?;
        rustix::fs::fadvise(&file, 0, None, Advice::Sequential)?;
        Ok(Box::new(file))
    }

    fn length(&self, path: &str) -> io::Result<Option<u64>> {
        self.root.length(path)
    }

    fn list(&self, folder: &str) -> io::Result<Vec<String>> {
        let folder = match self.root.folder(folder) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
            folder => folder?,
        };
        let mut names = Vec::new();
        for entry in rustix::fs::Dir::read_from(&folder)? {
            let entry = entry?;
            // A name that is not text is none of ours; it can be neither opened nor removed by us.
            names
                .extend(entry.file_name().to_str().ok().filter(|name| !matches!(*name, "." | "..")).map(str::to_owned));
        }
        Ok(names)
    }

    fn append(&self, path: &str) -> io::Result<Box<dyn Append + '_>> {
        let flags = OFlags::WRONLY | OFlags::CREATE | OFlags::APPEND | OFlags::NONBLOCK;
        let file = File::from(self.root.at(path, flags, 0o644)?);
        Ok(Box::new(file))
    }

    fn make_folder(&self, path: &str) -> io::Result<()> {
        let (folder, name) = self.root.parent(path)?;
        fine_if(rustix::fs::mkdirat(folder, name, Mode::from_raw_mode(0o755)), io::ErrorKind::AlreadyExists)
    }

    fn link(&self, from: &str, to: &str) -> io::Result<()> {
        let ((from, old), (to, new)) = (self.root.parent(from)?, self.root.parent(to)?);
        Ok(rustix::fs::linkat(from, old, to, new, AtFlags::empty())?)
    }

    fn rename(&self, from: &str, to: &str) -> io::Result<()> {
        let ((from, old), (to, new)) = (self.root.parent(from)?, self.root.parent(to)?);
        Ok(rustix::fs::renameat(from, old, to, new)?)
    }

    fn remove(&self, path: &str) -> io::Result<()> {
        let Some((folder, name)) = found(self.root.parent(path))? else { return Ok(()) };
        fine_if(rustix::fs::unlinkat(folder, name, AtFlags::empty()), io::ErrorKind::NotFound)
    }

    fn remove_folder(&self, path: &str) -> io::Result<()> {
        let Some((folder, name)) = found(self.root.parent(path))? else { return Ok(()) };
        fine_if(rustix::fs::unlinkat(folder, name, AtFlags::REMOVEDIR), io::ErrorKind::NotFound)
    }

    fn point(&self, path: &str, target: &str) -> io::Result<()> {
        let (folder, name) = self.root.parent(path)?;
        Ok(rustix::fs::symlinkat(target, folder, name)?)
    }

    fn pointed(&self, path: &str) -> io::Result<Option<String>> {
        let (folder, name) = self.root.parent(path)?;
        match rustix::fs::readlinkat(folder, name, Vec::new()) {
            Ok(target) => Ok(target.into_string().ok()),
            // Nothing there, or something that is no link: either way it points nowhere.
            Err(rustix::io::Errno::NOENT | rustix::io::Errno::INVAL) => Ok(None),
            Err(error) => Err(error.into()),
        }
    }

    fn sync_folder(&self, path: &str) -> io::Result<()> {
        Ok(rustix::fs::fsync(self.root.folder(path)?)?)
    }

    fn freeze(&self, path: &str) -> io::Result<Frozen> {
        let file = self.root.file(path)?;
        // Only who may write to a file may have it verified.
        let sealed = fs_ioc_enable_verity(&file, VERITY_SHA256, VERITY_PAGE);
        rustix::fs::fchmod(&file, Mode::from_raw_mode(0o444))?;
        file.sync_all()?;
        // It was read to be checked and will not be read soon: its pages serve the clips of the picture better.
        rustix::fs::fadvise(&file, 0, None, Advice::DontNeed)?;
        Ok(match sealed {
            Ok(()) | Err(EnableVerityError::AlreadyEnabled) => Frozen::Verity,
            Err(_) => Frozen::ReadOnly,
        })
    }

    fn room(&self) -> io::Result<u64> {
        let status = rustix::fs::fstatvfs(&self.root)?;
        Ok(status.f_bavail.saturating_mul(status.f_frsize))
    }

    fn hold(&self) -> io::Result<Option<File>> {
        let file = File::from(self.root.at("state.lock", OFlags::RDWR | OFlags::CREATE, 0o644)?);
        rustix::fs::flock(&file, FlockOperation::LockExclusive)?;
        Ok(Some(file))
    }

    fn is_played(&self, folder: &str) -> io::Result<bool> {
        let folder = match self.root.folder(folder) {
            Err(error) if error.kind() == io::ErrorKind::NotADirectory => return Ok(false),
            folder => folder?,
        };
        match rustix::fs::flock(&folder, FlockOperation::NonBlockingLockExclusive) {
            Err(rustix::io::Errno::WOULDBLOCK) => Ok(true),
            locked => Ok(locked.map(|()| false)?),
        }
    }
}

impl Append for File {
    fn sync(&mut self) -> io::Result<()> {
        self.sync_all()
    }
}

/// What was found; `None` if a folder on the way is not there.
fn found<T>(found: io::Result<T>) -> io::Result<Option<T>> {
    match found {
        Ok(found) => Ok(Some(found)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error),
    }
}

fn fine_if(done: rustix::io::Result<()>, kind: io::ErrorKind) -> io::Result<()> {
    match done.map_err(io::Error::from) {
        Err(error) if error.kind() == kind => Ok(()),
        done => done,
    }
}

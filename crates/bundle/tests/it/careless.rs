//! Disks that fail on purpose: some forget something, to show that the search for lost flocks would notice, and some cannot
//! read all of their files.
//!
//! Owns the carelessness, on top of any other disk. The crash laboratory of `tests/crash` has it on a real one.

use bundle::{Disk, Protection};
use durable::{Append, Storage};
use std::fs::File;
use std::io::{self, Read};

/// A disk that forgets something.
pub(crate) struct Careless<D> {
    pub(crate) disk: D,
    pub(crate) carelessness: Carelessness,
    /// What else happens on the disk between taking something away and putting another in its place.
    pub(crate) meanwhile: fn(&D),
}

/// What it forgets, or cannot do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Carelessness {
    NoFileSync,
    NoFolderSync,
    WritesInPlace,
    /// Opening a file fails if another file has its name and [`BAD`].
    BadSectors,
}

/// The end of the name of a file that marks another one as unreadable.
pub(crate) const BAD: &str = ".bad";

impl Carelessness {
    /// All that loses flocks.
    pub(crate) const ALL: [Self; 3] = [Self::NoFileSync, Self::NoFolderSync, Self::WritesInPlace];
}

struct NoSync<'d>(Box<dyn Append + 'd>);

impl<D: Disk> Storage for Careless<D> {
    fn append(&self, path: &str) -> io::Result<Box<dyn Append + '_>> {
        let file = self.disk.append(path)?;
        Ok(if self.carelessness == Carelessness::NoFileSync { Box::new(NoSync(file)) } else { file })
    }

    fn rename(&self, from: &str, to: &str) -> io::Result<()> {
        if self.carelessness != Carelessness::WritesInPlace {
            return self.disk.rename(from, to);
        }
        if let Some(target) = self.disk.read_link(from)? {
            self.disk.remove(to)?;
            (self.meanwhile)(&self.disk);
            return self.disk.symlink(to, &target);
        }
        let bytes = self.disk.read(from, 1 << 30)?;
        self.disk.remove(to)?;
        (self.meanwhile)(&self.disk);
        let mut file = self.disk.append(to)?;
        file.write_all(&bytes)?;
        file.sync()?;
        self.disk.remove(from)
    }

    fn sync_folder(&self, path: &str) -> io::Result<()> {
        if self.carelessness == Carelessness::NoFolderSync { Ok(()) } else { self.disk.sync_folder(path) }
    }

    fn read(&self, path: &str, limit: u64) -> io::Result<Vec<u8>> {
        self.disk.read(path, limit)
    }

    fn remove(&self, path: &str) -> io::Result<()> {
        self.disk.remove(path)
    }
}

impl<D: Disk> Disk for Careless<D> {
    fn make_read_only(&self, path: &str) -> io::Result<Protection> {
        if self.carelessness == Carelessness::NoFileSync {
            Ok(Protection::ReadOnly)
        } else {
            self.disk.make_read_only(path)
        }
    }

    fn open(&self, path: &str) -> io::Result<Box<dyn Read + '_>> {
        if self.carelessness == Carelessness::BadSectors && self.disk.length(&format!("{path}{BAD}"))?.is_some() {
            return Err(rustix::io::Errno::IO.into());
        }
        self.disk.open(path)
    }

    fn length(&self, path: &str) -> io::Result<Option<u64>> {
        self.disk.length(path)
    }

    fn list(&self, folder: &str) -> io::Result<Vec<String>> {
        self.disk.list(folder)
    }

    fn make_folder(&self, path: &str) -> io::Result<()> {
        self.disk.make_folder(path)
    }

    fn link(&self, from: &str, to: &str) -> io::Result<()> {
        self.disk.link(from, to)
    }

    fn remove_folder(&self, path: &str) -> io::Result<()> {
        self.disk.remove_folder(path)
    }

    fn symlink(&self, path: &str, target: &str) -> io::Result<()> {
        self.disk.symlink(path, target)
    }

    fn read_link(&self, path: &str) -> io::Result<Option<String>> {
        self.disk.read_link(path)
    }

    fn free_bytes(&self) -> io::Result<u64> {
        self.disk.free_bytes()
    }

    fn lock_state(&self) -> io::Result<Option<File>> {
        self.disk.lock_state()
    }

    fn is_in_use(&self, folder: &str) -> io::Result<bool> {
        self.disk.is_in_use(folder)
    }
}

impl io::Write for NoSync<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Append for NoSync<'_> {
    fn sync(&mut self) -> io::Result<()> {
        Ok(())
    }
}

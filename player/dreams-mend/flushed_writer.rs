//! Writing that leaves the machine's memory to the picture.
//!
//! Owns that what was written is on the disk, and not in memory any more when it is read back. Never looks at what it is.

use rustix::fs::{Advice, fadvise};
use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;
use std::path::Path;

/// How many bytes are written between two syncs.
const FLUSH_EVERY: usize = 8 << 20;

/// Writes to a file, at any place.
pub(crate) struct Steady<'f> {
    file: &'f File,
    unsynced: usize,
}

impl<'f> Steady<'f> {
    pub(crate) fn new(file: &'f File) -> Self {
        Self { file, unsynced: 0 }
    }

    pub(crate) fn write(&mut self, bytes: &[u8], at: u64) -> io::Result<()> {
        self.file.write_all_at(bytes, at)?;
        self.unsynced += bytes.len();
        if self.unsynced >= FLUSH_EVERY { self.flush() } else { Ok(()) }
    }

    /// All that was written is on the disk. What is read from now on comes from there.
    pub(crate) fn flush(&mut self) -> io::Result<()> {
        self.file.sync_all()?;
        self.unsynced = 0;
        forget(self.file)
    }
}

/// Gives back the memory that holds what was read of `file`.
pub(crate) fn forget(file: &File) -> io::Result<()> {
    Ok(fadvise(file, 0, None, Advice::DontNeed)?)
}

pub(crate) fn sync_folder(folder: &Path) -> io::Result<()> {
    File::open(folder)?.sync_all()
}

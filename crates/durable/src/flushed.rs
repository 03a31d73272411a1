//! Writing that leaves the machine's memory to the player's clips.
//!
//! Owns that what was written is on the disk, and not in the page cache when it is read back. Never looks at the bytes.
#![allow(clippy::missing_errors_doc, reason = "every operation fails with the error of the disk")]

use rustix::fs::{Advice, fadvise};
use std::fs::File;
use std::io::{self, Write};
use std::os::unix::fs::FileExt;

/// How many bytes are written between two syncs.
const FLUSH_EVERY: usize = 8 << 20;

/// Writes to a file, and flushes what it wrote as it goes.
#[derive(Debug)]
pub struct FlushedWriter<'f> {
    file: &'f File,
    unsynced: usize,
}

impl<'f> FlushedWriter<'f> {
    /// A writer to `file`.
    pub fn new(file: &'f File) -> Self {
        Self { file, unsynced: 0 }
    }

    /// Writes all `bytes` from the byte `at` on.
    pub fn write_at(&mut self, bytes: &[u8], at: u64) -> io::Result<()> {
        self.file.write_all_at(bytes, at)?;
        self.count(bytes.len())
    }

    fn count(&mut self, written: usize) -> io::Result<()> {
        self.unsynced += written;
        if self.unsynced >= FLUSH_EVERY { self.flush() } else { Ok(()) }
    }
}

impl Write for FlushedWriter<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.file.write(bytes)?;
        self.count(count).map(|()| count)
    }

    /// All that was written is on the disk. What is read from now on comes from there.
    fn flush(&mut self) -> io::Result<()> {
        self.file.sync_all()?;
        self.unsynced = 0;
        drop_cache(self.file)
    }
}

/// Drops `file` from the page cache: what is read of it from now on comes from the disk.
pub fn drop_cache(file: &File) -> io::Result<()> {
    Ok(fadvise(file, 0, None, Advice::DontNeed)?)
}

//! Whether a file is still the same one.
//!
//! Owns the comparison by inode and time of change: our files are written anew and renamed into place, so each writing is
//! a new inode. Never reads what is in a file.

use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::Path;

/// One writing of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileVersion {
    /// Its inode.
    pub inode: u64,
    /// When it was written: seconds since 1970, by the machine's clock.
    pub written_s: i64,
    /// And nanoseconds.
    pub written_ns: i64,
}

impl FileVersion {
    /// The file at `path` as it is now; `None` if there is none.
    pub fn of(path: &Path) -> Option<Self> {
        let status = fs::metadata(path).ok()?;
        Some(Self { inode: status.ino(), written_s: status.mtime(), written_ns: status.mtime_nsec() })
    }
}

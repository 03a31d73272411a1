//! What the document does to files.
//!
//! Owns the three writes, so that in a test the program can end within each: append, replace, save. Never knows what is
//! written.
//!
//! Start at [`Disk`].

use std::fs::OpenOptions;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// The writes of a document.
pub(super) trait Disk: Send {
    /// Appends `bytes` to the journal, which is there; returns when the disk has them. What fails may have left a part.
    /// Errors: What the disk says.
    fn append(&self, bytes: &[u8]) -> io::Result<()>;

    /// Has the journal hold `bytes`, as a whole or not at all.
    /// Errors: What the disk says.
    fn replace(&self, bytes: &[u8]) -> io::Result<()>;

    /// Has a file that a person keeps hold `text`, as a whole or not at all.
    /// Errors: What the disk says.
    fn save(&self, path: &Path, text: &str) -> io::Result<()>;
}

/// The real one, with the journal at this path.
#[derive(Debug)]
pub(super) struct JournalFile(pub(super) PathBuf);

impl Disk for JournalFile {
    fn append(&self, bytes: &[u8]) -> io::Result<()> {
        let mut file = OpenOptions::new().append(true).open(&self.0)?;
        file.write_all(bytes)?;
        file.sync_data()
    }

    fn replace(&self, bytes: &[u8]) -> io::Result<()> {
        durable::write(&self.0, bytes)
    }

    fn save(&self, path: &Path, text: &str) -> io::Result<()> {
        durable::save(path, text.as_bytes())
    }
}

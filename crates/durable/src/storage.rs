//! What an atomic write needs of a disk.
//!
//! Owns [`Storage`], so that in a test each step can fail and the machine can lose its power at each; and the storage of
//! every program: a folder of this machine.
#![allow(clippy::missing_errors_doc, reason = "every operation fails with the error of the disk")]

use std::ffi::OsString;
use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt, fchown};
use std::path::{Path, PathBuf};

use crate::atomic::sync_names;
use crate::plain::read_plain;

/// A file that grows.
pub trait Append: Write {
    /// Returns when the disk has all of it.
    /// Errors: What the disk says. What was written since the last sync may be lost, and a second sync would not tell.
    fn sync(&mut self) -> io::Result<()>;
}

/// A folder, or a model of one in a test. All paths are relative to it. A power cut loses what was not synced: the bytes
/// of a file until the file is synced, its name until its folder is. A rename happens as a whole or not at all.
pub trait Storage {
    /// The bytes of a small plain file.
    /// Errors: What the disk says; [`io::ErrorKind::FileTooLarge`] if there are more than `limit`.
    fn read(&self, path: &str, limit: u64) -> io::Result<Vec<u8>>;

    /// Opens a file at its end; makes it if there is none.
    fn append(&self, path: &str) -> io::Result<Box<dyn Append + '_>>;

    /// Makes a file, and opens it.
    /// Errors: What the disk says; where others may write, also [`io::ErrorKind::AlreadyExists`] if there is one again.
    fn create(&self, path: &str) -> io::Result<Box<dyn Append + '_>> {
        self.append(path)
    }

    /// Gives a file another name; a file that had this name is gone.
    fn rename(&self, from: &str, to: &str) -> io::Result<()>;

    /// Removes a file, if there is one.
    fn remove(&self, path: &str) -> io::Result<()>;

    /// Returns when the disk has all names in the folder at `path`; the folder itself is `""`.
    fn sync_folder(&self, path: &str) -> io::Result<()>;
}

/// A folder of this machine.
#[derive(Debug)]
pub struct LocalFolder {
    /// What comes before every path: the folder with its slash.
    prefix: OsString,
    /// The permissions of new files, and their owner where the system lets us.
    like: Option<Metadata>,
    mode: u32,
}

impl LocalFolder {
    /// The folder at `path`.
    pub fn new(path: &Path) -> Self {
        Self { prefix: path.join("").into(), like: None, mode: 0o666 }
    }

    /// What lies beside `file` under its name and an ending; `""` is the file itself. So its name need not be UTF-8.
    pub(crate) fn beside(file: &Path, mode: u32, like: Option<Metadata>) -> Self {
        Self { prefix: file.into(), like, mode }
    }

    fn path(&self, path: &str) -> PathBuf {
        let mut whole = self.prefix.clone();
        whole.push(path);
        whole.into()
    }

    fn open(&self, path: &str, options: &mut OpenOptions) -> io::Result<Box<dyn Append + '_>> {
        let file = options.mode(self.mode).open(self.path(path))?;
        if let Some(like) = &self.like {
            file.set_permissions(like.permissions())?;
            let now = file.metadata()?;
            if (now.uid(), now.gid()) != (like.uid(), like.gid()) {
                // Only root may give files away; any other user owns what he saved.
                let _ = fchown(&file, Some(like.uid()), Some(like.gid()));
            }
        }
        Ok(Box::new(file))
    }
}

impl Storage for LocalFolder {
    fn read(&self, path: &str, limit: u64) -> io::Result<Vec<u8>> {
        read_plain(&self.path(path), limit)
    }

    fn append(&self, path: &str) -> io::Result<Box<dyn Append + '_>> {
        self.open(path, OpenOptions::new().append(true).create(true))
    }

    fn create(&self, path: &str) -> io::Result<Box<dyn Append + '_>> {
        // No link is followed, which another user of the folder may have put there.
        self.open(path, OpenOptions::new().append(true).create_new(true))
    }

    fn rename(&self, from: &str, to: &str) -> io::Result<()> {
        fs::rename(self.path(from), self.path(to))
    }

    fn remove(&self, path: &str) -> io::Result<()> {
        match fs::remove_file(self.path(path)) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
            done => done,
        }
    }

    fn sync_folder(&self, path: &str) -> io::Result<()> {
        // The prefix may be a file of the folder: then any name beside it has the folder.
        let inside = if path.is_empty() { "any".to_owned() } else { format!("{path}/any") };
        sync_names(&self.path(&inside))
    }
}

impl Append for File {
    fn sync(&mut self) -> io::Result<()> {
        self.sync_all()
    }
}

/// The folder that the file at `path` lies in; `""` if the path has one part.
pub fn parent(path: &str) -> &str {
    path.rsplit_once('/').map_or("", |(folder, _)| folder)
}

//! A flock's manifest, locked while one command edits it.
//!
//! Owns the lock, and the check before saving: the edited text must read back as the edited manifest. The commands decide
//! what to edit, on [`Draft::edit`].
//!
//! Start at [`Draft::lock`].

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use flock::{Edit, FILE_NAME, ManifestError};

use crate::flock_folder::open;
use crate::program::{Exit, Fatal};

/// The manifest of a flock, locked by one command.
#[derive(Debug)]
pub(crate) struct Draft {
    /// The manifest and its text.
    pub(crate) edit: Edit,
    path: PathBuf,
    /// The folder, locked while it is open: a second command that edits this flock waits.
    _lock: Option<File>,
}

/// A manifest that was not saved, because of a bug of ours. It is as it was.
#[derive(Debug, thiserror::Error)]
#[error("`{path}` was not saved: the edited text does not read back as the edited manifest")]
struct DraftError {
    path: PathBuf,
}

impl Draft {
    /// Locks the manifest of the flock in `folder`; waits while another command has it. It may be without sheep.
    pub(crate) fn lock(folder: &Path) -> Result<Self, Fatal> {
        // On a file system without locks the artist must not edit twice at once.
        let lock = File::open(folder).ok().filter(|folder| folder.lock().is_ok());
        let path = folder.join(FILE_NAME);
        let read = fs::read_to_string(&path).map_err(|source| ManifestError::Read { path: path.clone(), source });
        let edit = read.and_then(|text| Edit::parse(text, &path)).map_err(open::manifest_fatal)?;
        Ok(Self { edit, path, _lock: lock })
    }

    /// Saves the manifest as edited.
    pub(crate) fn save(self) -> Result<(), Fatal> {
        let Self { edit, path, _lock } = self;
        let Some(text) = edit.into_text() else { return Err(Fatal::new(Exit::Unreadable, DraftError { path })) };
        durable::save(&path, text.as_bytes()).map_err(|source| Fatal::file("save", &path, source))
    }

    /// Saves the manifest as edited, and keeps it locked for more edits.
    pub(crate) fn save_and_go_on(&mut self) -> Result<(), Fatal> {
        let text = self.edit.text();
        let read = Edit::parse(text.clone(), &self.path).ok().filter(|read| read.manifest() == self.edit.manifest());
        let Some(read) = read else {
            return Err(Fatal::new(Exit::Unreadable, DraftError { path: self.path.clone() }));
        };
        durable::save(&self.path, text.as_bytes()).map_err(|source| Fatal::file("save", &self.path, source))?;
        self.edit = read;
        Ok(())
    }
}

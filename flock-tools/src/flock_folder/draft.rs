//! A flock's manifest, taken for editing.
//!
//! Owns that nobody else edits it meanwhile, and that it is saved whole, and only if it reads back as what was meant.
//! Never decides what to edit: the commands do, on [`Draft::edit`].
//!
//! Start at [`Draft::take`].

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use flock::{Edit, FILE_NAME, ManifestError};

use crate::flock_folder::open;
use crate::program::{Exit, Fatal, save};

/// The manifest of a flock, in the hands of one command.
#[derive(Debug)]
pub(crate) struct Draft {
    /// What is edited.
    pub(crate) edit: Edit,
    path: PathBuf,
    /// The folder, locked while it is open: a second command that edits this flock waits.
    _lock: Option<File>,
}

/// A manifest that could not be saved. It is as it was.
#[derive(Debug, thiserror::Error)]
enum Unsaved {
    /// Our bug, found before it did harm.
    #[error("`{path}` was not saved: the edited text does not mean what was asked for")]
    Meaning {
        /// The manifest.
        path: PathBuf,
    },
    #[error("cannot save `{path}`")]
    Write {
        /// The manifest.
        path: PathBuf,
        source: io::Error,
    },
}

impl Draft {
    /// Takes the manifest of the flock in `folder`; waits while another command has it. It may be without sheep.
    pub(crate) fn take(folder: &Path) -> Result<Self, Fatal> {
        // Where a file system knows no locks, two editors are the artist's to avoid.
        let lock = File::open(folder).ok().filter(|folder| folder.lock().is_ok());
        let path = folder.join(FILE_NAME);
        let read = fs::read_to_string(&path).map_err(|source| ManifestError::Read { path: path.clone(), source });
        let edit = read.and_then(|text| Edit::parse(text, &path)).map_err(open::refused)?;
        Ok(Self { edit, path, _lock: lock })
    }

    /// Saves the manifest as edited.
    pub(crate) fn save(self) -> Result<(), Fatal> {
        let (text, path) = (self.edit.text(), self.path);
        let meant = Edit::parse(text.clone(), &path).is_ok_and(|read| read.manifest() == self.edit.manifest());
        if !meant {
            return Err(Fatal::new(Exit::Unreadable, Unsaved::Meaning { path }));
        }
        let written = save::whole(&path, text.as_bytes());
        written.map_err(|source| Fatal::new(Exit::Unreadable, Unsaved::Write { path, source }))
    }
}

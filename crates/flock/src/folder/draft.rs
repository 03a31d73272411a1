//! A flock's manifest, locked while it is edited.
//!
//! Owns the check before saving: the edited text must read back as the edited manifest. The caller edits, through
//! [`Draft::edit`]; the lock is in `turn.rs`.
//!
//! Start at [`Draft::lock`].

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::turn::Turn;
use crate::edit::Edit;
use crate::manifest::{FILE_NAME, ManifestError};

/// The manifest of a flock, locked by one editor.
#[derive(Debug)]
pub struct Draft {
    /// The manifest and its text.
    pub edit: Edit,
    path: PathBuf,
    turn: Turn,
}

/// Why a manifest was not saved. It is as it was.
#[derive(Debug, thiserror::Error)]
pub enum DraftError {
    /// A bug of ours.
    #[error("`{path}` was not saved: the edited text does not read back as the edited manifest")]
    Mismatch {
        /// The manifest.
        path: PathBuf,
    },
    /// What the disk says.
    #[error("cannot save `{path}`")]
    Save {
        /// The manifest.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}

impl Draft {
    /// Locks the manifest of the flock in `folder`; waits while another editor has it. It may be without sheep.
    ///
    /// # Errors
    /// [`ManifestError`], as [`Edit::parse`] and if the file cannot be read.
    pub fn lock(folder: &Path) -> Result<Self, ManifestError> {
        let turn = Turn::begin(folder);
        let path = folder.join(FILE_NAME);
        let text = fs::read_to_string(&path).map_err(|source| ManifestError::Read { path: path.clone(), source })?;
        let edit = Edit::parse(text, &path)?;
        Ok(Self { edit, path, turn })
    }

    /// Lists `files`, which are about to be written in the folder, by their paths in it: should this program be killed, the
    /// next editor removes what is half-written of them. Where the list cannot be written, that stays.
    pub fn writes<'a>(&mut self, files: impl IntoIterator<Item = &'a str>) {
        self.turn.list(files);
    }

    /// Saves the manifest as edited.
    ///
    /// # Errors
    /// [`DraftError`].
    pub fn save(self) -> Result<(), DraftError> {
        self.save_and_hold().map(drop)
    }

    /// Saves the manifest as edited, and keeps the turn for what belongs to it.
    ///
    /// # Errors
    /// [`DraftError`].
    pub fn save_and_hold(self) -> Result<Turn, DraftError> {
        let Self { edit, path, turn } = self;
        let Some(text) = edit.into_text() else { return Err(DraftError::Mismatch { path }) };
        durable::save(&path, text.as_bytes()).map_err(|source| DraftError::Save { path, source })?;
        Ok(turn)
    }

    /// Saves the manifest as edited, and keeps it locked for more edits.
    ///
    /// # Errors
    /// [`DraftError`].
    pub fn save_and_go_on(&mut self) -> Result<(), DraftError> {
        let text = self.edit.text();
        let read = Edit::parse(text.clone(), &self.path).ok().filter(|read| read.manifest() == self.edit.manifest());
        let Some(read) = read else { return Err(DraftError::Mismatch { path: self.path.clone() }) };
        let cannot = |source| DraftError::Save { path: self.path.clone(), source };
        durable::save(&self.path, text.as_bytes()).map_err(cannot)?;
        self.edit = read;
        Ok(())
    }
}

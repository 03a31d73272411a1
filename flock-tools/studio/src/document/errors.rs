//! Why a document refuses.
//!
//! Owns the errors, as sentences for the artist. Nothing was changed where one is returned.

use std::io;
use std::path::PathBuf;

use flock::{ManifestError, SheepId};

use super::notes::NoteRefusal;

/// Why a document was not opened.
#[derive(Debug, thiserror::Error)]
pub(crate) enum DocumentError {
    /// The studio's own folder.
    #[error("cannot use `{path}`")]
    Folder {
        /// Which.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The manifest.
    #[error(transparent)]
    Manifest(#[from] ManifestError),
    /// It has the flock.
    #[error("another studio has the flock in `{folder}` open")]
    Taken {
        /// The flock's folder.
        folder: PathBuf,
    },
}

/// Why edits were not made.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ApplyError {
    /// Somebody else changed the flock meanwhile, and the edits no longer fit.
    #[error("the flock was changed meanwhile: {error}")]
    Conflict {
        /// Why they do not fit.
        error: String,
    },
    /// The disk.
    #[error("cannot save the flock: {0}")]
    Disk(#[from] io::Error),
    /// The flock would have no sheep.
    #[error("the flock would have no sheep")]
    Empty,
    /// The manifest cannot be read as it is now.
    #[error(transparent)]
    Manifest(#[from] ManifestError),
    /// The edits are wrong.
    #[error("{error}")]
    Refused {
        /// Why.
        error: String,
    },
    /// Sheep that the walk shows would no longer be shown. With `force` the edits are made all the same.
    #[error("{} sheep that the walk shows would no longer be shown, {} first", no_longer_shown.len(), no_longer_shown[0])]
    Unshown {
        /// Which; at least one.
        no_longer_shown: Vec<SheepId>,
    },
}

/// Why a step was not undone, or not done again.
#[derive(Debug, thiserror::Error)]
pub(crate) enum UndoError {
    /// Somebody else changed the file since.
    #[error("cannot take back what was done: `{file}` was changed by another program since")]
    Changed {
        /// The manifest, or the credits.
        file: &'static str,
    },
    /// The disk.
    #[error("cannot save the flock: {0}")]
    Disk(#[from] io::Error),
    /// The manifest cannot be read as it is now.
    #[error(transparent)]
    Manifest(#[from] ManifestError),
    /// There is no step.
    #[error("there is nothing to {what}")]
    Nothing {
        /// `undo` or `redo`.
        what: &'static str,
    },
    /// The pool does not take its marks.
    #[error("cannot mark sheep of the pool: {error}")]
    Pool {
        /// Why.
        error: String,
    },
}

/// Why a note was not made.
#[derive(Debug, thiserror::Error)]
pub(crate) enum NoteError {
    /// The disk.
    #[error("cannot save the notes: {0}")]
    Disk(#[from] io::Error),
    /// The pool does not take its marks.
    #[error("cannot mark sheep of the pool: {error}")]
    Pool {
        /// Why.
        error: String,
    },
    /// The note is wrong.
    #[error(transparent)]
    Refused(#[from] NoteRefusal),
}

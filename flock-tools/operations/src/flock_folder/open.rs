//! Opens a flock, for every command alike.
//!
//! Owns the exit codes of a manifest's errors. Never judges the flock.

use std::io::ErrorKind;
use std::path::Path;
use std::sync::Arc;

use flock::{Draft, DraftError, Flock, Manifest, ManifestError};

use crate::program::{Exit, Fatal, print};

/// A flock without a cycle of transitions.
#[derive(Debug, thiserror::Error)]
#[error(
    "flock `{name}` cannot be walked: none of its transitions lies on a cycle (it has {})",
    print::count(*.transitions, "transition")
)]
struct NoCycle {
    name: String,
    transitions: usize,
}

/// Reads the manifest in `folder`.
pub fn manifest(folder: &Path) -> Result<Manifest, Fatal> {
    Ok(Manifest::read(folder)?)
}

/// The same, of a flock that may be without sheep.
pub fn unfinished(folder: &Path) -> Result<Manifest, Fatal> {
    match Manifest::read(folder) {
        Err(ManifestError::Missing { key: "sheep", .. }) => Ok(Draft::lock(folder)?.edit.manifest().clone()),
        read => Ok(read?),
    }
}

/// Ends a command whose manifest cannot be read.
impl From<ManifestError> for Fatal {
    fn from(error: ManifestError) -> Self {
        let exit = match error {
            // A file that was read and is no text is malformed.
            ManifestError::Read { ref source, .. } if source.kind() != ErrorKind::InvalidData => Exit::Unreadable,
            ManifestError::Missing { .. }
            | ManifestError::NotPlain { .. }
            | ManifestError::Read { .. }
            | ManifestError::Syntax { .. }
            | ManifestError::TooLarge { .. }
            | ManifestError::UnknownKey { .. }
            | ManifestError::Value { .. } => Exit::Malformed,
        };
        let hint = error.hint();
        let fatal = Self::new(exit, error);
        if let Some(hint) = hint { fatal.hint(hint) } else { fatal }
    }
}

/// Ends a command whose edit cannot be saved.
impl From<DraftError> for Fatal {
    fn from(error: DraftError) -> Self {
        match error {
            DraftError::Save { path, source } => Self::file("save", &path, source),
            mismatch @ DraftError::Mismatch { .. } => Self::new(Exit::Unreadable, mismatch),
        }
    }
}

/// Reads the flock in `folder`, which must have a cycle to walk.
pub fn walkable(folder: &Path) -> Result<Arc<Flock>, Fatal> {
    let flock = Flock::new(manifest(folder)?);
    if flock.is_walkable() { Ok(Arc::new(flock)) } else { Err(no_cycle(&flock)) }
}

/// Ends a command that needs a cycle where `flock` has none.
pub fn no_cycle(flock: &Flock) -> Fatal {
    let (name, transitions) = (flock.manifest().name.clone(), flock.manifest().transitions.len());
    Fatal::new(Exit::No, NoCycle { name, transitions }).hint("`dreams check` names the sheep that lead nowhere")
}

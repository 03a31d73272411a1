//! Bundles: how a flock, or a system, is signed, sent to its units, and looked at on the way.
//!
//! Owns what these commands have in common: how an error of a key, of a bundle or of a folder ends a command. What a
//! bundle is, the bundle crate says; each command has its own module here. Never opens a socket: what is published is
//! a folder.
//!
//! Start at [`pack`].

mod counter;
pub(crate) mod diff;
mod fleet;
pub(crate) mod keygen;
pub(crate) mod listing;
pub(crate) mod pack;
mod passphrase;
pub(crate) mod publish;
mod shelf;
pub(crate) mod system;
pub(crate) mod verify;

use bundle::{FolderError, KeyError, Refusal, SignError};

use crate::report::{Exit, Fatal};

/// The end of a command that cannot use a key.
fn unusable(error: KeyError) -> Fatal {
    let (exit, hint) = match &error {
        KeyError::Locked { .. } => (Exit::No, None),
        KeyError::Open { path, .. } => (Exit::No, Some(format!("chmod 600 {}", path.display()))),
        KeyError::Malformed { .. } | KeyError::SameId { .. } | KeyError::TooMany { .. } => (Exit::Malformed, None),
        KeyError::Read { .. } | KeyError::Sign { .. } | KeyError::Write { .. } => (Exit::Unreadable, None),
    };
    let fatal = Fatal::new(exit, error);
    if let Some(hint) = hint { fatal.hint(hint) } else { fatal }
}

/// The end of a command that refuses a bundle.
fn refused(error: Refusal) -> Fatal {
    Fatal::new(if error.is_io() { Exit::Unreadable } else { Exit::No }, error)
}

/// The end of a command that cannot sign a bundle.
fn unsigned(error: SignError) -> Fatal {
    match error {
        SignError::Key(error) => unusable(error),
        SignError::Refused(_) => Fatal::new(Exit::No, error),
    }
}

/// The end of a command that cannot read or write a folder of bundles.
fn unmoved(error: FolderError) -> Fatal {
    let exit = match error {
        FolderError::Changed { .. } => Exit::No,
        FolderError::Read { .. } | FolderError::Write { .. } => Exit::Unreadable,
    };
    Fatal::new(exit, error)
}

//! Bundles: a flock, a system or settings, signed, published for its units, and verified.
//!
//! Owns what these commands have in common: how an error of a key, of a bundle or of a folder ends a command. Each command
//! has its own module; the form of a bundle is the bundle crate's. Never opens a socket: a bundle is published as a folder.
//!
//! Start at [`pack`].

mod bundle_folder;
mod counter;
pub mod diff;
mod fleet;
pub mod keygen;
pub mod pack;
mod passphrase;
pub mod publish;
pub mod settings;
pub mod system;
pub mod verify;

use bundle::{FolderError, KeyError, Refusal, SignError};
use operations::program::{Exit, Fatal};

/// Ends a command that cannot use a key.
fn key_fatal(error: KeyError) -> Fatal {
    let (exit, hint) = match &error {
        KeyError::Locked { .. } => (Exit::No, None),
        KeyError::Open { path, .. } => (Exit::No, Some(format!("chmod 600 {}", path.display()))),
        KeyError::Malformed { .. } | KeyError::SameId { .. } | KeyError::TooMany { .. } => (Exit::Malformed, None),
        KeyError::Read { .. } | KeyError::Sign { .. } | KeyError::Write { .. } => (Exit::Unreadable, None),
    };
    let fatal = Fatal::new(exit, error);
    if let Some(hint) = hint { fatal.hint(hint) } else { fatal }
}

/// Ends a command that refuses a bundle.
fn refusal_fatal(error: Refusal) -> Fatal {
    Fatal::new(if error.is_io() { Exit::Unreadable } else { Exit::No }, error)
}

/// Ends a command that cannot sign a bundle.
fn sign_fatal(error: SignError) -> Fatal {
    match error {
        SignError::Key(error) => key_fatal(error),
        SignError::Refused(_) => Fatal::new(Exit::No, error),
    }
}

/// Ends a command that cannot read or write a folder of bundles.
fn folder_fatal(error: FolderError) -> Fatal {
    let exit = match error {
        FolderError::Changed { .. } => Exit::No,
        FolderError::Read { .. } | FolderError::Write { .. } => Exit::Unreadable,
    };
    Fatal::new(exit, error)
}

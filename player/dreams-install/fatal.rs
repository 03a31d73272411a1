//! Why the installer ends without having installed anything.
//!
//! Owns [`Fatal`], and the exit status of each. What a person can put right is a page instead: `conversation.rs`.

use diagnostics::{Exit, print_error};
use player::ThreadError;
use std::io;
use std::path::PathBuf;
use std::process::ExitCode;

/// Why it ends.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Fatal {
    #[error("`{path}` is no stick that installs: it has no partition `dreams_install` beside those of a unit", path = path.display())]
    NoStick { path: PathBuf },
    #[error("cannot read the stick `{path}`", path = path.display())]
    Read { path: PathBuf, source: io::Error },
    #[error("cannot start the machine again")]
    Restart(#[source] io::Error),
    #[error(transparent)]
    Thread(#[from] ThreadError),
}

/// Ends the program.
pub(crate) fn finish(result: Result<(), Fatal>) -> ExitCode {
    let Err(fatal) = result else { return ExitCode::from(Exit::Fine) };
    let (exit, hint) = match fatal {
        Fatal::NoStick { .. } => (Exit::Malformed, Some("`make image installer=yes` makes its image")),
        Fatal::Read { .. } => (Exit::Unreadable, Some("write the image to the stick again, or to another one")),
        Fatal::Restart(_) => (Exit::Unreadable, Some("switch the machine off and on again")),
        Fatal::Thread(_) => (Exit::Unreadable, None),
    };
    print_error(&fatal, hint);
    ExitCode::from(exit)
}

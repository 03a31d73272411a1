//! Why `dreams-votes` ends.
//!
//! Owns [`Fatal`] and its exit codes. A device or a player that is not there is waited for and ends nothing.

use diagnostics::{Exit, print_error};
use settings::ConfigError;
use std::io;
use std::path::PathBuf;
use std::process::ExitCode;
use votes::VotesError;

/// Why no votes are counted or shown.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Fatal {
    #[error(transparent)]
    Config(#[from] ConfigError),
    #[error("cannot write `{path}`", path = path.display())]
    Copy { path: PathBuf, source: io::Error },
    #[error("there are no votes in `{store}`", store = store.display())]
    Nothing { store: PathBuf },
    #[error("cannot listen for signals")]
    Signals(#[source] ctrlc::Error),
    #[error(transparent)]
    Store(#[from] VotesError),
    #[error("cannot write the answer to standard output")]
    Unwritten(#[source] io::Error),
}

impl Fatal {
    fn exit(&self) -> Exit {
        match self {
            Self::Config(ConfigError::Malformed { .. }) => Exit::Malformed,
            Self::Nothing { .. } => Exit::No,
            Self::Config(ConfigError::Read { .. })
            | Self::Copy { .. }
            | Self::Signals(_)
            | Self::Store(_)
            | Self::Unwritten(_) => Exit::Unreadable,
        }
    }

    fn hint(&self) -> &'static str {
        match self {
            Self::Config(_) => "every key is explained in `config/votes.toml`",
            Self::Copy { .. } => "`--copy-to FOLDER` needs a folder that exists and may be written",
            Self::Nothing { .. } => "the first showing is counted when it is over",
            Self::Store(_) => "`store` names a folder that exists and may be read and written; what is in it stays",
            Self::Signals(_) | Self::Unwritten(_) => "nothing is wrong with the votes",
        }
    }
}

/// Ends the program: silently if all went well, else with the error and what to do about it.
pub(crate) fn finish(result: Result<(), Fatal>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::from(Exit::Fine),
        Err(fatal) => {
            print_error(&fatal, Some(fatal.hint()));
            ExitCode::from(fatal.exit())
        }
    }
}

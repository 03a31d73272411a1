//! How an update ends: its answer on standard output, or its error on standard error.
//!
//! Owns [`Fatal`] and its exit codes. The notices are in `sentences.rs`.

use crate::answer::Answer;
use crate::stick_format::StickFormat;
use bundle::{FolderError, KeyError, NameError, Refusal, Shortfall, StoreError, UnitId, few};
use diagnostics::{Exit, print_error};
use player::Output;
use settings::ConfigError;
use std::io;
use std::path::PathBuf;
use std::process::ExitCode;

/// Why nothing was installed. What plays is what played before.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Fatal {
    #[error("`{address}` is not an address of a web server")]
    Address { address: String },
    #[error("another update is at work on `{store}`", store = store.display())]
    Busy { store: PathBuf },
    #[error(transparent)]
    Config(#[from] ConfigError),
    #[error("the stick is formatted as `{format}` (expected FAT32 or exFAT)")]
    Format { format: StickFormat },
    #[error("`{place}` has bundles for `{}`, none for `{unit}`", few(.units))]
    ForOthers { place: String, units: Vec<UnitId>, unit: UnitId },
    #[error("cannot read the machine's name in `{path}`", path = path.display())]
    Host { path: PathBuf, source: io::Error },
    #[error(transparent)]
    Keys(KeyError),
    #[error("this unit has no name of its own")]
    Nameless(#[source] NameError),
    #[error("no source of flocks is given")]
    Nowhere,
    #[error("cannot read `{name}` from the source")]
    Read { name: String, source: io::Error },
    #[error(transparent)]
    Refused(Refusal),
    #[error("there is no room: {} bytes are needed, {} are free", .0.needed, .0.room)]
    Room(Shortfall),
    #[error("cannot listen for signals")]
    Signals(#[source] ctrlc::Error),
    #[error("cannot {doing} `{path}`", path = path.display())]
    Slot { doing: &'static str, path: PathBuf, source: io::Error },
    #[error(transparent)]
    Source(FolderError),
    #[error("stopped by a signal")]
    Stopped,
    #[error(transparent)]
    Store(StoreError),
    #[error("cannot write the answer to standard output")]
    Unwritten(#[source] io::Error),
}

impl From<StoreError> for Fatal {
    fn from(error: StoreError) -> Self {
        if let StoreError::Refused(refused) = error { Self::Refused(refused) } else { Self::Store(error) }
    }
}

impl Fatal {
    pub(crate) fn exit(&self) -> Exit {
        match self {
            Self::Address { .. } | Self::Config(ConfigError::Malformed { .. }) | Self::Nameless(_) | Self::Nowhere => {
                Exit::Malformed
            }
            Self::ForOthers { .. } | Self::Format { .. } | Self::Room(_) => Exit::No,
            Self::Refused(refused) if !refused.is_io() => Exit::No,
            Self::Keys(error) if !matches!(error, KeyError::Read { .. }) => Exit::Malformed,
            Self::Busy { .. }
            | Self::Config(ConfigError::Read { .. })
            | Self::Host { .. }
            | Self::Keys(_)
            | Self::Read { .. }
            | Self::Refused(_)
            | Self::Signals(_)
            | Self::Slot { .. }
            | Self::Source(_)
            | Self::Stopped
            | Self::Store(_)
            | Self::Unwritten(_) => Exit::Unreadable,
        }
    }

    fn hint(&self) -> &'static str {
        match self {
            Self::Address { .. } | Self::Nowhere => {
                "name a folder, or an address as `https://example.org/flocks`, here or as `url` in the config"
            }
            Self::Busy { .. } => "it ends by itself; start again then",
            Self::Config(_) => "every key is explained in `config/update.toml`",
            Self::ForOthers { .. } | Self::Refused(Refusal::ForOthers { .. }) => {
                "`--unit NAME` says what this unit is called; `dreams pack --unit NAME` addresses a bundle to it"
            }
            Self::Format { .. } => "format it as FAT32 or exFAT, which deletes what is on it, and publish to it again",
            Self::Host { .. } | Self::Nameless(_) => "name the unit: `unit` in the config, or `--unit NAME`",
            Self::Keys(_) => "lay the artist's public key into the folder that `keys` names",
            Self::Refused(Refusal::ForEverybody { .. } | Refusal::Older { .. } | Refusal::MarkedBad { .. }) => {
                "`--allow-older` takes it all the same, once"
            }
            Self::Refused(Refusal::UnknownKey { .. }) => {
                "if the key is the artist's, lay its file into the folder that `keys` names"
            }
            Self::Refused(refused) if !refused.is_io() => "nothing was changed; ask whoever made the bundle",
            Self::Room(_) => "free some room on the disk of the store, or lower `reserve_mib`",
            Self::Read { .. } | Self::Refused(_) | Self::Source(_) | Self::Stopped => {
                "what was fetched stays; the next attempt goes on from there"
            }
            Self::Slot { .. } => "the disk may be failing; the system that runs goes on",
            Self::Signals(_) | Self::Unwritten(_) => "nothing is wrong with the unit's flock",
            Self::Store(_) => "the store's disk may be full or failing; what plays goes on",
        }
    }
}

/// Ends the program: with the answer, or with the error and what to do about it.
pub(crate) fn finish(result: Result<Output<Answer>, Fatal>) -> ExitCode {
    let fatal = match result.and_then(|output| output.print().map_err(Fatal::Unwritten)) {
        Ok(()) => return ExitCode::from(Exit::Fine),
        Err(fatal) => fatal,
    };
    print_error(&fatal, Some(fatal.hint()));
    ExitCode::from(fatal.exit())
}

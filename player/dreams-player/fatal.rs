//! Why the player ends.
//!
//! Owns [`Fatal`] and its exit codes. What goes wrong while playing is a fault and ends nothing: `recording/faults.rs`.

use diagnostics::{Exit, print_error};
use flock::ManifestError;
use player::ThreadError;
use screen::ScreenError;
use settings::ConfigError;
use std::io;
use std::path::PathBuf;
use std::process::ExitCode;

/// Why the player does not play.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Fatal {
    #[error(transparent)]
    Config(#[from] ConfigError),
    #[error(transparent)]
    Decoder(#[from] video::SessionError),
    #[error(transparent)]
    Flock(#[from] ManifestError),
    #[error("cannot hand the first picture over at `{socket}`")]
    HandOver { socket: &'static str, source: io::Error },
    #[error("none of the flock's clips in `{flock}` can be played", flock = flock.display())]
    NothingToPlay { flock: PathBuf },
    #[error(transparent)]
    Screen(#[from] ScreenError),
    #[error("cannot listen for signals")]
    Signals(#[source] ctrlc::Error),
    #[error(transparent)]
    Thread(#[from] ThreadError),
    #[error("{played} of {wanted} clips were played, then no clip of `{flock}` could be", flock = flock.display())]
    TooFew { flock: PathBuf, wanted: u64, played: u64 },
    #[error("the new flock cannot be shown here, the one before comes back")]
    Trial(#[source] ScreenError),
    #[error("cannot write trace `{path}`", path = path.display())]
    Trace { path: PathBuf, source: io::Error },
}

impl Fatal {
    fn exit(&self) -> Exit {
        match self {
            Self::NothingToPlay { .. } | Self::TooFew { .. } | Self::Trial(_) => Exit::No,
            Self::Config(ConfigError::Read { source, .. }) | Self::Flock(ManifestError::Read { source, .. })
                if source.kind() == io::ErrorKind::InvalidData =>
            {
                // It was read, and is no text.
                Exit::Malformed
            }
            Self::Config(ConfigError::Read { .. })
            | Self::Decoder(_)
            | Self::HandOver { .. }
            | Self::Flock(ManifestError::Read { .. })
            | Self::Screen(ScreenError::Open { .. })
            | Self::Signals(_)
            | Self::Thread(_)
            | Self::Trace { .. } => Exit::Unreadable,
            Self::Config(_) | Self::Flock(_) | Self::Screen(_) => Exit::Malformed,
        }
    }

    fn hint(&self) -> &'static str {
        match self {
            Self::Config(_) => "every key is explained in `config/player.toml`",
            Self::Flock(_) => "`dreams check DIR` names every fault of a flock; `--flock DIR` names another one",
            Self::NothingToPlay { .. } | Self::TooFew { .. } => "`dreams check DIR` says what is wrong with each clip",
            Self::Screen(ScreenError::Size { .. }) => "choose a screen at least as large as the flock's pictures",
            Self::Trial(_) => "start again",
            Self::Screen(_) => "`--screen virtual` plays without a display",
            Self::Decoder(_) | Self::Signals(_) | Self::Thread(_) => "the machine is out of threads or memory",
            Self::HandOver { .. } => "`--prelude` needs its folder, and that no other one is held",
            Self::Trace { .. } => "`--trace FILE` needs a folder that exists and may be written",
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

#[cfg(test)]
mod tests {
    use super::{Exit, Fatal};
    use diagnostics::chain;
    use settings::{ConfigError, config_file};
    use std::io;

    #[test]
    fn an_error_says_what_caused_it_once() {
        let source = io::Error::other("device vanished");
        let fatal = Fatal::from(ConfigError::Read { path: "/etc/player.toml".into(), source });
        assert_eq!(chain(&fatal), "cannot read config `/etc/player.toml`: device vanished");
        assert_eq!(fatal.exit(), Exit::Unreadable);
    }

    #[test]
    fn a_file_that_is_no_text_is_malformed_and_not_unreadable() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("flock.toml"), b"name = \"\xff\xfe\"").unwrap();
        let fatal = Fatal::from(flock::Manifest::read(folder.path()).unwrap_err());
        assert_eq!(fatal.exit(), Exit::Malformed);
        let fatal = Fatal::from(config_file::load::<toml::Table>(&folder.path().join("flock.toml")).unwrap_err());
        assert_eq!(fatal.exit(), Exit::Malformed);
    }
}

//! How a command ends: its exit code, and its error on stderr.
//!
//! Owns [`Fatal`], the error that ends a command, and [`finish`]. Never prints an answer: `print.rs` does.

use std::error::Error;
use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use exit::Exit;

use super::print::AnswerError;

/// The error that ends a command.
#[derive(Debug)]
pub(crate) struct Fatal {
    exit: Exit,
    error: Box<dyn Error>,
    hint: Option<String>,
}

/// A file or folder that cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("cannot {verb} `{path}`")]
struct FileError {
    verb: &'static str,
    path: PathBuf,
    source: io::Error,
}

impl Fatal {
    /// Ends with `exit` because of `error`.
    pub(crate) fn new(exit: Exit, error: impl Into<Box<dyn Error>>) -> Self {
        Self { exit, error: error.into(), hint: None }
    }

    /// Ends because a file or a folder cannot be used: cannot `verb` the one at `path`.
    pub(crate) fn file(verb: &'static str, path: &Path, source: io::Error) -> Self {
        Self::new(Exit::Unreadable, FileError { verb, path: path.to_owned(), source })
    }

    /// Ends because the file or the folder at `path` cannot be read.
    pub(crate) fn read(path: &Path, source: io::Error) -> Self {
        Self::file("read", path, source)
    }

    /// Ends because the file or the folder at `path` cannot be written.
    pub(crate) fn write(path: &Path, source: io::Error) -> Self {
        Self::file("write", path, source)
    }

    /// Adds what to do about it.
    pub(crate) fn hint(self, hint: impl Into<String>) -> Self {
        Self { hint: Some(hint.into()), ..self }
    }
}

/// Prints the error, if there is one, and gives the exit code of the process. `result` is a [`clap::Error`] where the
/// command line is wrong or help was asked for.
pub(crate) fn finish(result: Result<Result<Exit, Fatal>, clap::Error>) -> ExitCode {
    let exit = match result {
        Ok(Ok(exit)) => exit,
        Ok(Err(fatal)) => fail(&fatal),
        Err(usage) => {
            // Help is an answer; clap knows which stream each goes to.
            match usage.print() {
                _ if usage.use_stderr() => Exit::Malformed,
                // The reader closed the pipe after the first lines.
                Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
                    fail(&Fatal::new(Exit::Unreadable, AnswerError(error)))
                }
                Ok(()) | Err(_) => Exit::Fine,
            }
        }
    };
    exit.into()
}

/// Prints `error: ...` with its causes, and the hint below a blank line.
fn fail(fatal: &Fatal) -> Exit {
    exit::print_error(&*fatal.error, fatal.hint.as_deref());
    fatal.exit
}

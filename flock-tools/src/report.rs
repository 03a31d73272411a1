//! How a command ends: its exit status, its answer on stdout, its error on stderr.
//!
//! Owns [`Exit`], [`Fatal`] and the only places that print. Data goes to stdout, everything else to stderr.

use std::error::Error;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use flock::SheepId;
use serde::Serialize;

/// The exit statuses of every command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Exit {
    /// Fine.
    Fine = 0,
    /// The answer is no: faults found, a balance unreachable, a bundle refused.
    No = 1,
    /// Bad usage or a malformed file.
    Malformed = 2,
    /// A file, device or network could not be read or written.
    Unreadable = 3,
}

/// Why a command could not answer.
#[derive(Debug)]
pub(crate) struct Fatal {
    exit: Exit,
    error: Box<dyn Error>,
    hint: Option<String>,
}

/// What could not be written.
#[derive(Debug, thiserror::Error)]
enum Unwritten {
    #[error("cannot write the answer to stdout")]
    Answer(#[source] io::Error),
    #[error("cannot write `{path}`")]
    File { path: PathBuf, source: io::Error },
}

impl Fatal {
    /// Ends with `exit` because of `error`.
    pub(crate) fn new(exit: Exit, error: impl Into<Box<dyn Error>>) -> Self {
        Self { exit, error: error.into(), hint: None }
    }

    /// Ends because the file or the folder at `path` cannot be written.
    pub(crate) fn unwritten(path: &Path, source: io::Error) -> Self {
        Self::new(Exit::Unreadable, Unwritten::File { path: path.to_owned(), source })
    }

    /// Adds what to do about it.
    pub(crate) fn hint(self, hint: impl Into<String>) -> Self {
        Self { hint: Some(hint.into()), ..self }
    }
}

/// Ends the process: the command line was wrong, the command failed, or it said how it went.
pub(crate) fn finish(ended: Result<Result<Exit, Fatal>, clap::Error>) -> ExitCode {
    let exit = match ended {
        Ok(Ok(exit)) => exit,
        Ok(Err(fatal)) => fail(&fatal),
        Err(usage) => {
            // Help asked for is data and fine; clap knows which stream each goes to.
            match usage.print() {
                _ if usage.use_stderr() => Exit::Malformed,
                // Whoever read the first lines has enough.
                Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
                    fail(&Fatal::new(Exit::Unreadable, Unwritten::Answer(error)))
                }
                Ok(()) | Err(_) => Exit::Fine,
            }
        }
    };
    ExitCode::from(exit as u8)
}

/// Prints `error: ...` with its causes, and the hint below a blank line.
fn fail(fatal: &Fatal) -> Exit {
    note(&format!("error: {}", chain(&*fatal.error)));
    if let Some(hint) = &fatal.hint {
        note(&format!("\nhint: {hint}"));
    }
    fatal.exit
}

/// An error and its causes, in one line.
pub(crate) fn chain(error: &dyn Error) -> String {
    let mut told = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        told = format!("{told}: {error}");
        cause = error.source();
    }
    told
}

/// One line for people, on stderr.
pub(crate) fn note(line: &str) {
    // Nobody is left to tell if stderr is closed.
    let _ = writeln!(io::stderr(), "{line}");
}

/// So many of a `thing`, whose plural ends in `s`: `no faults`, `1 fault`, `2 faults`.
pub(crate) fn count(count: usize, thing: &str) -> String {
    match count {
        0 => format!("no {thing}s"),
        1 => format!("1 {thing}"),
        _ => format!("{count} {thing}s"),
    }
}

/// How wide a column of these ids is, in characters.
pub(crate) fn widest<'a>(ids: impl Iterator<Item = &'a SheepId>) -> usize {
    ids.map(|id| id.as_str().len()).chain(["sheep".len()]).max().unwrap_or_default()
}

/// The answer as one JSON document.
pub(crate) fn json(answer: &impl Serialize) -> Result<(), Fatal> {
    let text = serde_json::to_string_pretty(answer).map_err(|error| Fatal::new(Exit::Unreadable, error))?;
    lines([text])
}

/// The answer as lines of text.
pub(crate) fn lines(lines: impl IntoIterator<Item = String>) -> Result<(), Fatal> {
    let mut out = io::BufWriter::new(io::stdout().lock());
    let write = |line: String| writeln!(out, "{line}");
    let written = lines.into_iter().try_for_each(write).and_then(|()| out.flush());
    match written {
        // Whoever read the first lines has enough: `flock walk ... | head`.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        written => written.map_err(|source| Fatal::new(Exit::Unreadable, Unwritten::Answer(source))),
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn every_subcommand_tells_its_exit_statuses() {
        let mut command = crate::Args::command();
        for subcommand in command.get_subcommands_mut() {
            let help = subcommand.render_long_help().to_string();
            let (_, block) = help.split_once("Exit status:\n").expect("an `Exit status:` block");
            for status in 0..=3 {
                assert!(block.contains(&format!("\n  {status}  ")) || block.starts_with(&format!("  {status}  ")));
            }
        }
    }
}

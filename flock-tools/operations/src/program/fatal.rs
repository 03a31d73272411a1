//! How a command ends: its exit code, and its error on stderr, with `--json` on stdout too.
//!
//! Owns [`Fatal`], the error that ends a command, its form as a JSON document, and [`end`]. A command that has answered
//! before it ends with an error, as one that refuses does, keeps its answer.

use std::borrow::Cow;
use std::env;
use std::error::Error;
use std::io;
use std::iter;
use std::path::{Path, PathBuf};

use diagnostics::{Exit, chain};
use flame::genome::Reasons;

use super::print;
use super::reasons::{self, reasons_of};

/// The error that ends a command.
#[derive(Debug)]
pub struct Fatal {
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
    pub fn new(exit: Exit, error: impl Into<Box<dyn Error>>) -> Self {
        Self { exit, error: error.into(), hint: None }
    }

    /// Ends because a file or a folder cannot be used: cannot `verb` the one at `path`.
    pub fn file(verb: &'static str, path: &Path, source: io::Error) -> Self {
        Self::new(Exit::Unreadable, FileError { verb, path: path.to_owned(), source })
    }

    /// Ends because the file or the folder at `path` cannot be read.
    pub fn read(path: &Path, source: io::Error) -> Self {
        Self::file("read", path, source)
    }

    /// Ends because the file or the folder at `path` cannot be written.
    pub fn write(path: &Path, source: io::Error) -> Self {
        Self::file("write", path, source)
    }

    /// Ends in the same way, because of what `told` makes of the error.
    #[must_use]
    pub fn told_as<E: Into<Box<dyn Error>>>(self, told: impl FnOnce(Box<dyn Error>) -> E) -> Self {
        Self { exit: self.exit, error: told(self.error).into(), hint: self.hint }
    }

    /// The error with its causes, in one line.
    pub fn in_words(&self) -> String {
        chain(&*self.error)
    }

    /// Adds what to do about it.
    #[must_use]
    pub fn hint(self, hint: impl Into<String>) -> Self {
        Self { hint: Some(hint.into()), ..self }
    }
}

/// The answer with `--json` of a command that ends with an error and has not answered.
#[derive(serde::Serialize)]
struct Answer {
    error: ErrorAnswer,
}

#[derive(Debug, PartialEq, serde::Serialize)]
struct ErrorAnswer {
    message: String,
    /// The nearest first.
    causes: Vec<String>,
    /// What to do about it; `null` if nothing is known to help.
    hint: Option<String>,
    /// The exit status.
    exit: u8,
    /// What a genome asks for that is not drawn, if it is refused for that.
    #[serde(skip_serializing_if = "Reasons::is_empty", serialize_with = "reasons::serialize")]
    reasons: Reasons,
}

/// The exit code of a command. Prints the error that ended it, if one did.
pub fn end(result: Result<Exit, Fatal>) -> Exit {
    result.unwrap_or_else(|fatal| fail(&fatal))
}

/// Prints `error: ...` with its causes, and the hint below a blank line; with `--json` also as a document.
fn fail(fatal: &Fatal) -> Exit {
    if wants_json() && !print::is_answered() {
        // What keeps the answer from being written is told on stderr alone.
        let _ = print::json(&Answer { error: ErrorAnswer::of(fatal) });
    }
    diagnostics::print_error(&*fatal.error, fatal.hint.as_deref());
    fatal.exit
}

/// Prints the error `text` of a wrong command line, by `print` where a terminal obeys nothing of it; with `--json` also as
/// a document.
pub fn misuse(text: &str, print: impl FnOnce() -> io::Result<()>) -> Exit {
    if wants_json() {
        let _ = print::json(&Answer { error: ErrorAnswer::of_usage(text) });
    }
    // The words of the command line are quoted as they were given.
    let is_visible = text.lines().all(|line| matches!(print::visible(line), Cow::Borrowed(_)));
    let printed = if is_visible { print() } else { Err(io::ErrorKind::InvalidData.into()) };
    if printed.is_err() {
        text.lines().for_each(print::note);
    }
    Exit::Malformed
}

/// Whether the command line asks for JSON. It may be one that cannot be parsed.
fn wants_json() -> bool {
    env::args_os().take_while(|word| word != "--").any(|word| word == "--json")
}

impl ErrorAnswer {
    fn of(fatal: &Fatal) -> Self {
        let causes = iter::successors(fatal.error.source(), |error| (*error).source());
        Self {
            message: fatal.error.to_string(),
            causes: causes.map(ToString::to_string).collect(),
            hint: fatal.hint.clone(),
            exit: fatal.exit as u8,
            reasons: reasons_of(&*fatal.error).cloned().unwrap_or_default(),
        }
    }

    /// That of clap's `text`: the error in the first paragraph, tips and usage in the others.
    fn of_usage(text: &str) -> Self {
        let (message, rest) = text.split_once("\n\n").unwrap_or((text, ""));
        let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
        let tips = rest.lines().filter_map(|line| line.trim().strip_prefix("tip: "));
        let tips = tips.map(words).collect::<Vec<_>>().join("; ");
        Self {
            message: words(message.trim_start_matches("error: ")),
            causes: Vec::new(),
            hint: Some(tips).filter(|tips| !tips.is_empty()),
            exit: Exit::Malformed as u8,
            reasons: Reasons::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_command_line_is_told_in_one_sentence_with_its_tips() {
        let text = "error: unrecognized subcommand 'chekc'\n\n  tip: a similar subcommand exists: 'check'\n\n\
                    Usage: dreams <COMMAND>\n\nFor more information, try '--help'.\n";
        let answer = ErrorAnswer::of_usage(text);
        assert_eq!(answer.message, "unrecognized subcommand 'chekc'");
        assert_eq!(answer.hint.as_deref(), Some("a similar subcommand exists: 'check'"));
        let text = "error: the following required arguments were not provided:\n  <DIR>\n\nUsage: dreams check <DIR>\n";
        let answer = ErrorAnswer::of_usage(text);
        assert_eq!(answer.message, "the following required arguments were not provided: <DIR>");
        assert_eq!((answer.hint, answer.exit), (None, 2));
    }

    #[test]
    fn an_error_is_told_with_its_causes_and_what_to_do() {
        let fatal = Fatal::read(Path::new("a"), io::Error::other("no disk")).hint("insert it");
        let told = ErrorAnswer::of(&fatal);
        let causes = vec!["no disk".to_owned()];
        let hint = Some("insert it".to_owned());
        let (message, reasons) = ("cannot read `a`".to_owned(), Reasons::default());
        assert_eq!(told, ErrorAnswer { message, causes, hint, exit: 3, reasons });
    }
}

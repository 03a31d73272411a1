//! The only places that print: answers go to stdout, everything else to stderr.
//!
//! Owns the forms of an answer, JSON or lines, and how numbers of things are written. Never ends a command.

use std::io::{self, Write};

use exit::Exit;
use flock::SheepId;
use serde::Serialize;

use super::fatal::Fatal;

/// An answer that cannot be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write the answer to stdout")]
pub(super) struct AnswerError(#[source] pub(super) io::Error);

/// One line for people, on stderr.
pub(crate) fn note(line: &str) {
    // If stderr is closed there is no other place for it.
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

/// The width of a column of these ids, in characters.
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
        // The reader closed the pipe after the first lines: `dreams walk ... | head`.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        written => written.map_err(|source| Fatal::new(Exit::Unreadable, AnswerError(source))),
    }
}

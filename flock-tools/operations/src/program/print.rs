//! The only places that print: answers go to stdout, everything else to stderr.
//!
//! Owns the forms of an answer, JSON or lines, and how numbers of things are written. Never ends a command. What is for
//! people is [`visible`] text: nothing that a name contains has an effect on a terminal. Into a file or a pipe an answer
//! goes as it is.

use std::borrow::Cow;
use std::io::{self, IsTerminal, Write};
use std::os::unix::ffi::OsStrExt;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

pub use diagnostics::visible;
use diagnostics::{Exit, is_visible};
use flock::SheepId;
use serde::{Serialize, Serializer};

use super::fatal::Fatal;

/// An answer that cannot be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write the answer to stdout")]
struct AnswerError(#[source] io::Error);

/// Whether this command has answered with a JSON document: there is one at most.
static ANSWERED: AtomicBool = AtomicBool::new(false);

/// One line for people, on stderr.
pub fn note(line: &str) {
    // If stderr is closed there is no other place for it.
    let _ = writeln!(io::stderr(), "{}", visible(line));
}

/// So many of a `thing`, whose plural ends in `s`: `no faults`, `1 fault`, `2 faults`.
pub fn count(count: usize, thing: &str) -> String {
    match count {
        0 => format!("no {thing}s"),
        1 => format!("1 {thing}"),
        _ => format!("{count} {thing}s"),
    }
}

/// A path as [`visible`] text, for people and for scripts: a byte that is not UTF-8 is `\xff`, a backslash `\\`.
pub fn path(path: &Path) -> String {
    let mut text = String::new();
    for chunk in path.as_os_str().as_bytes().utf8_chunks() {
        text.push_str(&visible(&chunk.valid().replace('\\', "\\\\")));
        text.extend(chunk.invalid().iter().map(|byte| format!("\\x{byte:02x}")));
    }
    text
}

/// The same in a JSON document.
pub fn serialize_path<S: Serializer>(name: impl AsRef<Path>, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&path(name.as_ref()))
}

/// The width of a column of these ids, in characters.
pub fn widest<'a>(ids: impl Iterator<Item = &'a SheepId>) -> usize {
    ids.map(|id| id.as_str().len()).chain(["sheep".len()]).max().unwrap_or_default()
}

/// The answer as one JSON document, which may be larger than the flock that it is about: it is written as it is made.
pub fn json(answer: &impl Serialize) -> Result<(), Fatal> {
    ANSWERED.store(true, Ordering::Relaxed);
    if io::stdout().is_terminal() {
        let document = serde_json::to_string_pretty(answer).map_err(|error| Fatal::new(Exit::Unreadable, error))?;
        return lines(document.lines().map(escaped));
    }
    let mut out = io::BufWriter::new(io::stdout().lock());
    let written = serde_json::to_writer_pretty(&mut out, answer).map_err(io::Error::from);
    finish(written.and_then(|()| writeln!(out)).and_then(|()| out.flush()))
}

/// A line of a JSON document, with the characters that a terminal obeys as JSON escapes them. They stand in texts only.
fn escaped(line: &str) -> String {
    let escape = |c: char| if is_visible(c) { c.to_string() } else { format!("\\u{:04x}", u32::from(c)) };
    line.chars().map(escape).collect()
}

/// Whether [`json`] has answered.
pub(super) fn is_answered() -> bool {
    ANSWERED.load(Ordering::Relaxed)
}

/// The answer as a text of many lines, without the end of the last one.
pub fn text(text: &str) -> Result<(), Fatal> {
    written([Cow::Borrowed(text)])
}

/// The answer as lines of text.
pub fn lines(lines: impl IntoIterator<Item = String>) -> Result<(), Fatal> {
    let for_people = io::stdout().is_terminal();
    written(lines.into_iter().map(|line| if for_people { visible(&line).into_owned() } else { line }.into()))
}

fn written<'t>(lines: impl IntoIterator<Item = Cow<'t, str>>) -> Result<(), Fatal> {
    let mut out = io::BufWriter::new(io::stdout().lock());
    let write = |line: Cow<'t, str>| writeln!(out, "{line}");
    let written = lines.into_iter().try_for_each(write);
    finish(written.and_then(|()| out.flush()))
}

/// What becomes of a command whose answer was `written`.
pub fn finish(written: io::Result<()>) -> Result<(), Fatal> {
    match written {
        // The reader closed the pipe after the first lines: `dreams walk ... | head`.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        written => written.map_err(|source| Fatal::new(Exit::Unreadable, AnswerError(source))),
    }
}

#[cfg(test)]
mod tests {
    use super::path;
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    use std::path::Path;

    #[test]
    fn no_name_of_a_file_can_steer_a_terminal() {
        let shown = |bytes: &[u8]| path(Path::new(OsStr::from_bytes(bytes)));
        assert_eq!(shown("flock/Schäfchen 1.avi".as_bytes()), "flock/Schäfchen 1.avi");
        assert_eq!(shown(b"a\x1b[2J\n\xe4b\\"), "a\\u{1b}[2J\\u{a}\\xe4b\\\\");
        assert_eq!(shown("\u{9b}31m\u{202e}iva.\u{2028}".as_bytes()), "\\u{9b}31m\\u{202e}iva.\\u{2028}");
    }
}

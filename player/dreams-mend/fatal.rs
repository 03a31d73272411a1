//! How a look ends: its answer on standard output, or its error on standard error.
//!
//! Owns [`Fatal`], the answer, and the notice.

use diagnostics::{Exit, chain, print_error};
use player::{Notice, Output};
use serde::Serialize;
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use tracing::warn;

/// What was found damaged, and what became of it.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Answer {
    /// Files and slots that were damaged, and are whole again.
    pub(crate) mended: Vec<String>,
    /// Files and slots that are damaged, and for which there is no copy that is whole.
    pub(crate) lost: Vec<String>,
}

impl fmt::Display for Answer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mended = self.mended.iter().map(|what| format!("mended  {what}"));
        let lines: Vec<_> = mended.chain(self.lost.iter().map(|what| format!("lost    {what}"))).collect();
        f.write_str(&if lines.is_empty() { "all is whole".to_owned() } else { lines.join("\n") })
    }
}

/// Why the look was not ended. What was whole before is whole.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Fatal {
    #[error("cannot {doing} `{path}`", path = path.display())]
    Disk { doing: &'static str, path: PathBuf, source: io::Error },
    #[error("cannot write the answer to standard output")]
    Unwritten(#[source] io::Error),
}

/// The error of trying `doing` on `path`.
pub(crate) fn at(doing: &'static str, path: &Path) -> impl FnOnce(io::Error) -> Fatal {
    let path = path.to_owned();
    move |source| Fatal::Disk { doing, path, source }
}

/// Tells people in front of the picture, through the file `path`, if something was damaged.
pub(crate) fn tell_people(answer: &Answer, path: Option<&Path>) {
    let text = if !answer.lost.is_empty() {
        "Part of this frame's own system is damaged. It goes on with the rest; its disk may be failing."
    } else if !answer.mended.is_empty() {
        "Part of this frame's own system was damaged, and is mended. Its disk may be failing."
    } else {
        return;
    };
    let notice = Notice { text: text.to_owned(), thousandths: None };
    if let Some(path) = path
        && let Err(error) = notice.tell(path)
    {
        warn!(error = chain(&error), "cannot write the notice");
    }
}

/// Ends the program: with the answer, or with the error and what to do about it.
pub(crate) fn finish(result: Result<Output<Answer>, Fatal>) -> ExitCode {
    let printed = result.and_then(|output| output.print().map_err(Fatal::Unwritten).map(|()| output));
    let exit = match printed {
        Ok(output) if output.answer.lost.is_empty() => Exit::Fine,
        Ok(_) => Exit::No,
        Err(fatal) => {
            print_error(&fatal, Some("the disk may be failing; the system that runs goes on"));
            Exit::Unreadable
        }
    };
    ExitCode::from(exit)
}

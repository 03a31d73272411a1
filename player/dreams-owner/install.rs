//! Brings settings that have arrived to the owner's partition.
//!
//! Owns the order: the file that is there stays as `dreams-before.toml`, the new one takes its name as a whole, the number
//! is raised, and nothing waits any more. A power cut between two of these leaves the settings waiting, and the next run
//! does the rest. Never reads a stick: `from_stick.rs` does. `take_in.rs` applies what is on the partition.
//!
//! Start at [`run`].

use crate::inbox::{Arrived, Inbox};
use crate::sentences;
use crate::take_in::{is_there, show};
use clap::Args;
use diagnostics::{Exit, print_error};
use settings::owner::FILE_NAME;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// What the file is called that was there before.
const BEFORE: &str = "dreams-before.toml";

/// Make the settings that have arrived the owner's file
#[derive(Debug, Args)]
#[command(after_help = super::EXIT_STATUS)]
pub(crate) struct Options {
    /// The folder of the owner's partition
    folder: PathBuf,
    /// The folder in which settings wait for it
    #[arg(long, value_name = "FOLDER")]
    inbox: PathBuf,
    /// Where notices are written
    #[arg(long, value_name = "FILE")]
    notice: PathBuf,
}

/// Why the settings were not brought there.
#[derive(Debug, thiserror::Error)]
enum Fatal {
    #[error("cannot read or write the settings that wait in `{path}`", path = path.display())]
    Inbox { path: PathBuf, source: io::Error },
    #[error("cannot write the settings to the owner's partition `{path}`", path = path.display())]
    Partition { path: PathBuf, source: io::Error },
}

/// Brings them there, and writes a notice about it.
pub(crate) fn run(options: &Options) -> Exit {
    let installed = install(options);
    match &installed {
        Ok(false) => {}
        Ok(true) => show(&options.notice, sentences::IN_USE),
        Err(Fatal::Inbox { .. }) => show(&options.notice, sentences::NO_MEMORY),
        Err(Fatal::Partition { .. }) => show(&options.notice, sentences::NO_PARTITION),
    }
    installed.map_or_else(
        |fatal| {
            print_error(&fatal, Some("the settings before stay; plug in the stick again to try it once more"));
            Exit::Unreadable
        },
        |_| Exit::Fine,
    )
}

/// Whether there were any that could be brought there.
fn install(options: &Options) -> Result<bool, Fatal> {
    let failed = |source| Fatal::Inbox { path: options.inbox.clone(), source };
    let mut inbox = Inbox::open(&options.inbox).map_err(failed)?;
    let arrived = inbox.arrived().map_err(failed)?;
    let Some(Arrived { text, .. }) = &arrived else {
        inbox.clear().map_err(failed)?;
        return Ok(false);
    };
    let written = write(&options.folder, text);
    let accepted = if written.is_ok() { arrived.iter().try_for_each(|arrived| inbox.accept(arrived)) } else { Ok(()) };
    // Also what the partition does not take waits no longer: the stick still has it.
    inbox.clear().map_err(failed)?;
    written.map_err(|source| Fatal::Partition { path: options.folder.clone(), source })?;
    accepted.map_err(failed)?;
    Ok(true)
}

/// Has the owner's file in `folder` hold `text`; the one that was there gets another name. A file that holds it already
/// stays, and so does the one before it.
fn write(folder: &Path, text: &str) -> io::Result<()> {
    let path = folder.join(FILE_NAME);
    if is_there(&path, text) {
        return Ok(());
    }
    match durable::open_plain(&path) {
        Err(error) if error.kind() == ErrorKind::NotFound => {}
        found => {
            drop(found?);
            durable::copy(&path, &folder.join(BEFORE))?;
        }
    }
    durable::write(&path, text.as_bytes())
}

//! `dreams unlink`: removes a transition.
//!
//! Owns the command. Deletes clips only with --delete-files.

use std::path::PathBuf;

use flock::SheepId;

use super::EditSession;
use crate::program::{Exit, Fatal};

/// Take a transition out of a flock
///
/// Refused if a sheep that is shown would then no longer be. The clip stays where it is, unless --delete-files is
/// given. In the manifest, the lines of the transition are removed; the comments around them stay.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  the transition is gone
  1  it would break the flock; nothing was changed
  2  the command line or the manifest is wrong
  3  a file could not be read or written")]
pub(crate) struct Args {
    /// Folder of the flock
    dir: PathBuf,
    /// The sheep where it starts
    #[arg(value_parser = SheepId::new)]
    from: SheepId,
    /// The sheep where it ends
    #[arg(value_parser = SheepId::new)]
    to: SheepId,
    /// Delete its clip too, unless something else names it
    #[arg(long)]
    delete_files: bool,
    /// Do it even if that breaks the flock
    #[arg(long)]
    force: bool,
    /// Answer with one JSON document
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Fatal> {
    let Args { from, to, .. } = args;
    let mut session = EditSession::start(&args.dir)?;
    session.edit(|edit| edit.drop_transition(from, to))?;
    session.refuse_breaking(&format!("without the transition from `{from}` to `{to}`"), args.force, args.json)?;
    let result = session.save()?;
    if args.delete_files {
        result.delete_files()?;
    }
    result.print(&format!("unlinked `{from}` from `{to}`"), args.json)
}

//! `dreams drop`: removes a sheep.
//!
//! Owns the command. Deletes clips only with --delete-files.

use std::path::PathBuf;

use flock::SheepId;

use super::EditSession;
use crate::program::{Exit, Fatal, print};

/// Take a sheep out of a flock, with every transition from and to it
///
/// Refused if another sheep that is shown would then no longer be. The files stay where they are, unless --delete-files
/// is given. In the manifest, the lines of the sheep and of its transitions are removed; the comments around them stay.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  the sheep is gone
  1  it would break the flock; nothing was changed
  2  the command line or the manifest is wrong
  3  a file could not be read or written")]
pub(crate) struct Args {
    /// Folder of the flock
    dir: PathBuf,
    /// The sheep
    #[arg(value_parser = SheepId::new)]
    id: SheepId,
    /// Delete its genome and clips too, unless something else names them
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
    let id = &args.id;
    let mut session = EditSession::start(&args.dir)?;
    let transitions = session.manifest().transitions.len();
    session.edit(|edit| edit.drop_sheep(id))?;
    let gone = match transitions - session.manifest().transitions.len() {
        0 => String::new(),
        count => format!(" and {}", print::count(count, "transition")),
    };
    session.refuse_breaking(&format!("without sheep `{id}`"), args.force, args.json)?;
    let result = session.save()?;
    if args.delete_files {
        result.delete_files()?;
    }
    result.print(&format!("dropped `{id}`{gone}"), args.json)
}

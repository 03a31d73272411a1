//! `flock drop`: one sheep fewer.
//!
//! Owns the command. Never deletes a clip unless told to.

use std::path::PathBuf;

use flock::SheepId;

use super::Desk;
use crate::program::{Exit, Fatal, print};

/// Take a sheep out of a flock, with every transition from and to it
///
/// Refused if another sheep that is shown would then no longer be. The files stay where they are, unless
/// --delete-files is given. In the manifest, the lines of the sheep and its transitions go and the comments around
/// them stay.
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
    let mut desk = Desk::at(&args.dir)?;
    let transitions = desk.manifest().transitions.len();
    desk.edit(|edit| edit.drop_sheep(id))?;
    let gone = match transitions - desk.manifest().transitions.len() {
        0 => String::new(),
        count => format!(" and {}", print::count(count, "transition")),
    };
    desk.refuse_breaking(&format!("without sheep `{id}`"), args.force, args.json)?;
    let effect = desk.save()?;
    if args.delete_files {
        effect.delete_files()?;
    }
    effect.tell(&format!("dropped `{id}`{gone}"), args.json)
}

//! `dreams drop`: removes sheep.
//!
//! Owns the command. Deletes clips only with --delete-files.

use std::path::PathBuf;

use operations::program::{Exit, Fatal, print};

use super::EditSession;
use super::selection::{Chosen, FORM, Selector};
use crate::completer;

/// Take sheep out of a flock, with every transition from and to them
///
/// Refused if another sheep that is shown would then no longer be. The files stay where they are, unless --delete-files
/// is given. In the manifest and in the credits, the lines of the sheep and of their transitions are removed; the comments
/// around them stay.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  the sheep are gone
  1  it would break the flock; nothing was changed
  2  the command line or the manifest is wrong
  3  a file could not be read or written")]
pub struct Args {
    /// Folder of the flock
    dir: PathBuf,
    #[arg(value_name = "ID", required = true, help = format!("The sheep: {FORM}"))]
    #[arg(value_parser = Selector::parse, add = completer::completer())]
    ids: Vec<Selector>,
    /// Delete their genomes and clips too, unless something else names them
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
pub fn run(args: &Args) -> Result<Exit, Fatal> {
    let mut session = EditSession::start(&args.dir)?;
    let chosen = Chosen::of(&args.ids, session.manifest())?;
    let transitions = session.manifest().transitions.len();
    session.edit(|edit| edit.drop_all(&chosen.sheep))?;
    let gone = match transitions - session.manifest().transitions.len() {
        0 => String::new(),
        count => format!(" and {}", print::count(count, "transition")),
    };
    session.refuse_breaking(&format!("without {}", chosen.told()), args.force, args.json)?;
    let result = session.save()?;
    if args.delete_files {
        result.delete_files()?;
    }
    let dropped = chosen.told().replacen("sheep `", "`", 1);
    result.print(&format!("dropped {dropped}{gone}"), args.json)
}

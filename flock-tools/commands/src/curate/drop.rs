//! `dreams drop`: removes sheep.
//!
//! Owns the command. Deletes clips only with --delete-files.

use std::path::PathBuf;

use operations::program::{Exit, Fatal, print};

use super::selection::{Chosen, FORM, Selector};
use super::{EditSession, RemovalArgs};
use crate::ids;

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
    #[arg(value_parser = Selector::parse, add = ids::completer())]
    ids: Vec<Selector>,
    #[command(flatten)]
    removal: RemovalArgs,
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
    let dropped = chosen.told().replacen("sheep `", "`", 1);
    session.remove(format!("without {}", chosen.told()), &format!("dropped {dropped}{gone}"), &args.removal)
}

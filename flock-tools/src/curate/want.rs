//! `dreams want`: sets how often a sheep is wished.
//!
//! Owns the command. The shares do not change: `dreams balance` brings them to the wants.

use std::path::PathBuf;

use flock::SheepId;

use super::EditSession;
use crate::program::{Exit, Fatal, arguments};

/// Set how often a sheep is wished, relative to the others
///
/// The weights do not change: `dreams balance` finds those that reach the wants. Only the manifest is read and written,
/// and in it only this number.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  the want is set
  1  does not occur
  2  the command line or the manifest is wrong
  3  a file could not be read or written")]
pub(crate) struct Args {
    /// Folder of the flock
    dir: PathBuf,
    /// The sheep
    #[arg(value_parser = SheepId::new)]
    id: SheepId,
    /// Its wished share relative to the others': 2 is twice as often as 1
    #[arg(allow_negative_numbers = true, value_parser = arguments::positive)]
    want: f64,
    /// Answer with one JSON document
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Fatal> {
    let mut session = EditSession::start(&args.dir)?;
    let before = session.manifest().sheep.iter().find(|sheep| sheep.id == args.id).map_or(1.0, |sheep| sheep.want);
    session.edit(|edit| edit.set_want(&args.id, args.want))?;
    session.save()?.print(&format!("`{}` has want {}, was {before}", args.id, args.want), args.json)
}

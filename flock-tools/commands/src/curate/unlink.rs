//! `dreams unlink`: removes transitions.
//!
//! Owns the command. Deletes clips only with --delete-files.

use std::path::PathBuf;

use operations::program::{Exit, Fatal, print};

use super::selection::{Chosen, FORM, Pairs, Selector};
use super::{EditSession, RemovalArgs};
use crate::ids;

/// Take transitions out of a flock
///
/// Of globs, the pairs that have a transition are meant. Refused if a sheep that is shown would then no longer be. The
/// clips stay where they are, unless --delete-files is given. In the manifest, the lines of the transitions are removed;
/// the comments around them stay.
#[derive(Debug, clap::Args)]
#[command(mut_arg("delete_files", |arg| arg.help("Delete their clips too, unless something else names them")))]
#[command(after_help = "Exit status:
  0  the transitions are gone
  1  it would break the flock; nothing was changed
  2  the command line or the manifest is wrong
  3  a file could not be read or written")]
pub struct Args {
    /// Folder of the flock
    dir: PathBuf,
    #[arg(help = format!("The sheep where they start: {FORM}"), value_parser = Selector::parse, add = ids::completer())]
    from: Selector,
    #[arg(required = true, help = "The sheep where they end, in the same form")]
    #[arg(value_parser = Selector::parse, add = ids::completer())]
    to: Vec<Selector>,
    #[command(flatten)]
    removal: RemovalArgs,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<Exit, Fatal> {
    let mut session = EditSession::start(&args.dir)?;
    let from = Chosen::of([&args.from], session.manifest())?;
    let to = Chosen::of(&args.to, session.manifest())?;
    let chosen = Pairs::linked(&from, &to, session.manifest())?;
    session.edit(|edit| edit.drop_transitions(&chosen.pairs))?;
    let count = print::count(chosen.pairs.len(), "transition");
    let (edit, done) = match chosen.single() {
        Some((from, to)) => {
            (format!("without the transition from `{from}` to `{to}`"), format!("unlinked `{from}` from `{to}`"))
        }
        None => (format!("without these {count}"), format!("took out {count}")),
    };
    session.remove(edit, &done, &args.removal)
}

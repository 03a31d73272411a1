//! `dreams weight`: sets how readily the walk takes transitions.
//!
//! Owns the command. `dreams balance --write` sets all weights at once.

use std::path::PathBuf;

use operations::program::{Exit, Fatal, print};

use super::EditSession;
use super::selection::{Chosen, FORM, Pairs, Selector};
use crate::arguments;
use crate::ids;

/// Set how readily the walk takes transitions, relative to the others from the same sheep
///
/// Of globs, the pairs that have a transition are meant. Only the manifest is read and written, and in it only these
/// numbers. `dreams balance` finds the weights that give every sheep what is wanted of it.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  the weights are set
  1  does not occur
  2  the command line or the manifest is wrong
  3  a file could not be read or written")]
pub struct Args {
    /// Folder of the flock
    dir: PathBuf,
    #[arg(help = format!("The sheep where they start: {FORM}"), value_parser = Selector::parse, add = ids::completer())]
    from: Selector,
    #[arg(help = format!("The sheep where they end: {FORM}"), value_parser = Selector::parse, add = ids::completer())]
    to: Selector,
    /// The weight: 2 is taken twice as often as 1
    #[arg(allow_negative_numbers = true, value_parser = arguments::positive)]
    weight: f64,
    /// Answer with one JSON document
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<Exit, Fatal> {
    let mut session = EditSession::start(&args.dir)?;
    let (manifest, weight) = (session.manifest(), args.weight);
    let from = Chosen::of([&args.from], manifest)?;
    let to = Chosen::of([&args.to], manifest)?;
    let chosen = Pairs::linked(&from, &to, manifest)?;
    let done = match chosen.single() {
        Some((from, to)) => {
            let own = manifest.transitions.iter().find(|t| t.from == *from && t.to == *to);
            let before = own.map_or(1.0, |own| own.weight);
            format!("`{from}` to `{to}` has weight {weight}, was {before}")
        }
        None => format!("{} have weight {weight}", print::count(chosen.pairs.len(), "transition")),
    };
    session.edit(|edit| chosen.pairs.iter().try_for_each(|(from, to)| edit.set_weight(from, to, weight)))?;
    session.save()?.print(&done, args.json)
}

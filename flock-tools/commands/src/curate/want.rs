//! `dreams want`: sets how often sheep are wished.
//!
//! Owns the command. The shares do not change: `dreams balance` brings them to the wants.

use operations::program::{Exit, Fatal};

use super::EditSession;
use super::selection::{Chosen, FORM, NumberArgs};
use crate::arguments;

/// Set how often sheep are wished, relative to the others
///
/// The weights do not change: `dreams balance` finds those that reach the wants. Only the manifest is read and written,
/// and in it only these numbers.
#[derive(Debug, clap::Args)]
#[command(override_usage = "dreams want [OPTIONS] <DIR> <ID>... <WANT>")]
#[command(mut_arg("words", |words| words.help(format!(
    "The sheep: {FORM}. The last word is their wished share relative to the others': 2 is twice as often as 1"
))))]
#[command(after_help = "Exit status:
  0  the wants are set
  1  does not occur
  2  the command line or the manifest is wrong
  3  a file could not be read or written")]
pub struct Args {
    #[command(flatten)]
    number: NumberArgs,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<Exit, Fatal> {
    let mut session = EditSession::start(&args.number.dir)?;
    let (words, want) = args.number.read("want", arguments::positive)?;
    let chosen = Chosen::of(&words, session.manifest())?;
    let done = session.told(&chosen, &format!("want {want}"), |sheep| sheep.want.to_string());
    session.edit(|edit| chosen.sheep.iter().try_for_each(|id| edit.set_want(id, want)))?;
    session.save()?.print(&done, args.number.json)
}

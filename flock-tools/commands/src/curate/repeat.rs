//! `dreams repeat`: sets how often the loops of sheep are shown at each visit.
//!
//! Owns the command. The walk does not change: only the time that it takes.

use flock::MAX_REPEATS;
use operations::program::{Exit, Fatal};

use super::EditSession;
use super::selection::{Chosen, FORM, NumberArgs};

/// Set how often the loop of sheep is shown at each visit
///
/// The walk does not change, but it stays longer or shorter with these sheep. `dreams balance --by time` brings the
/// time on screen to the wants. Only the manifest is read and written, and in it only these numbers.
#[derive(Debug, clap::Args)]
#[command(override_usage = "dreams repeat [OPTIONS] <DIR> <ID>... <N>")]
#[command(mut_arg("words", |words| words.help(format!("The sheep: {FORM}. The last word is the number of loops per visit"))))]
#[command(after_help = "Exit status:
  0  the repeats are set
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
    let (words, repeat) = args.number.read("number of loops", loops)?;
    let chosen = Chosen::of(&words, session.manifest())?;
    let done = session.told(&chosen, &format!("repeat {repeat}"), |sheep| sheep.repeat.to_string());
    session.edit(|edit| chosen.sheep.iter().try_for_each(|id| edit.set_repeat(id, repeat)))?;
    session.save()?.print(&done, args.number.json)
}

fn loops(text: &str) -> Result<u32, String> {
    let loops = text.parse().ok().filter(|loops| (1..=MAX_REPEATS).contains(loops));
    loops.ok_or_else(|| format!("wanted a whole number from 1 to {MAX_REPEATS}"))
}

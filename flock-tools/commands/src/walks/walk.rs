//! `dreams walk`: prints the clips that a unit will play.
//!
//! Owns the command. The itinerary is the player's own.

use flock::{ClipKind, Itinerary};
use operations::flock_folder::open;
use operations::program::{Exit, Fatal, print};

use crate::arguments::WalkArgs;

/// Print the clips that a unit with this seed plays, one a line
///
/// Without a seed it is a fresh walk, as a unit takes one at its first start; its seed is told on stderr. The first sheep's loops come first, then for each step its transition and the loops of the sheep that it leads to.
/// Only the manifest is read.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  the walk is printed
  1  the flock has no cycle of transitions to walk
  2  the command line or the manifest is wrong
  3  a file could not be read or written")]
pub struct Args {
    #[command(flatten)]
    walk: WalkArgs,
    /// Answer with one JSON document: {"seed": N, "clips": [...]}
    #[arg(long)]
    json: bool,
}

#[derive(serde::Serialize)]
struct Answer {
    seed: u64,
    clips: Vec<String>,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<Exit, Fatal> {
    let WalkArgs { dir, steps, .. } = &args.walk;
    let flock = open::walkable(dir)?;
    let seed = args.walk.seed(args.json);
    let clips = clips(Itinerary::start(flock, seed), *steps);
    if args.json {
        print::json(&Answer { seed, clips: clips.collect() })?;
    } else {
        print::lines(clips)?;
    }
    Ok(Exit::Fine)
}

/// The clips of the first visit and of `steps` steps, each with the loops of the visit it leads to.
fn clips(mut path: Itinerary, steps: usize) -> impl Iterator<Item = String> {
    let mut left = steps;
    std::iter::from_fn(move || {
        let clip = path.next_clip()?;
        if matches!(clip.what, ClipKind::Transition { .. }) {
            left = left.checked_sub(1)?;
        }
        Some(clip.path.to_string())
    })
}

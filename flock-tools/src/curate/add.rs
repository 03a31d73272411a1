//! `flock add`: one sheep more.
//!
//! Owns the command. The loop may be there already, or be rendered later from the genome.

use std::path::PathBuf;

use clap::ArgGroup;
use flock::{MAX_FRAMES, MAX_REPEATS, Sheep, SheepId};

use super::Desk;
use super::files::{self, Incoming};
use crate::arguments;
use crate::decoder::Video;
use crate::places;
use crate::report::{self, Exit, Fatal};

/// Frames of a loop that is yet to be rendered, unless told otherwise: 26 seconds at 30 per second.
pub(crate) const FRAMES: u32 = 768;

/// Add a sheep: from a genome, a loop or both
///
/// Files from elsewhere are copied into the flock's folder. A loop must be in the flock's form, and its hash is written
/// down; without one its place is named, and `flock render` makes it from the genome. The sheep is shown once
/// transitions lead to it and away from it: `flock link` adds them.
#[derive(Debug, clap::Args)]
#[command(group = ArgGroup::new("what").args(["genome", "clip", "no_loop"]).required(true).multiple(true))]
#[command(after_help = "Exit status:
  0  the sheep is in the flock
  1  the loop is not in the flock's form, or another file is in its place; nothing was changed
  2  the command line, the manifest or the genome is wrong
  3  a file could not be read or written")]
pub(crate) struct Args {
    /// Folder of the flock
    dir: PathBuf,
    /// What the sheep is called in the flock: 1 to 64 of A-Z a-z 0-9 . _ -
    #[arg(value_parser = SheepId::new)]
    id: SheepId,
    /// Its genome: flam3 XML with one flame
    #[arg(long, value_name = "FILE")]
    genome: Option<PathBuf>,
    /// Its loop, in the flock's form
    #[arg(id = "clip", long = "loop", value_name = "FILE")]
    clip: Option<PathBuf>,
    /// It has no loop: a keyframe that is only passed through
    #[arg(long, conflicts_with_all = ["clip", "frames", "repeat"])]
    no_loop: bool,
    #[arg(long, value_name = "N", conflicts_with = "clip")]
    #[arg(help = format!("Frames of a loop that is yet to be rendered [default: {FRAMES}]"))]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_FRAMES)))]
    frames: Option<u32>,
    /// Its wished share relative to the others'
    #[arg(long, value_name = "W", default_value_t = 1.0, allow_negative_numbers = true, value_parser = arguments::positive)]
    want: f64,
    /// Loops per visit
    #[arg(long, value_name = "N", default_value_t = 1)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_REPEATS)))]
    repeat: u32,
    /// Replace other files that are in the places of the genome and the loop
    #[arg(long)]
    force: bool,
    /// Answer with one JSON document
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub(crate) fn run(args: &Args, video: Video) -> Result<Exit, Fatal> {
    let id = &args.id;
    let mut desk = Desk::at(&args.dir)?;
    let genome = args.genome.as_deref().map(|file| files::genome(&desk, file, id)).transpose()?;
    let place = |ending: &str| places::of_loop(id, ending);
    let wish = files::Wish { file: args.clip.as_deref(), frames: args.frames, or: FRAMES };
    let clip = (!args.no_loop).then(|| files::clip(&desk, &wish, place, video)).transpose()?;
    let mut parts = Vec::new();
    parts.extend(clip.iter().map(|(clip, _)| format!("loop `{}`, {} frames", clip.path, clip.frames)));
    parts.extend(genome.iter().map(|genome| format!("genome `{}`", genome.path)));
    let sheep = Sheep {
        id: id.clone(),
        clip: clip.as_ref().map(|(clip, _)| clip.clone()),
        genome: genome.as_ref().map(|genome| genome.path.clone()),
        want: args.want,
        repeat: args.repeat,
    };
    desk.edit(|edit| edit.add_sheep(sheep))?;
    let note = genome.as_ref().and_then(|genome| genome.note.clone());
    let incoming = genome.and_then(|genome| genome.incoming).into_iter().chain(clip.and_then(|(_, incoming)| incoming));
    Incoming::bring_all(incoming, &args.dir, args.force)?;
    let effect = desk.save()?;
    if let Some(note) = note {
        report::note(&note);
    }
    let what = if parts.is_empty() { "without a loop".to_owned() } else { parts.join(", ") };
    effect.tell(&format!("added `{id}`: {what}"), args.json)
}

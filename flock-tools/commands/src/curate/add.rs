//! `dreams add`: adds a sheep.
//!
//! Owns the command. The loop may be there already, or `dreams render` makes it later from the genome.

use std::path::PathBuf;

use clap::ArgGroup;
use flame::genome::{Reasons, Unsupported};
use flock::{MAX_FRAMES, MAX_REPEATS, Sheep, SheepId};
use operations::decoder::DecoderHandle;
use operations::flock_folder::paths;
use operations::program::reasons::serialize;
use operations::program::{Exit, Fatal, print};

use super::files::{self, FileCopy};
use super::{Answer, EditSession};
use crate::arguments;

/// Frames of a loop that is yet to be rendered, by default.
pub(crate) const FRAMES: u32 = flock::paths::LOOP_FRAMES;

/// Add a sheep: from a genome, a loop or both
///
/// Files from elsewhere are copied into the flock's folder. A loop must be in the flock's form; its hash is written
/// into the manifest. Without a loop the manifest names its path, and `dreams render` makes it from the genome. The
/// sheep is shown once transitions lead to it and away from it: `dreams link` adds them.
#[derive(Debug, clap::Args)]
#[command(group = ArgGroup::new("what").args(["genome", "clip", "no_loop"]).required(true).multiple(true))]
#[command(after_help = "Exit status:
  0  the sheep is in the flock
  1  the loop is not in the flock's form, or another file is in its place; nothing was changed
  2  the command line, the manifest or the genome is wrong
  3  a file could not be read or written")]
pub struct Args {
    /// Folder of the flock
    dir: PathBuf,
    /// The id of the sheep in the flock: 1 to 64 of A-Z a-z 0-9 . _ -
    #[arg(value_parser = SheepId::new)]
    id: SheepId,
    /// Its genome: a file of one flame (.flam3), expression (.expr), globe of agents (.agents) or plant (.plant)
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

/// The answer with `--json`.
#[derive(serde::Serialize)]
struct AddAnswer<'a> {
    #[serde(flatten)]
    edit: Answer<'a>,
    /// For this the genome cannot be drawn.
    #[serde(skip_serializing_if = "Reasons::is_empty", serialize_with = "serialize")]
    reasons: Reasons,
    /// It is drawn without this.
    #[serde(skip_serializing_if = "Reasons::is_empty", serialize_with = "serialize")]
    without: Reasons,
}

/// Runs the command.
pub fn run(args: &Args, decoder: DecoderHandle) -> Result<Exit, Fatal> {
    let id = &args.id;
    let mut session = EditSession::start(&args.dir)?;
    let genome = args.genome.as_deref().map(|file| files::genome(&session, file, id)).transpose()?;
    let place = |ending: &str| paths::of_loop(id, ending);
    let request = files::ClipRequest { file: args.clip.as_deref(), frames: args.frames, default_frames: FRAMES };
    let clip = (!args.no_loop).then(|| files::clip(&session, &request, place, decoder)).transpose()?;
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
    session.edit(|edit| edit.add_sheep(sheep))?;
    let noted = genome.as_ref().map(|genome| (genome.notes.clone(), genome.undrawn.clone()));
    let (notes, Unsupported { refused, without }) = noted.unwrap_or_default();
    let copy = genome.and_then(|genome| genome.copy).into_iter().chain(clip.and_then(|(_, copy)| copy));
    FileCopy::run_all(copy, &mut session, args.force)?;
    let result = session.save()?;
    for note in &notes {
        print::note(note);
    }
    let what = if parts.is_empty() { "without a loop".to_owned() } else { parts.join(", ") };
    if args.json {
        print::json(&AddAnswer { edit: result.answer(), reasons: refused, without })?;
        return Ok(Exit::Fine);
    }
    result.print(&format!("added `{id}`: {what}"), false)
}

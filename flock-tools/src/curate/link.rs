//! `dreams link`: adds a transition.
//!
//! Owns the command. The clip may be there already, or `dreams render` makes it later.

use std::path::PathBuf;

use flock::{MAX_FRAMES, SheepId, Transition};

use super::EditSession;
use super::files::{self, FileCopy};
use crate::decoder::DecoderHandle;
use crate::flock_folder::paths;
use crate::program::{Exit, Fatal, arguments};

/// Frames of a transition that is yet to be rendered, by default: 13 seconds at 30 per second.
const FRAMES: u32 = 384;

/// Add a transition from one sheep to another
///
/// With --clip, the clip is copied into the flock's folder if it is in the flock's form, and its hash is written into
/// the manifest. Without, the manifest names its path, and `dreams render` makes it from both genomes.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  the transition is in the flock
  1  the clip is not in the flock's form, or another file is in its place; nothing was changed
  2  the command line or the manifest is wrong
  3  a file could not be read or written")]
pub(crate) struct Args {
    /// Folder of the flock
    dir: PathBuf,
    /// The sheep where it starts
    #[arg(value_parser = SheepId::new)]
    from: SheepId,
    /// The sheep where it ends; the same one is allowed
    #[arg(value_parser = SheepId::new)]
    to: SheepId,
    /// Its clip, in the flock's form
    #[arg(long, value_name = "FILE")]
    clip: Option<PathBuf>,
    #[arg(long, value_name = "N", conflicts_with = "clip")]
    #[arg(help = format!("Frames of a clip that is yet to be rendered [default: {FRAMES}]"))]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_FRAMES)))]
    frames: Option<u32>,
    /// How readily the walk takes it, relative to the others from the same sheep
    #[arg(long, value_name = "W", default_value_t = 1.0, allow_negative_numbers = true, value_parser = arguments::positive)]
    weight: f64,
    /// Replace another file that is in the clip's place
    #[arg(long)]
    force: bool,
    /// Answer with one JSON document
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub(crate) fn run(args: &Args, decoder: DecoderHandle) -> Result<Exit, Fatal> {
    let (from, to) = (args.from.clone(), args.to.clone());
    let mut session = EditSession::start(&args.dir)?;
    let place = |ending: &str| paths::of_transition(&from, &to, ending);
    let request = files::ClipRequest { file: args.clip.as_deref(), frames: args.frames, default_frames: FRAMES };
    let (clip, copy) = files::clip(&session, &request, place, decoder)?;
    let (frames, path) = (clip.frames, clip.path.clone());
    let transition = Transition { from: args.from.clone(), to: args.to.clone(), clip, weight: args.weight };
    session.edit(|edit| edit.add_transition(transition))?;
    FileCopy::run_all(copy.into_iter(), &args.dir, args.force)?;
    session.save()?.print(&format!("linked `{from}` to `{to}`: `{path}`, {frames} frames"), args.json)
}

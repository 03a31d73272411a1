//! `dreams render DIR [SHEEP...]`: renders the clips that a flock lacks.
//!
//! Owns the command: its options, its answer and how it ends. `selection.rs` finds the missing clips, `plan.rs` plans each,
//! `make.rs` renders them, `hashes.rs` writes their hashes into the manifest. `palettes.rs` finds the
//! colours that genomes only name. `still.rs` is `dreams still`.
//!
//! Start at [`run`].

mod clip_job;
pub(crate) mod estimate;
mod frames;
mod hashes;
pub(crate) mod make;
pub(crate) mod options;
pub(crate) mod palettes;
pub(crate) mod plan;
pub(crate) mod selection;
pub(crate) mod still;
#[cfg(test)]
mod tests;

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::sync::atomic::Ordering;

use flock::{ClipHash, ClipPath, SheepId};
use video::{Form, Quality};

use crate::flock_folder::{ids, open};
use crate::program::{Exit, Fatal, now::Stopwatch, print};
use make::{MakeError, Outcome, RunOptions, RunResult};
use plan::{ClipPlan, Look, PRESET, SEED};
use selection::{Request, Selection, SkippedClip};

/// Render the clips that a flock lacks, from its genomes
///
/// These are every loop of a sheep with a genome, and every transition between two of them, whose clip is not there.
/// Size, rate and frames are the flock's, everything else the genome's unless an option is given. If it is interrupted,
/// the same command continues. On several machines that share the folder, each renders clips that no other has begun.
/// The hashes of finished clips are written into the manifest.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  nothing is missing any more
  1  a clip is still missing: it has no genome, another process renders it, or the run was interrupted
  2  the command line, the manifest or a genome is wrong
  3  a file could not be read or written, or a clip could not be made")]
#[expect(clippy::struct_excessive_bools, reason = "independent switches")]
pub(crate) struct Args {
    /// Folder of the flock
    dir: PathBuf,
    /// Only the loops of these sheep and the transitions at them
    #[arg(value_parser = |text: &str| SheepId::new(text), add = ids::completer())]
    sheep: Vec<SheepId>,
    /// Also clips that are there, except those that were rendered from the same recipe
    #[arg(long)]
    again: bool,
    /// Only print what would be rendered and its cost, measured on a few frames
    #[arg(long)]
    dry_run: bool,
    /// Samples per pixel
    #[arg(long, value_name = "N", value_parser = options::samples)]
    spp: Option<f64>,
    /// Histogram cells per pixel in each direction
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=16))]
    supersample: Option<u32>,
    /// Moments in a frame; 1 switches motion blur off
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    temporal_samples: Option<u32>,
    /// x264's constant rate factor, to 51: smaller is finer and larger
    #[arg(long, value_name = "N", default_value_t = plan::CRF, value_parser = options::rate_factor)]
    crf: f32,
    /// Frames rendered at once, as far as memory goes
    #[arg(long, value_name = "T", default_value_t = options::cores(), value_parser = options::threads)]
    threads: NonZeroUsize,
    /// The seed of the random numbers: the same gives the same clips, with any number of threads
    #[arg(long, value_name = "S", default_value_t = SEED)]
    seed: u64,
    /// Keep the rendered frames, so that another --crf needs no rendering: 1.4 MB each at 1280x720
    #[arg(long)]
    keep_frames: bool,
    /// Answer with one JSON document
    #[arg(long)]
    json: bool,
}

/// A clip in the answer.
#[derive(serde::Serialize)]
struct ClipAnswer<'a> {
    clip: &'a ClipPath,
    frames: u32,
    state: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    hash: Option<String>,
}

/// The answer with `--json`.
#[derive(serde::Serialize)]
struct Answer<'a> {
    clips: Vec<ClipAnswer<'a>>,
    left_out: &'a [SkippedClip],
    frames: u64,
    cpu_s: f64,
    seconds: f64,
}

/// The answer with `--json` and `--dry-run`.
#[derive(serde::Serialize)]
struct DryAnswer<'a> {
    clips: Vec<ClipAnswer<'a>>,
    left_out: &'a [SkippedClip],
    frames: u64,
    cpu_hours: f64,
    hours: f64,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Fatal> {
    let manifest = open::manifest(&args.dir)?;
    let look = args.look(Form { size: manifest.size, fps: manifest.fps });
    let request = Request { sheep: &args.sheep, again: args.again };
    let selection = Selection::new(&args.dir, &manifest, &request, &look)?;
    for SkippedClip { clip, reason } in &selection.left_out {
        print::note(&format!("note: `{clip}` is missing and cannot be rendered: {reason}"));
    }
    let threads = options::frames_at_once(args.threads, selection.bytes)?;
    if threads < args.threads {
        print::note(&format!(
            "note: {threads} frames at once: each takes {} MB of memory",
            selection.bytes / 1_000_000
        ));
    }
    if args.dry_run { args.estimate(&selection, &look, threads) } else { args.make(&selection, &look, threads) }
}

impl Args {
    fn look(&self, form: Form) -> Look {
        let quality = Quality { crf: self.crf, preset: PRESET, max_bits_per_second: None };
        let Self { spp, supersample, temporal_samples, seed, .. } = *self;
        Look { form, spp, supersample, temporal_samples, seed, quality }
    }

    /// Prints what would be rendered.
    fn estimate(&self, selection: &Selection, look: &Look, threads: NonZeroUsize) -> Result<Exit, Fatal> {
        let seconds =
            estimate::cpu_seconds(&selection.clips, look).map_err(|error| Fatal::new(Exit::Malformed, error))?;
        let cpu_hours = seconds / 3600.0;
        let clips: Vec<_> = selection.clips.iter().map(|clip| clip_answer(clip, "missing", None)).collect();
        let (left_out, frames, hours) = (&selection.left_out[..], selection.frames(), cpu_hours / threads.get() as f64);
        if self.json {
            print::json(&DryAnswer { clips, left_out, frames, cpu_hours, hours })?;
        } else {
            let lines = clips.iter().map(|clip| format!("{} {} frames", clip.clip, clip.frames));
            let sum =
                format!("total {frames} frames, {cpu_hours:.3} CPU hours, {hours:.3} hours with {threads} threads");
            print::lines(lines.chain([sum]))?;
        }
        Ok(Exit::Fine)
    }

    fn make(&self, selection: &Selection, look: &Look, threads: NonZeroUsize) -> Result<Exit, Fatal> {
        let watch = Stopwatch::start();
        hashes::write_hashes(&self.dir)?;
        let options = RunOptions { threads, keep_frames: self.keep_frames, stop: options::stop_on_signals()? };
        let finished = |clip: &ClipPlan, _: ClipHash| {
            if !self.json {
                // The run goes on if the reader has closed the pipe.
                let _ = print::lines([format!("{} {} frames", clip.path, clip.frames)]);
            }
            // The artist may be in the middle of an edit. The end of the run writes the hashes again.
            let _ = hashes::write_hashes(&self.dir);
        };
        let made = make::make(&selection.clips, look, &self.dir, &options, &finished).map_err(make_fatal)?;
        hashes::write_hashes(&self.dir)?;
        if options.stop.load(Ordering::Relaxed) {
            print::note("interrupted; the same command continues where this one stopped");
        }
        self.answer(selection, &made, &watch)?;
        let is_there = |outcome: &Outcome| matches!(outcome, Outcome::Made(_) | Outcome::UpToDate(_));
        let complete = selection.left_out.is_empty() && made.outcomes.iter().all(is_there);
        Ok(if complete { Exit::Fine } else { Exit::No })
    }

    fn answer(&self, selection: &Selection, made: &RunResult, watch: &Stopwatch) -> Result<(), Fatal> {
        let of_clip = |(clip, outcome): (_, &Outcome)| match outcome {
            Outcome::Busy => clip_answer(clip, "busy", None),
            Outcome::Made(hash) => clip_answer(clip, "made", Some(hash)),
            Outcome::UpToDate(hash) => clip_answer(clip, "stood", Some(hash)),
            Outcome::Unfinished => clip_answer(clip, "unfinished", None),
        };
        let clips = selection.clips.iter().zip(&made.outcomes).map(of_clip).collect();
        let (cpu_s, seconds) = (watch.cpu().as_secs_f64(), watch.wall().as_secs_f64());
        if self.json {
            return print::json(&Answer { clips, left_out: &selection.left_out, frames: made.frames, cpu_s, seconds });
        }
        let busy = made.outcomes.iter().filter(|outcome| **outcome == Outcome::Busy).count();
        if busy > 0 {
            print::note(&format!("note: another process renders {busy} of the clips"));
        }
        if selection.clips.is_empty() && selection.left_out.is_empty() {
            print::note("nothing is missing");
        }
        Ok(())
    }
}

fn clip_answer<'a>(clip: &'a ClipPlan, state: &'static str, hash: Option<&ClipHash>) -> ClipAnswer<'a> {
    ClipAnswer { clip: &clip.path, frames: clip.frames.0, state, hash: hash.map(ToString::to_string) }
}

/// Ends a command whose clips could not be made.
pub(crate) fn make_fatal(error: MakeError) -> Fatal {
    Fatal::new(Exit::Unreadable, error).hint("the same command continues where this one stopped")
}

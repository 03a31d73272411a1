//! `dreams render DIR [SHEEP...]`: renders the clips that a flock lacks.
//!
//! Owns the command: its options, its answer and how it ends. `operations::render` finds the missing clips and renders them.
//! `look_args.rs` has the options of how they look, `dry_run.rs` what it costs; `slurm` has a cluster render them,
//! `on_gpu.rs` a GPU draw them. `still.rs` is `dreams still`, `still_flame.rs` what only flames have of it.
//!
//! Start at [`run`].

mod dry_run;
mod look_args;
mod on_gpu;
mod slurm;
pub mod still;
mod still_flame;

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::sync::atomic::Ordering;

use flame::Backend;
use flock::{ClipHash, ClipPath, Manifest, SheepId};
use operations::flock_folder::open;
use operations::program::{Exit, Fatal, now::Stopwatch, print};
use operations::render::make::{Outcome, RunOptions, RunResult, make, make_fatal};
use operations::render::plan::{ClipPlan, Look};
use operations::render::presets::Preset;
use operations::render::selection::{Request, Scope, Selection, SkippedClip};
use operations::render::shard::{Part, Shard};
use operations::render::{hashes, machine, shard};
use video::Form;

use crate::{arguments, ids};
use dry_run::DryRun;
use look_args::LookArgs;
use slurm::SlurmArgs;
use slurm::plan_file::PlanFile;

/// Render the clips that a flock lacks, from its genomes
///
/// These are every loop of a sheep with a genome, and every transition between two of them, whose clip is not there, or was
/// rendered from another genome or with other options. Size, rate and frames are the flock's, everything else the genome's
/// unless a preset or an option is given. If it is interrupted, the same command continues: every finished frame is kept. On
/// several machines that share the folder, each renders clips that no other has begun; with --shard, its part of the
/// frames; with --on slurm, a cluster renders them. The hashes of finished clips are written into the manifest.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  nothing is missing any more; with --shard, its part is rendered
  1  a clip is still missing: it has no genome or one that asks for what is not drawn, another process renders it, or the run was interrupted
  2  the command line, the manifest or a genome is wrong, or this program is built without --on gpu
  3  a file could not be read or written, a clip could not be made, there is no GPU or it failed, or the cluster did not
     take the work")]
#[expect(clippy::struct_excessive_bools, reason = "independent switches")]
pub struct Args {
    /// Folder of the flock
    dir: PathBuf,
    /// Only the loops of these sheep and the transitions at them
    #[arg(value_parser = |text: &str| SheepId::new(text), add = ids::completer())]
    sheep: Vec<SheepId>,
    /// Also clips that the tools did not render, except those that were rendered from the same recipe
    #[arg(long)]
    again: bool,
    /// Only clips that are not there, whatever the others were rendered from
    #[arg(long, conflicts_with = "again")]
    missing: bool,
    /// Only print what would be rendered and its cost, measured on a few frames
    #[arg(long)]
    dry_run: bool,
    #[command(flatten)]
    look: LookArgs,
    /// Frames rendered at once, as far as memory goes [default: one for each core; with --on slurm 1 in each task]
    #[arg(long, value_name = "T", value_parser = arguments::threads)]
    threads: Option<NonZeroUsize>,
    /// Where frames are rendered
    #[arg(long, value_name = "WHERE", default_value = "cpu")]
    on: On,
    /// Render the I-th of N parts of the frames and encode nothing; afterwards a plain `dreams render` encodes
    #[arg(long, value_name = "I/N", value_parser = shard::shard, conflicts_with_all = ["on", "keep_frames"])]
    shard: Option<Shard>,
    /// The part is one of this plan, which a run with --on slurm wrote
    #[arg(long, value_name = "FILE", hide = true, requires = "shard")]
    plan: Option<PathBuf>,
    #[command(flatten)]
    slurm: SlurmArgs,
    /// Keep the rendered frames, so that another --crf needs no rendering: 1.4 MB each at 1280x720
    #[arg(long)]
    keep_frames: bool,
    /// Answer with one JSON document
    #[arg(long)]
    json: bool,
}

/// Where frames are rendered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum On {
    /// On this machine
    Cpu,
    /// On this machine, samples on its fastest GPU; only in programs that are built with the feature `gpu`
    Gpu,
    /// On a Slurm cluster that shares the folder
    Slurm,
}

/// Options for a cluster where none renders.
#[derive(Debug, thiserror::Error)]
#[error("--partition, --time, --tasks and --sbatch are for a cluster: they need --on slurm")]
struct WithoutSlurm;

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

/// Runs the command.
pub fn run(args: &Args) -> Result<Exit, Fatal> {
    if args.on != On::Slurm && args.slurm != SlurmArgs::default() {
        return Err(Fatal::new(Exit::Malformed, WithoutSlurm));
    }
    let manifest = open::manifest(&args.dir)?;
    let mut look = args.look.look(Form { size: manifest.size, fps: manifest.fps });
    let (backend, gpu) = if args.on == On::Gpu { on_gpu::open()? } else { (Backend::default(), None) };
    look.gpu = gpu;
    let plan = args.plan.as_deref().map(PlanFile::read).transpose()?;
    let selection = args.select(&manifest, plan.as_ref(), &look, &backend)?;
    let part = match (args.shard, &plan) {
        (None, _) => Part::Whole,
        (Some(shard), None) => Part::Shard(shard),
        (Some(shard), Some(plan)) => plan.part(shard, &selection.clips)?,
    };
    args.tell(&manifest, &selection);
    if args.on == On::Slurm && !args.dry_run {
        return args.send(&selection, &look);
    }
    let wanted = args.threads.unwrap_or_else(machine::cores);
    let threads = machine::frames_at_once(wanted, selection.bytes)?;
    if threads < wanted {
        print::note(&format!(
            "note: {threads} frames at once: each takes {} MB of memory",
            selection.bytes / 1_000_000
        ));
    }
    if args.dry_run {
        let gpu = backend.name().map(str::to_owned);
        DryRun::new(&selection, &look, &args.dir, &part, threads, gpu)?.print(args.json)?;
        return Ok(selection.exit());
    }
    args.make(&selection, &look, threads, part)
}

impl Args {
    /// The clips of this run: of `plan`, if there is one.
    fn select(
        &self,
        manifest: &Manifest,
        plan: Option<&PlanFile>,
        look: &Look,
        backend: &Backend,
    ) -> Result<Selection, Fatal> {
        let listed = self.shard.zip(plan).map(|(shard, plan)| plan.paths(shard));
        let scope = match &listed {
            Some(paths) => Scope::Listed(paths),
            None if self.again => Scope::All,
            None if self.missing => Scope::Missing,
            None => Scope::Changed,
        };
        Selection::new(&self.dir, manifest, &Request { sheep: &self.sheep, scope }, look, backend)
    }

    /// Tells what an artist may not expect.
    fn tell(&self, manifest: &Manifest, selection: &Selection) {
        if let Some(told) = self.look.preset.and_then(|preset| Preset::from(preset).other_form(manifest)) {
            print::note(&told);
        }
        for skipped in &selection.left_out {
            print::note(&format!("note: {}", skipped.in_words()));
        }
        if !selection.changed.is_empty() && !self.again && self.plan.is_none() {
            let clips = print::count(selection.changed.len(), "clip");
            print::note(&format!(
                "note: {clips} were rendered from another genome or with other options, and are rendered again; with \
                 --missing they stay"
            ));
        }
    }

    fn make(&self, selection: &Selection, look: &Look, threads: NonZeroUsize, part: Part) -> Result<Exit, Fatal> {
        let watch = Stopwatch::start();
        let (stop, is_encoded) = (machine::stop_on_signals()?, part.is_encoded());
        let options = RunOptions { threads, keep_frames: self.keep_frames, stop, part, shows_progress: true };
        if is_encoded {
            hashes::write_hashes(&self.dir)?;
        }
        let made = make(&selection.clips, look, &self.dir, &options, &|clip, _| self.finished(clip));
        let made = made.map_err(make_fatal)?;
        if is_encoded {
            hashes::write_hashes(&self.dir)?;
        }
        if options.stop.load(Ordering::Relaxed) {
            print::note("interrupted; the same command continues where this one stopped");
        }
        self.end(selection, &made, &watch)
    }

    /// Has a cluster render the clips.
    fn send(&self, selection: &Selection, look: &Look) -> Result<Exit, Fatal> {
        let watch = Stopwatch::start();
        hashes::write_hashes(&self.dir)?;
        let run = slurm::Run {
            folder: &self.dir,
            selection,
            look,
            words: self.look.words(),
            threads: self.threads.unwrap_or(NonZeroUsize::MIN),
            keep_frames: self.keep_frames,
            stop: machine::stop_on_signals()?,
            finished: &|clip, _| self.finished(clip),
        };
        let made = run.follow(&self.slurm)?;
        hashes::write_hashes(&self.dir)?;
        self.end(selection, &made, &watch)
    }

    /// Tells of a finished clip.
    fn finished(&self, clip: &ClipPlan) {
        if !self.json {
            // The run goes on if the reader has closed the pipe.
            let _ = print::lines([format!("{} {} frames", clip.path, clip.frames)]);
        }
        // The artist may be in the middle of an edit. The end of the run writes the hashes again.
        let _ = hashes::write_hashes(&self.dir);
    }

    /// Prints the answer.
    fn end(&self, selection: &Selection, made: &RunResult, watch: &Stopwatch) -> Result<Exit, Fatal> {
        self.answer(selection, made, watch)?;
        let is_there =
            |outcome: &Outcome| matches!(outcome, Outcome::Made(_) | Outcome::Rendered | Outcome::UpToDate(_));
        // The run that encodes answers for genomes that are not drawn, and each part for files that it cannot read.
        let left_out = selection.exit();
        let is_whole = matches!(left_out, Exit::Fine) || self.shard.is_some() && matches!(left_out, Exit::No);
        Ok(match (is_whole, made.outcomes.iter().all(is_there)) {
            (false, _) => left_out,
            (true, false) => Exit::No,
            (true, true) => Exit::Fine,
        })
    }

    fn answer(&self, selection: &Selection, made: &RunResult, watch: &Stopwatch) -> Result<(), Fatal> {
        let of_clip = |(clip, outcome): (_, &Outcome)| match outcome {
            Outcome::Busy => clip_answer(clip, "busy", None),
            Outcome::Made(hash) => clip_answer(clip, "made", Some(hash)),
            Outcome::Rendered => clip_answer(clip, "rendered", None),
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

//! `dreams import`: clips and genomes from elsewhere.
//!
//! Owns the command: its options and how it ends. `sources.rs` finds the files, `plan.rs` plans what is done with each clip,
//! `importer.rs` imports the clips one by one, `genomes.rs` the flames; `answer.rs` prints.
//!
//! Start at [`run`].

mod answer;
mod file_kind;
mod genomes;
mod importer;
mod plan;
mod scaling;
mod sources;

use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use flock::{MAX_FRAMES, SheepId};
use timing::{FrameCount, Rate};
use video::{Encoder, Form, Quality};

use crate::curate::add;
use crate::decoder::Decoder;
use crate::flock_folder::Draft;
use crate::flock_folder::paths::FOLDERS;
use crate::program::{Exit, Fatal, arguments, print, progress};
use crate::render::options;
use answer::{Answer, ClipAnswer};
use importer::{Importer, Outcome};
use plan::{ImportSettings, Plan, PlanResult};
use scaling::Fit;
use sources::Sources;

/// x264's preset for clips that were encoded before: a slower one would win little.
const PRESET: &str = "slow";

/// Take clips and genomes from elsewhere into a flock
///
/// From a content folder of Electric Sheep, every clip GENERATION=ID=FIRST=LAST.avi in it: a loop if FIRST is LAST,
/// else a transition; the sheep are called GENERATION.FIRST. From other videos, those that are called FROM=TO, or any
/// with --from and --to. From files of flam3 genomes, every flame, by its name.
///
/// A clip in the flock's form is copied. Any other that ffmpeg reads is encoded, frame for frame: the number of frames
/// stays, whatever the rate of the file, unless --fps keeps its pace. Tags (title, artist, copyright, licence) stay.
/// Damaged files and those with unclear names are left out and named. Clips that the flock has already are passed over,
/// so that the same command continues after an interruption.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  all is in the flock
  1  something was left out, and is named; or it was interrupted, or another import into this flock is running
  2  the command line or the manifest is wrong
  3  a file could not be read or written; the clips that were imported before are in the flock")]
pub(crate) struct Args {
    /// Folder of the flock
    dir: PathBuf,
    /// Folders, videos and genomes
    #[arg(required = true)]
    sources: Vec<PathBuf>,
    /// The sheep with which the video starts
    #[arg(long, value_name = "ID", requires = "to", value_parser = SheepId::new)]
    from: Option<SheepId>,
    /// The sheep with which it ends; the same one for a loop
    #[arg(long, value_name = "ID", requires = "from", value_parser = SheepId::new)]
    to: Option<SheepId>,
    /// Keep the pace of clips, as of so many frames a second: frames are repeated or left out
    #[arg(long, value_name = "N[/D]", value_parser = arguments::rate)]
    fps: Option<Rate>,
    /// How clips of another shape are scaled; without it they are left out
    #[arg(long, value_enum)]
    fit: Option<Fit>,
    /// x264's constant rate factor, to 51: smaller is finer and larger
    #[arg(long, value_name = "N", default_value_t = 17.0, value_parser = options::rate_factor)]
    crf: f32,
    /// Frames of the loops that are yet to be rendered from genomes
    #[arg(long, value_name = "N", default_value_t = add::FRAMES)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_FRAMES)))]
    frames: u32,
    /// Replace other files that are in the places of clips
    #[arg(long)]
    force: bool,
    /// Only print what would be imported, by the headers of the files
    #[arg(long)]
    dry_run: bool,
    /// Answer with one JSON document
    #[arg(long)]
    json: bool,
}

/// A file that was not imported.
#[derive(Clone, Debug, serde::Serialize)]
struct SkippedFile {
    source: PathBuf,
    reason: String,
}

/// Another import runs.
#[derive(Debug, thiserror::Error)]
#[error("another import into the flock in `{folder}` is running")]
struct ImportRunning {
    folder: PathBuf,
}

/// Runs the command.
pub(crate) fn run(args: &Args, decoder: &dyn Decoder) -> Result<Exit, Fatal> {
    let role = args.from.clone().zip(args.to.clone()).map(|(from, to)| file_kind::role(from, to));
    // May be without sheep.
    let manifest = Draft::lock(&args.dir)?.edit.manifest().clone();
    let form = Form { size: manifest.size, fps: manifest.fps };
    let settings = ImportSettings { folder: &args.dir, form, fit: args.fit, fps: args.fps };
    let sources = Sources::find(&args.sources, role.as_ref())?;
    let _lock = if args.dry_run { None } else { Some(lock(&args.dir)?) };
    let mut answer = Answer { tombstones: sources.tombstones, left_out: sources.skipped, ..Answer::default() };
    let mut plans = Vec::new();
    for (source, role) in &sources.clips {
        match Plan::of(source, role, &manifest, &settings) {
            PlanResult::Planned(plan) => plans.push(*plan),
            PlanResult::Skipped(reason) => answer.left_out.push(SkippedFile { source: source.clone(), reason }),
            PlanResult::AlreadyThere(path) => answer.clips.push(ClipAnswer::new(source, role, path, "stood")),
        }
    }
    note_pace(&plans, &settings);
    let result = if args.dry_run {
        args.plan_only(&plans, &sources.genomes, &mut answer)
    } else {
        args.import(&plans, &sources.genomes, &settings, decoder, &mut answer)
    };
    // The answer is printed even if the import failed.
    answer.print(sources.others, args.json)?;
    result?;
    Ok(if answer.left_out.is_empty() && !answer.interrupted { Exit::Fine } else { Exit::No })
}

impl Args {
    /// Adds to the answer what would be done.
    fn plan_only(&self, plans: &[Plan], genomes: &[PathBuf], answer: &mut Answer) -> Result<(), Fatal> {
        for plan in plans {
            let state = if plan.encode.is_some() { "encode" } else { "copy" };
            answer.clips.push(ClipAnswer::of(plan, state).with(plan.about.frames, None));
        }
        self.import_genomes(genomes, answer)
    }

    /// Imports all clips, then all genomes.
    fn import(
        &self,
        plans: &[Plan],
        genomes: &[PathBuf],
        settings: &ImportSettings<'_>,
        decoder: &dyn Decoder,
        answer: &mut Answer,
    ) -> Result<(), Fatal> {
        let quality = Quality { crf: self.crf, preset: PRESET, max_bits_per_second: None };
        Encoder::check(&self.dir, &settings.form, quality).map_err(|error| Fatal::new(Exit::Malformed, error))?;
        let stop = options::stop_on_signals()?;
        let frames: u32 = plans.iter().filter_map(|plan| Some(plan.about.frames?.0)).sum();
        let bar = progress::bar("importing frames", frames as usize);
        let importer = Importer { settings, quality, force: self.force, stop: &stop, decoder, bar: &bar };
        for plan in plans {
            let state = if plan.encode.is_some() { "encoded" } else { "copied" };
            let outcome = if stop.load(Ordering::Relaxed) { Outcome::Interrupted } else { importer.import(plan)? };
            let clip_answer = match outcome {
                Outcome::Imported { frames, hash, added } => {
                    answer.added.extend(added);
                    ClipAnswer::of(plan, state).with(Some(frames), Some(hash))
                }
                Outcome::Interrupted => {
                    answer.interrupted = true;
                    return Ok(());
                }
                Outcome::Skipped(reason) => {
                    answer.left_out.push(SkippedFile { source: plan.source.clone(), reason });
                    continue;
                }
                Outcome::AlreadyThere => ClipAnswer::of(plan, "stood"),
            };
            if !self.json {
                // The run goes on if the reader has closed the pipe.
                let _ = bar.suspend(|| print::lines([clip_answer.line()]));
            }
            answer.clips.push(clip_answer);
        }
        bar.finish_and_clear();
        self.import_genomes(genomes, answer)
    }

    /// Imports the flames of `genomes`; with a dry run, only adds them to the answer.
    fn import_genomes(&self, genomes: &[PathBuf], answer: &mut Answer) -> Result<(), Fatal> {
        for source in genomes {
            let (imported, skipped) = genomes::import(source, &self.dir, FrameCount(self.frames), self.dry_run)?;
            answer.genomes.extend(imported);
            answer.left_out.extend(skipped);
        }
        Ok(())
    }
}

/// Locks the flock against other imports: two of one clip would write the same file.
fn lock(folder: &Path) -> Result<File, Fatal> {
    let loops = folder.join(FOLDERS[1]);
    let opened = fs::create_dir_all(&loops).and_then(|()| File::open(&loops));
    let opened = opened.map_err(|source| Fatal::file("use", &loops, source))?;
    match opened.try_lock() {
        Err(TryLockError::WouldBlock) => Err(Fatal::new(Exit::No, ImportRunning { folder: folder.to_owned() })),
        // On a file system without locks the artist must not import twice at once.
        Ok(()) | Err(TryLockError::Error(_)) => Ok(opened),
    }
}

/// Notes on stderr which clips play faster or slower at the flock's rate.
fn note_pace(plans: &[Plan], settings: &ImportSettings<'_>) {
    let mut rates: Vec<Rate> = Vec::new();
    for rate in plans.iter().filter_map(|plan| plan.about.fps) {
        if settings.fps.is_none() && rate != settings.form.fps && !rates.contains(&rate) {
            rates.push(rate);
        }
    }
    let per_second = |rate: Rate| f64::from(rate.num()) / f64::from(rate.den());
    for rate in rates {
        let faster = per_second(settings.form.fps) / per_second(rate);
        print::note(&format!(
            "note: clips of {rate} frames per second play {faster:.3} times as fast at the flock's {}; --fps {rate} keeps \
             their pace",
            settings.form.fps
        ));
    }
}

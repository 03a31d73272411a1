//! `dreams import`: clips and genomes from elsewhere.
//!
//! Owns the command: its options and how it ends. `sources.rs` finds the files, `plan.rs` plans what is done with each clip,
//! `summary.rs` tells the plan and `estimate.rs` its cost, `pool.rs` has the clips made by `importer.rs` on all cores and
//! added by `commit.rs`, `genomes.rs` imports the genomes that `genome_file.rs` reads, `names.rs` names and
//! `key_frames.rs` recognises as animations; `answer.rs` prints, and gives the credits the origin of each.
//!
//! Start at [`run`].

mod answer;
mod commit;
mod electric;
mod estimate;
mod file_kind;
mod genome_file;
mod genomes;
mod importer;
mod key_frames;
mod names;
mod plan;
mod pool;
mod scaling;
mod sources;
mod summary;

use std::collections::HashSet;
use std::fs::{self, File, TryLockError};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use flame::genome::Reasons;
use flock::Draft;
use flock::{MAX_FRAMES, Manifest, SheepId};
use operations::credits::{self, CreditsFile};
use operations::decoder::Decoder;
use operations::flock_folder::paths::FOLDERS;
use operations::program::{Exit, Fatal, print, progress, reasons};
use operations::render::machine;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use timing::FrameCount;
use video::{Encoder, Form, Quality, Tuning};

use crate::curate::add;
use crate::{arguments, ids};
use answer::{Answer, ClipAnswer};
use commit::Outcome;
use genome_file::Reading;
use genomes::{GenomeChoices, GenomesAnswer};
use importer::Importer;
use key_frames::KeyFrames;
use plan::{ClipPlan, ImportSettings, NamedMatrix, Pace, PlanResult, Planner};
use pool::Report;
use scaling::Fit;
use sources::{SourceClip, Sources, doubled};
use summary::Summary;

/// x264's preset for clips that were encoded before: a slower one would win little.
const PRESET: &str = "slow";
/// Bytes of memory for each pixel of the flock while a clip is encoded with that preset, with which x264 looks 50 frames
/// ahead: 261 MB were measured at 1280x720.
const BYTES_PER_PIXEL: u64 = 300;

/// Take clips and genomes from elsewhere into a flock
///
/// From a content folder of Electric Sheep, every clip GENERATION=ID=FIRST=LAST.avi in it: a loop if FIRST is LAST,
/// else a transition; the sheep are called GENERATION.FIRST. From other videos, those that are called FROM=TO, or any
/// with --from and --to. From files of genomes, every genome, by its name, in the letters that an id may have; of
/// different genomes with one name the second gets a number. Flames that are the key frames of one animation are left out,
/// unless --key-frames says which of them are sheep. A flame that asks for what is not drawn is left out with all reasons; what
/// is drawn without something that matters less is named.
///
/// A clip in the flock's form is copied. Any other that ffmpeg reads is encoded, frame for frame: the number of frames
/// stays, whatever the rate of the file, unless --fps keeps its pace. Tags (title, artist, copyright, licence) stay.
/// Colours without a tag are read by BT.601 where Electric Sheep made the clip, else by the size, unless --matrix says
/// otherwise. All of this is told before the first clip is encoded. What names and files tell of authors and licences is
/// written into credits.toml; entries that are there stay.
///
/// Damaged files, those with unclear names and folders that cannot be listed are left out and named. Of several files for
/// one loop the first sound one is taken. Links to folders are followed within the folders that are named. Hidden files
/// and folders and those of deleted files are passed over, unless they are named. Clips that the flock has already are
/// passed over, so that the same command continues after an interruption; --force replaces them. In names, bytes that
/// are not UTF-8 are told as `\\xff`, control characters as `\\u{1b}`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  all is in the flock
  1  something was left out, and is named; or it was interrupted, or another import into this flock is running
  2  the command line or the manifest is wrong
  3  a file could not be read or written; the clips that were imported before are in the flock")]
#[expect(clippy::struct_excessive_bools, reason = "independent switches")]
pub struct Args {
    /// Folder of the flock
    dir: PathBuf,
    /// Folders, videos and genomes
    #[arg(required = true)]
    sources: Vec<PathBuf>,
    /// The sheep with which the video starts
    #[arg(long, value_name = "ID", requires = "to", value_parser = SheepId::new)]
    #[arg(add = ids::completer())]
    from: Option<SheepId>,
    /// The sheep with which it ends; the same one for a loop
    #[arg(long, value_name = "ID", requires = "from", value_parser = SheepId::new)]
    #[arg(add = ids::completer())]
    to: Option<SheepId>,
    /// Keep the pace of clips, as of so many frames a second, or of those that each file tells: frames are repeated or
    /// left out
    #[arg(long, value_name = "N[/D]|as-told", value_parser = Pace::parse)]
    fps: Option<Pace>,
    /// The matrix by which the colours of all clips are read, whatever their files say
    #[arg(long, value_enum)]
    matrix: Option<NamedMatrix>,
    /// How clips of another shape are scaled; without it they are left out
    #[arg(long, value_enum)]
    fit: Option<Fit>,
    /// x264's constant rate factor, to 51: smaller is finer and larger
    #[arg(long, value_name = "N", default_value_t = 17.0, value_parser = arguments::rate_factor)]
    crf: f32,
    /// Frames of the loops and transitions that are yet to be rendered from genomes
    #[arg(long, value_name = "N", default_value_t = add::FRAMES)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_FRAMES)))]
    frames: u32,
    /// Clips encoded at once, as far as memory goes
    #[arg(long, value_name = "T", default_value_t = machine::cores(), value_parser = arguments::threads)]
    threads: NonZeroUsize,
    /// What becomes of a file with the key frames of one animation; without it such a file is left out
    #[arg(long, value_enum, value_name = "WHICH")]
    key_frames: Option<KeyFrames>,
    /// Leave unknown variations out of genomes, as flam3 does, and those with unknown parameters, and mark these genomes;
    /// without it such genomes are left out
    #[arg(long)]
    as_far_as_possible: bool,
    /// Replace clips and genomes that the flock has, and other files that are in their places
    #[arg(long)]
    force: bool,
    /// Only print what would be imported, by the headers of the files, and its cost, measured on a few frames
    #[arg(long)]
    dry_run: bool,
    /// Answer with one JSON document
    #[arg(long)]
    json: bool,
}

/// A file that was not imported.
#[derive(Clone, Debug, serde::Serialize)]
struct SkippedFile {
    #[serde(serialize_with = "print::serialize_path")]
    source: PathBuf,
    reason: String,
    /// What its genome asks for that is not drawn.
    #[serde(skip_serializing_if = "Reasons::is_empty", serialize_with = "reasons::serialize")]
    reasons: Reasons,
}

impl SkippedFile {
    fn new(source: &Path, reason: String) -> Self {
        Self { source: source.to_owned(), reason, reasons: Reasons::default() }
    }
}

/// Another import runs.
#[derive(Debug, thiserror::Error)]
#[error("another import into the flock in `{folder}` is running")]
struct ImportRunning {
    folder: PathBuf,
}

/// Runs the command.
pub fn run(args: &Args, decoder: &dyn Decoder) -> Result<Exit, Fatal> {
    let role = args.from.clone().zip(args.to.clone()).map(|(from, to)| file_kind::role(from, to));
    // May be without sheep.
    let manifest = Draft::lock(&args.dir)?.edit.manifest().clone();
    // Before anything is imported: a mistake in the credits would else be found at the end.
    CreditsFile::read(&args.dir)?;
    let form = Form { size: manifest.size, fps: manifest.fps };
    let pace = args.fps.unwrap_or(Pace::FrameForFrame);
    let Args { dir, fit, matrix, force, .. } = args;
    let settings = ImportSettings { folder: dir, form, fit: *fit, pace, matrix: *matrix, force: *force };
    let sources = Sources::find(&args.sources, role.as_ref(), dir)?;
    let _lock = if args.dry_run { None } else { Some(lock(dir)?) };
    let (tombstones, links, hidden, left_out) = (sources.tombstones, sources.links, sources.hidden, sources.skipped);
    let mut answer = Answer { left_out, tombstones, links, hidden, ..Answer::default() };
    let plans = plan(&sources.clips, &manifest, &settings, &mut answer);
    answer.plan = Summary::of(&plans, form.fps);
    answer.plan.note(form.fps);
    let result = args.import(&plans, &sources.genomes, &settings, decoder, &mut answer);
    let result = result.and(if args.dry_run { Ok(()) } else { credits::write_down(&args.dir, answer.notes()) });
    // The answer is printed even if the import failed.
    answer.print(sources.others, args.json)?;
    result?;
    Ok(if answer.left_out.is_empty() && !answer.interrupted { Exit::Fine } else { Exit::No })
}

/// The plans of all clips, made on all cores; those that are skipped or there already go to the answer.
fn plan(
    clips: &[SourceClip],
    manifest: &Manifest,
    settings: &ImportSettings<'_>,
    answer: &mut Answer,
) -> Vec<ClipPlan> {
    let planner = Planner::new(manifest, settings);
    let bar = progress::bar("reading headers", clips.len());
    let plan = |clip| {
        let plan = planner.plan(clip);
        bar.inc(1);
        plan
    };
    let results: Vec<_> = clips.par_iter().map(plan).collect();
    bar.finish_and_clear();
    let mut plans = Vec::new();
    for (result, skipped) in results {
        answer.left_out.extend(skipped);
        match result {
            PlanResult::Planned(plan) => plans.push(plan),
            PlanResult::Skipped => (),
            PlanResult::AlreadyThere { source, role, path } => {
                answer.clips.push(ClipAnswer::new(&source, &role, path, "stood"));
            }
        }
    }
    plans
}

impl Args {
    /// Imports all clips, then all genomes; with a dry run, only adds to the answer what would be done.
    fn import(
        &self,
        plans: &[ClipPlan],
        genomes: &[PathBuf],
        settings: &ImportSettings<'_>,
        decoder: &dyn Decoder,
        answer: &mut Answer,
    ) -> Result<(), Fatal> {
        let quality = Quality { crf: self.crf, preset: PRESET, tuning: Tuning::Film, max_bits_per_second: None };
        Encoder::check(&self.dir, &settings.form, quality).map_err(|error| Fatal::new(Exit::Malformed, error))?;
        let (width, height) = settings.form.size;
        let bytes = u64::from(width) * u64::from(height) * BYTES_PER_PIXEL;
        // One clip at a time is tried with however little memory.
        let threads = machine::frames_at_once(self.threads, bytes).unwrap_or(NonZeroUsize::MIN);
        let frames: u64 = plans.iter().filter_map(|plan| Some(u64::from(plan.first().about.frames?.0))).sum();
        let bar = progress::bar("importing frames", frames as usize);
        if self.dry_run {
            let stop = AtomicBool::new(false);
            let importer = Importer { settings, quality, stop: &stop, decoder, bar: &bar };
            plan_only(&importer, plans, threads, answer);
        } else {
            let stop = machine::stop_on_signals()?;
            let importer = Importer { settings, quality, stop: &stop, decoder, bar: &bar };
            self.import_clips(&importer, plans, threads, answer)?;
        }
        bar.finish_and_clear();
        if answer.interrupted { Ok(()) } else { self.import_genomes(genomes, answer) }
    }

    /// Imports all clips.
    fn import_clips(
        &self,
        importer: &Importer<'_>,
        plans: &[ClipPlan],
        threads: NonZeroUsize,
        answer: &mut Answer,
    ) -> Result<(), Fatal> {
        let mut clips: Vec<(usize, ClipAnswer)> = Vec::new();
        let mut skipped: Vec<(usize, SkippedFile)> = Vec::new();
        let mut added = Vec::new();
        let fps = importer.settings.form.fps;
        let mut report = |at: usize, report: Report<'_>| {
            let (made, outcome) = match report {
                Report::Skipped(file) => return skipped.push((at, file)),
                Report::Clip(made, outcome) => (made, outcome),
            };
            let file = &plans[at].files[made.file];
            let state = match outcome {
                Outcome::Imported { added: sheep } => {
                    added.extend(sheep);
                    if file.encode.is_some() { "encoded" } else { "copied" }
                }
                Outcome::Refused(reason) => {
                    return skipped.push((at, SkippedFile::new(&file.source, reason)));
                }
                Outcome::AlreadyThere => "stood",
            };
            let clip = ClipAnswer::of(&plans[at], file, fps, state);
            let is_new = state != "stood";
            let clip = clip.with(is_new.then_some(made.frames.0.into()), is_new.then_some(made.hash));
            if !self.json && is_new {
                // The run goes on if the reader has closed the pipe.
                let _ = importer.bar.suspend(|| print::lines([clip.line()]));
            }
            clips.push((at, clip));
        };
        let complete = pool::run(importer, plans, threads, &mut report);
        clips.sort_by_key(|(at, _)| *at);
        skipped.sort_by_key(|(at, _)| *at);
        let loops: HashSet<&SheepId> = clips.iter().filter_map(|(_, clip)| clip.sheep.as_ref()).collect();
        // Others got their loops later in this run.
        answer.added.extend(added.into_iter().filter(|id| !loops.contains(id)));
        answer.clips.extend(clips.into_iter().map(|(_, clip)| clip));
        answer.left_out.extend(skipped.into_iter().map(|(_, file)| file));
        answer.interrupted = !complete?;
        Ok(())
    }

    fn genome_choices(&self) -> GenomeChoices {
        let Self { key_frames, as_far_as_possible, force, dry_run: dry, .. } = *self;
        let reading = Reading { key_frames, as_far_as_possible };
        GenomeChoices { frames: FrameCount(self.frames), reading, force, dry }
    }

    /// Imports `genomes`; with a dry run, only adds them to the answer.
    fn import_genomes(&self, genomes: &[PathBuf], answer: &mut Answer) -> Result<(), Fatal> {
        let mut told = GenomesAnswer::default();
        let result = genomes::import(genomes, &self.dir, self.genome_choices(), &mut told);
        answer.take(told);
        result
    }
}

/// Adds to the answer what would be done, and what it would cost.
fn plan_only(importer: &Importer<'_>, plans: &[ClipPlan], threads: NonZeroUsize, answer: &mut Answer) {
    let fps = importer.settings.form.fps;
    for plan in plans {
        let file = plan.first();
        let state = if file.encode.is_some() { "encode" } else { "copy" };
        answer.clips.push(ClipAnswer::of(plan, file, fps, state).with(file.frames(fps), None));
        let others = plan.files[1..].iter();
        answer.left_out.extend(others.map(|other| doubled(&plan.role, &file.source, &other.source)));
    }
    match estimate::estimate(importer, plans) {
        Some(cost) => answer.plan = std::mem::take(&mut answer.plan).with_cost(cost, threads),
        None => print::note("note: what it costs is not known: no clip that was tried can be encoded"),
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

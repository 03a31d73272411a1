//! `flock import`: clips and genomes from elsewhere.
//!
//! Owns the command: its options, its answer and how it ends. What is there to import is found by `sources.rs`, what a
//! clip needs by `plan.rs`; `take.rs` takes clips in one by one, `genomes.rs` the flames.
//!
//! Start at [`run`].

mod answer;
mod fit;
mod genomes;
mod names;
mod plan;
mod sources;
mod take;

use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use flock::{MAX_FRAMES, SheepId};
use timing::{FrameCount, Rate};
use video::{Encoder, Form, Quality};

use crate::arguments;
use crate::curate::add;
use crate::draft::Draft;
use crate::places::FOLDERS;
use crate::progress;
use crate::render::options;
use crate::report::{self, Exit, Fatal};
use answer::{Answer, Done};
use fit::Fit;
use plan::{Looked, Plan, Wishes};
use sources::Sources;
use take::{Hand, Took};

/// x264's preset for clips that were encoded before: what is lost is lost already.
const PRESET: &str = "slow";

/// Take clips and genomes from elsewhere into a flock
///
/// From a content folder of Electric Sheep, every clip GENERATION=ID=FIRST=LAST.avi in it: a loop where FIRST is LAST,
/// else a transition; the sheep are called GENERATION.FIRST. From other videos those that are called FROM=TO, or any
/// with --from and --to. From files of flam3 genomes, every flame, by its name.
///
/// A clip in the flock's form is copied. Any other that ffmpeg reads is encoded anew, frame for frame: as many come out
/// as went in, whatever rate the file tells, unless --fps keeps its pace. Tags (title, artist, copyright, licence) stay.
/// What is damaged or oddly named is left out and named. What the flock has already is passed over, so that the same
/// command goes on where it was interrupted.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  all is in the flock
  1  something was left out, and is named; or it was interrupted, or another import works on this flock
  2  the command line or the manifest is wrong
  3  a file could not be read or written; what was taken in before is in the flock")]
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
    /// Keep the pace of clips with so many frames a second, whatever they tell: frames are shown twice or left out
    #[arg(long, value_name = "N[/D]", value_parser = arguments::rate)]
    fps: Option<Rate>,
    /// What becomes of clips of another shape, which are else left out
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
    /// Only tell what would be taken in, by what the files tell of themselves
    #[arg(long)]
    dry_run: bool,
    /// Answer with one JSON document
    #[arg(long)]
    json: bool,
}

/// A file that was not taken in.
#[derive(Clone, Debug, serde::Serialize)]
struct LeftOut {
    source: PathBuf,
    reason: String,
}

/// An import that has to wait.
#[derive(Debug, thiserror::Error)]
#[error("another import works on the flock in `{folder}`")]
struct Busy {
    folder: PathBuf,
}

/// A flock's folder that cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("cannot use `{folder}`")]
struct Unusable {
    folder: PathBuf,
    source: io::Error,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Fatal> {
    let told = args.from.clone().zip(args.to.clone()).map(|(from, to)| names::shows(from, to));
    // May be without sheep.
    let manifest = Draft::take(&args.dir)?.edit.manifest().clone();
    let wishes = Wishes { form: Form { size: manifest.size, fps: manifest.fps }, fit: args.fit, fps: args.fps };
    let sources = Sources::find(&args.sources, told.as_ref())?;
    let _alone = if args.dry_run { None } else { Some(alone(&args.dir)?) };
    let mut answer = Answer { tombstones: sources.tombstones, left_out: sources.left_out, ..Answer::default() };
    let mut plans = Vec::new();
    for (source, shows) in &sources.clips {
        match Plan::of(source, shows, &args.dir, &manifest, &wishes) {
            Looked::Due(plan) => plans.push(*plan),
            Looked::LeftOut(reason) => answer.left_out.push(LeftOut { source: source.clone(), reason }),
            Looked::Stands(path) => answer.clips.push(Done::new(source, shows, path, "stood")),
        }
    }
    tell_pace(&plans, &wishes);
    let went = if args.dry_run {
        args.foresee(&plans, &sources.genomes, &mut answer)
    } else {
        args.take(&plans, &sources.genomes, &wishes, &mut answer)
    };
    // What was done is told, however it ended.
    answer.tell(sources.others, args.json)?;
    went?;
    Ok(if answer.left_out.is_empty() && !answer.interrupted { Exit::Fine } else { Exit::No })
}

impl Args {
    /// What would become of everything.
    fn foresee(&self, plans: &[Plan], genomes: &[PathBuf], answer: &mut Answer) -> Result<(), Fatal> {
        for plan in plans {
            let state = if plan.encode.is_some() { "encode" } else { "copy" };
            answer.clips.push(Done::of(plan, state).told(plan.about.frames, None));
        }
        self.sheep(genomes, answer)
    }

    /// Takes everything in.
    fn take(&self, plans: &[Plan], genomes: &[PathBuf], wishes: &Wishes, answer: &mut Answer) -> Result<(), Fatal> {
        let quality = Quality { crf: self.crf, preset: PRESET, max_bits_per_second: None };
        Encoder::check(&self.dir, &wishes.form, quality).map_err(|error| Fatal::new(Exit::Malformed, error))?;
        let stop = options::stop_on_signals()?;
        let frames: u32 = plans.iter().filter_map(|plan| Some(plan.about.frames?.0)).sum();
        let bar = progress::bar("importing frames", frames as usize);
        let hand = Hand { folder: &self.dir, wishes, quality, force: self.force, stop: &stop, bar: &bar };
        for plan in plans {
            let state = if plan.encode.is_some() { "encoded" } else { "copied" };
            let took = if stop.load(Ordering::Relaxed) { Took::Interrupted } else { hand.take(plan)? };
            let done = match took {
                Took::In { frames, hash, added } => {
                    answer.added.extend(added);
                    Done::of(plan, state).told(Some(frames), Some(hash))
                }
                Took::Interrupted => {
                    answer.interrupted = true;
                    return Ok(());
                }
                Took::LeftOut(reason) => {
                    answer.left_out.push(LeftOut { source: plan.source.clone(), reason });
                    continue;
                }
                Took::Stands => Done::of(plan, "stood"),
            };
            if !self.json {
                // Whoever reads along may leave; the flock is worth more than the line.
                let _ = bar.suspend(|| report::lines([done.line()]));
            }
            answer.clips.push(done);
        }
        bar.finish_and_clear();
        self.sheep(genomes, answer)
    }

    /// Takes in the flames of `genomes`, or tells what would become of them.
    fn sheep(&self, genomes: &[PathBuf], answer: &mut Answer) -> Result<(), Fatal> {
        for source in genomes {
            let (taken, left_out) = genomes::take(source, &self.dir, FrameCount(self.frames), self.dry_run)?;
            answer.genomes.extend(taken);
            answer.left_out.extend(left_out);
        }
        Ok(())
    }
}

/// Keeps other imports away as long as it is held: two that take in the same clip would write the same file.
fn alone(folder: &Path) -> Result<File, Fatal> {
    let loops = folder.join(FOLDERS[1]);
    let opened = fs::create_dir_all(&loops).and_then(|()| File::open(&loops));
    let opened = opened.map_err(|source| Fatal::new(Exit::Unreadable, Unusable { folder: loops, source }))?;
    match opened.try_lock() {
        Err(TryLockError::WouldBlock) => Err(Fatal::new(Exit::No, Busy { folder: folder.to_owned() })),
        // Where a file system knows no locks, two imports are the artist's to avoid.
        Ok(()) | Err(TryLockError::Error(_)) => Ok(opened),
    }
}

/// Tells what the flock's rate makes of clips that tell another one.
fn tell_pace(plans: &[Plan], wishes: &Wishes) {
    let mut rates: Vec<Rate> = Vec::new();
    for rate in plans.iter().filter_map(|plan| plan.about.fps) {
        if wishes.fps.is_none() && rate != wishes.form.fps && !rates.contains(&rate) {
            rates.push(rate);
        }
    }
    let per_second = |rate: Rate| f64::from(rate.num()) / f64::from(rate.den());
    for rate in rates {
        let faster = per_second(wishes.form.fps) / per_second(rate);
        report::note(&format!(
            "note: clips of {rate} frames per second play {faster:.3} times as fast at the flock's {}; --fps {rate} keeps \
             their pace",
            wishes.form.fps
        ));
    }
}

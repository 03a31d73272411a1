//! `dreams demo DIR`: renders the demo flock.
//!
//! Owns the command and its options. `plan.rs` has the table of sheep, `manifest.rs` writes the manifest;
//! `operations::render` renders.
//!
//! Start at [`run`].

mod manifest;
#[cfg(test)]
mod middles;
mod plan;
#[cfg(test)]
mod small_copy;

use std::num::NonZeroUsize;
use std::path::PathBuf;

use flock::{ClipHash, ClipPath};
use operations::program::{Exit, Fatal, print};
use operations::render::machine;
use operations::render::make::make_fatal;
use operations::render::make::{Outcome, RunOptions, make};
use operations::render::shard::Part;

use crate::arguments;
use plan::{Edition, Plan};

/// Render the demo flock into a folder
///
/// Sixteen sheep of all species and 32 transitions, rendered on all cores. The full quality takes days; --small takes hours. If it
/// is interrupted, the same command continues.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  the flock is finished
  1  it was interrupted, or another process renders a clip
  2  the command line is wrong
  3  a file could not be read or written, or a clip could not be made")]
pub struct Args {
    /// The folder; made where it is missing
    dir: PathBuf,
    /// As the small copy in the repository: coarser, shorter, under 48 MB in all
    #[arg(long)]
    small: bool,
    /// Width and height in pixels, both even
    #[arg(long, value_name = "WxH", value_parser = arguments::size)]
    size: Option<(u32, u32)>,
    /// Samples per pixel
    #[arg(long, value_name = "N", value_parser = arguments::samples)]
    spp: Option<f64>,
    /// How many times slower than the small copy
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100))]
    pace: Option<u32>,
    /// x264's constant rate factor, to 51: smaller is finer and larger
    #[arg(long, value_name = "N", value_parser = arguments::rate_factor)]
    crf: Option<f32>,
    /// Frames rendered at once, as far as memory goes
    #[arg(long, value_name = "N", default_value_t = machine::cores(), value_parser = arguments::threads)]
    threads: NonZeroUsize,
    /// Keep the rendered frames, so that another --crf needs no rendering: 1.4 MB each at 1280x720
    #[arg(long)]
    keep_frames: bool,
    /// Answer with one JSON document: {"clips": [...]}
    #[arg(long)]
    json: bool,
}

#[derive(serde::Serialize)]
struct Answer {
    /// Their paths in the folder.
    clips: Vec<ClipPath>,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<Exit, Fatal> {
    let plan = Plan::new(args.edition()).map_err(|error| Fatal::new(Exit::Unreadable, error))?;
    let bytes = plan.bytes().map_err(|error| Fatal::new(Exit::Malformed, error))?;
    let threads = machine::frames_at_once(args.threads, bytes)?;
    let stop = machine::stop_on_signals()?;
    let options = RunOptions { threads, keep_frames: args.keep_frames, stop, part: Part::Whole, shows_progress: true };
    let made = make(&plan.clips, &plan.edition.look, &args.dir, &options, &|_, _| ()).map_err(make_fatal)?;
    let hash = |outcome: &Outcome| match outcome {
        Outcome::Made(hash) | Outcome::UpToDate(hash) => Some(*hash),
        Outcome::Busy | Outcome::Rendered | Outcome::Unfinished => None,
    };
    let Some(hashes) = made.outcomes.iter().map(hash).collect::<Option<Vec<ClipHash>>>() else {
        print::note("not finished; the same command continues where this one stopped");
        return Ok(Exit::No);
    };
    let written = manifest::write(&plan, &hashes, &args.dir);
    written.map_err(|source| Fatal::write(&args.dir, source))?;
    if args.json {
        print::json(&Answer { clips: plan.clips.into_iter().map(|clip| clip.path).collect() })?;
    }
    Ok(Exit::Fine)
}

impl Args {
    fn edition(&self) -> Edition {
        let mut edition = if self.small { Edition::small() } else { Edition::fine() };
        let look = &mut edition.look;
        look.form.size = self.size.unwrap_or(look.form.size);
        look.spp = self.spp.or(look.spp);
        if let Some(crf) = self.crf {
            look.quality.crf = crf;
            (edition.finest, edition.noiseless_crf) = (None, None);
        }
        edition.pace = self.pace.unwrap_or(edition.pace);
        edition
    }
}

//! `flock demo DIR`: a flock of our own, rendered here.
//!
//! Owns the command: its options and what is said about them. Never knows what a genome or a codec is beyond handing
//! them on: `plan.rs` has the table of sheep, `make.rs` does the work, `manifest.rs` writes the flock down.
//!
//! Start at [`run`].

mod frames;
mod make;
mod manifest;
mod plan;
#[cfg(test)]
mod small_copy;

use std::io;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::thread;

use flame::GenomeError;
use flock::ClipPath;
use make::Effort;
use plan::{Look, Plan};
use video::EncodeError;

use crate::report::{Exit, Fatal};

/// Render the demo flock into a folder
///
/// Seven sheep and fourteen transitions, rendered on all cores. As fine as good pictures are it takes days; --small
/// takes hours. Interrupted at any moment, the same command goes on where it was.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  the flock is finished
  1  does not occur
  2  the command line is wrong
  3  a file could not be read or written, or a clip could not be made")]
pub(crate) struct Args {
    /// The folder; made where it is missing
    dir: PathBuf,
    /// As the small copy in the repository: coarser, shorter, 16 MB in all
    #[arg(long)]
    small: bool,
    /// Width and height in pixels, both even
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<(u32, u32)>,
    /// Samples per pixel
    #[arg(long, value_name = "N", value_parser = samples)]
    spp: Option<f64>,
    /// How many times slower than the small copy
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100))]
    pace: Option<u32>,
    /// x264's constant rate factor, 0 to 51: smaller is finer and larger
    #[arg(long, value_name = "N", value_parser = rate_factor)]
    crf: Option<f32>,
    /// Frames rendered at once; each takes 80 MB, four times that for the fine flock
    #[arg(long, value_name = "N", default_value_t = cores())]
    threads: NonZeroUsize,
    /// Keep the rendered frames, so that another --crf needs no rendering: 1.4 MB each at 1280x720
    #[arg(long)]
    keep_frames: bool,
}

/// Why the demo was not made. What was finished stays finished.
#[derive(Debug, thiserror::Error)]
pub(crate) enum DemoError {
    /// A clip could not be encoded.
    #[error("cannot finish a clip of the demo")]
    Encode(#[source] EncodeError),
    /// A file or folder could not be read or written.
    #[error("cannot use `{path}`")]
    File {
        /// Which.
        path: PathBuf,
        /// What the kernel said.
        source: io::Error,
    },
    /// A genome of the table cannot be read: our bug.
    #[error("cannot read a genome of the demo")]
    Genome(#[source] GenomeError),
    /// A frame could not be rendered: our bug.
    #[error("cannot render frame {frame} of `{clip}`: {reason}")]
    Render {
        /// The clip.
        clip: ClipPath,
        /// The frame, from 0.
        frame: u32,
        /// What the renderer said.
        reason: String,
    },
    /// The system refused threads.
    #[error("cannot start rendering: {reason}")]
    Threads {
        /// What it said.
        reason: String,
    },
    /// A rendered frame was damaged on the disk before it was encoded.
    #[error("frame {frame} of `{clip}` is damaged on the disk (the next run renders it again)")]
    Torn {
        /// The clip.
        clip: ClipPath,
        /// The frame, from 0.
        frame: u32,
    },
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Fatal> {
    let hint = "the same command goes on where this one stopped";
    make_flock(args).map_err(|error| Fatal::new(Exit::Unreadable, error).hint(hint))?;
    Ok(Exit::Fine)
}

fn make_flock(args: &Args) -> Result<(), DemoError> {
    let plan = Plan::new(args.look()).map_err(DemoError::Genome)?;
    let effort = Effort { threads: args.threads, keep_frames: args.keep_frames };
    let hashes = make::make(&plan, &args.dir, effort)?;
    manifest::write(&plan, &hashes, &args.dir).map_err(|source| DemoError::File { path: args.dir.clone(), source })
}

impl Args {
    fn look(&self) -> Look {
        let look = if self.small { Look::small() } else { Look::fine() };
        Look {
            size: self.size.unwrap_or(look.size),
            spp: self.spp.unwrap_or(look.spp),
            pace: self.pace.unwrap_or(look.pace),
            crf: self.crf.unwrap_or(look.crf),
            ..look
        }
    }
}

fn cores() -> NonZeroUsize {
    thread::available_parallelism().unwrap_or(NonZeroUsize::MIN)
}

fn size(text: &str) -> Result<(u32, u32), String> {
    let side = |text: &str| text.parse().ok().filter(|side: &u32| (16..=4096).contains(side) && side.is_multiple_of(2));
    let sides = text.split_once('x').and_then(|(width, height)| Some((side(width)?, side(height)?)));
    sides.ok_or_else(|| "wanted an even width and height from 16 to 4096, such as 1280x720".into())
}

fn within(text: &str, least: f64, most: f64) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number| (least..=most).contains(number));
    number.ok_or_else(|| format!("wanted a number from {least} to {most}"))
}

fn samples(text: &str) -> Result<f64, String> {
    within(text, 0.1, 1e6)
}

fn rate_factor(text: &str) -> Result<f32, String> {
    within(text, 0.0, 51.0).map(|number| number as f32)
}

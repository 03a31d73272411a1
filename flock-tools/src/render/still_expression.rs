//! A still of an expression.
//!
//! Owns what the options of `dreams still` mean for expressions. Never writes a file.
//!
//! Start at [`is_one`] and [`draw`].

use std::path::Path;

use expression::{Genome, Loop, Renderer, Samples, Settings, cost};

use super::options;
use super::still::{Args, Drawn, Smoothing};
use crate::program::{Exit, Fatal, now::Stopwatch};

/// The size of the picture where none is asked for: expressions have none of their own.
const SIZE: [u32; 2] = [1280, 720];

/// Frames of a loop that does not move while the shutter is open.
const STANDS: f64 = 1e12;

/// The ending of a file's name.
const ENDING: &str = "expr";

/// How such a file begins, whatever its name is.
const BEGINS: &str = "(expression";

/// An option that means nothing here.
#[derive(Debug, thiserror::Error)]
enum OptionError {
    #[error("`{option}` is for flames, and this is an expression")]
    ForFlames { option: &'static str },
    #[error(
        "an expression has 1 or 16 samples per pixel, found {found}; without `--spp` 16, and 48 more where they differ"
    )]
    Samples { found: f64 },
}

/// Whether a file is an expression, by its name or by how it begins.
pub(super) fn is_one(path: &Path, text: &str) -> bool {
    path.extension().is_some_and(|ending| ending == ENDING) || text.trim_start().starts_with(BEGINS)
}

/// The picture of the expression in `text` that `args` ask for.
/// Errors: [`Fatal`] if it is not one, or cannot be rendered so.
pub(super) fn draw(args: &Args, text: &str) -> Result<Drawn, Fatal> {
    let settings = settings(args).map_err(|error| Fatal::new(Exit::Malformed, error))?;
    let genome_fatal = |source| args.genome_fatal(Exit::Malformed, source);
    let genome = Genome::parse(text).map_err(|error| genome_fatal(error.into()))?;
    let (frame, frames) = args.frame.zip(args.frames).map_or((0.0, STANDS), |(a, b)| (f64::from(a), f64::from(b)));
    let motion = Loop::new(&genome, frames);
    let demand = cost(&motion, frame, &settings).map_err(|error| genome_fatal(error.into()))?;
    let threads = options::threads_that_fit(args.threads, demand.bytes, demand.bytes_per_thread)?;
    let watch = Stopwatch::start();
    let renderer = Renderer::new(threads.get()).map_err(|error| Fatal::new(Exit::Unreadable, error))?;
    let drawn = renderer.render_counted(&motion, frame, &settings);
    let (image, samples) = drawn.map_err(|error| genome_fatal(error.into()))?;
    let (cpu_s, seconds) = (watch.cpu().as_secs_f64(), watch.wall().as_secs_f64());
    Ok(Drawn { image, samples, psnr: None, cpu_s, seconds })
}

fn settings(args: &Args) -> Result<Settings, OptionError> {
    let of_flames = [
        ("--psnr", args.psnr.is_some()),
        ("--supersample", args.supersample.is_some()),
        ("--temporal-samples", args.temporal_samples.is_some()),
        ("--time", args.time.is_some()),
        ("--filter", args.filter != Smoothing::Variance),
    ];
    if let Some((option, _)) = of_flames.into_iter().find(|(_, is_given)| *is_given) {
        return Err(OptionError::ForFlames { option });
    }
    let samples = match args.spp {
        None => Samples::Adaptive,
        Some(1.0) => Samples::One,
        Some(16.0) => Samples::Sixteen,
        Some(found) => return Err(OptionError::Samples { found }),
    };
    Ok(Settings { size: args.size.unwrap_or(SIZE), samples })
}

//! `dreams still`: one picture of a genome.
//!
//! Owns the command: its options, the PNG and the figures. A frame of a loop is named by its number and the loop's length; it
//! is then the same picture that `dreams render` puts into the clip.
//!
//! Start at [`run`]; `still_flame.rs` draws what only flames have.

use std::error::Error;
use std::io;
use std::num::NonZeroUsize;
use std::path::PathBuf;

use ::species::{Drawn, Image, RenderError, Settings, Threads};
use clap::ValueEnum;
use flame::Backend;
use flame::genome::Reasons;
use flock::ClipHash;
use operations::program::{Exit, Fatal, now::Stopwatch, print, reasons};
use operations::render::machine;
use operations::render::plan::SEED;
use operations::species::{self, Refused};
use png::{BitDepth, ColorType, Encoder, EncodingError};

use super::still_flame;
use crate::arguments;

/// The size of the picture where none is asked for and the genome suits every size.
const SIZE: [u32; 2] = [1280, 720];

/// Frames of a loop that does not move while the shutter is open.
const STANDS: f64 = 1e12;

/// Render one picture of a genome
///
/// Size, samples and everything else are the genome's unless an option is given. With --frame and --frames it is that
/// frame of the genome's loop, motion blur included. The answer names the program that wrote a flame, and where its tone
/// differs from flam3's. A flame that asks for what is not drawn is refused with all reasons.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  the picture is written
  1  does not occur
  2  the command line or the genome is wrong, or the genome asks for what is not drawn
  3  a file could not be read or written, or memory does not suffice")]
pub struct Args {
    /// File of the genome; with --time it may have several flames
    genome: PathBuf,
    /// Where the picture goes: a PNG file
    #[arg(long, value_name = "PNG")]
    out: PathBuf,
    /// Width and height in pixels; what is in view stays in view
    #[arg(long, value_name = "WxH", value_parser = arguments::any_size)]
    pub(super) size: Option<[u32; 2]>,
    /// Samples per pixel
    #[arg(long, value_name = "N", value_parser = arguments::samples)]
    pub(super) spp: Option<f64>,
    /// As many samples as it takes until the noise is this small: a peak signal-to-noise ratio in decibels, such as 45
    #[arg(long, value_name = "DB", value_parser = arguments::decibels, conflicts_with = "spp")]
    pub(super) psnr: Option<f64>,
    /// Histogram cells per pixel in each direction
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=16))]
    pub(super) supersample: Option<u32>,
    /// How the noise of few samples is smoothed, if the genome's estimator has a radius
    #[arg(long, value_enum, default_value_t = Smoothing::Variance)]
    pub(super) filter: Smoothing,
    /// The seed of the random numbers: the same gives the same picture, with any number of threads
    #[arg(long, value_name = "S", default_value_t = SEED)]
    pub(super) seed: u64,
    /// Threads to render with
    #[arg(long, value_name = "T", default_value_t = machine::cores(), value_parser = arguments::threads)]
    pub(super) threads: NonZeroUsize,
    /// Which frame of the loop, from 0
    #[arg(long, value_name = "I", requires = "frames", group = "moment")]
    pub(super) frame: Option<u32>,
    /// How many frames the loop has
    #[arg(long, value_name = "N", requires = "frame", value_parser = clap::value_parser!(u32).range(1..))]
    pub(super) frames: Option<u32>,
    /// The moment between the flames of the file, which are key frames at the times that they name
    #[arg(long, value_name = "T", conflicts_with = "frame", group = "moment", allow_negative_numbers = true, value_parser = arguments::time)]
    pub(super) time: Option<f64>,
    /// Moments in the frame; 1 switches motion blur off
    #[arg(long, value_name = "N", requires = "moment", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub(super) temporal_samples: Option<u32>,
    /// Bits of each channel
    #[arg(long, value_enum, default_value_t = Depth::Eight)]
    bits: Depth,
    /// Answer with one JSON document
    #[arg(long)]
    json: bool,
}

/// How noise is smoothed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Smoothing {
    /// Not at all
    None,
    /// By its measured variance: what two halves of the samples agree on stays; the more samples, the less is smoothed
    Variance,
    /// Spread by density, as flam3 does
    Flam3,
}

/// Bits of each channel.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Depth {
    /// For looking at
    #[value(name = "8")]
    Eight,
    /// For working on
    #[value(name = "16")]
    Sixteen,
}

#[derive(serde::Serialize)]
struct Answer {
    /// Samples drawn.
    samples: u64,
    /// Processor seconds of rendering.
    cpu_s: f64,
    /// Seconds of rendering.
    seconds: f64,
    /// The picture's peak signal-to-noise ratio in decibels, as measured; only with `--psnr`.
    #[serde(skip_serializing_if = "Option::is_none")]
    psnr: Option<f64>,
    /// BLAKE3 of the pixels: 16 bits of red, green, blue, the lower byte first, row by row.
    checksum: String,
    #[serde(flatten)]
    facts: Option<FlameFacts>,
}

/// What a flame says of how it is drawn.
#[derive(serde::Serialize)]
pub(super) struct FlameFacts {
    /// The program that wrote it; `null` if it does not show.
    pub(super) program: Option<&'static str>,
    /// Where its tone differs from flam3's, in the order in which that is applied.
    pub(super) tone: Vec<&'static str>,
    /// What it is drawn without.
    #[serde(serialize_with = "reasons::serialize")]
    pub(super) without: Reasons,
}

/// A picture, and what it took.
pub(super) struct Timed {
    pub(super) drawn: Drawn,
    /// Seconds of processors.
    pub(super) cpu_s: f64,
    /// Seconds.
    pub(super) seconds: f64,
    /// Of a flame.
    pub(super) facts: Option<FlameFacts>,
}

/// An option that means nothing here.
#[derive(Debug, thiserror::Error)]
#[error("`{option}` is for flames, and this is not one")]
struct OptionError {
    option: &'static str,
}

/// A genome that cannot be read or rendered.
#[derive(Debug, thiserror::Error)]
#[error("cannot render genome `{path}`")]
struct GenomeFileError {
    path: PathBuf,
    source: Box<dyn Error>,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<Exit, Fatal> {
    let text = species::text(&args.genome).map_err(|why| args.refused(why))?;
    let is_flame = species::is_of_flames(&args.genome, &text);
    let Timed { drawn, cpu_s, seconds, facts } =
        if is_flame { still_flame::draw(args, &text) } else { draw(args, &text) }?;
    let written = png(&drawn.image, args.bits).and_then(|bytes| durable::save(&args.out, &bytes));
    written.map_err(|source| Fatal::write(&args.out, source))?;
    let pixels: Vec<u8> = drawn.image.to_rgb16().into_iter().flat_map(u16::to_le_bytes).collect();
    let checksum = ClipHash::of(&pixels[..]).expect("reading memory does not fail").to_string();
    let Drawn { samples, psnr, .. } = drawn;
    if args.json {
        print::json(&Answer { samples, cpu_s, seconds, psnr, checksum, facts })?;
    } else {
        let rate = samples as f64 / cpu_s.max(1e-9) / 1e6;
        let noise = psnr.map(|psnr| format!("noise     {psnr:.2} dB"));
        let lines = [
            format!("samples   {samples}"),
            format!("time      {seconds:.2} s, {cpu_s:.2} CPU s, {rate:.1} million samples a CPU second"),
        ];
        let told = facts.iter().flat_map(FlameFacts::lines);
        print::lines(lines.into_iter().chain(noise).chain(told).chain([format!("checksum  {checksum}")]))?;
        if let Some(FlameFacts { without, .. }) = facts.filter(|facts| !facts.without.is_empty()) {
            print::note(&format!("note: the genome is drawn without {without}"));
        }
    }
    Ok(Exit::Fine)
}

/// The picture of the genome in `text` that `args` ask for.
/// Errors: [`Fatal`] if it is not one, or cannot be rendered so.
fn draw(args: &Args, text: &str) -> Result<Timed, Fatal> {
    let of_flames = [
        ("--psnr", args.psnr.is_some()),
        ("--supersample", args.supersample.is_some()),
        ("--time", args.time.is_some()),
        ("--filter", args.filter != Smoothing::Variance),
    ];
    if let Some((option, _)) = of_flames.into_iter().find(|(_, is_given)| *is_given) {
        return Err(Fatal::new(Exit::Malformed, OptionError { option }));
    }
    let genome = species::parse(&args.genome, text, &Backend::default()).map_err(|why| args.refused(why))?;
    let settings = Settings {
        size: args.size.or(genome.made_for()).unwrap_or(SIZE),
        spp: args.spp,
        psnr: None,
        supersample: None,
        temporal_samples: args.temporal_samples,
        smooths: true,
        seed: args.seed,
    };
    let (frame, frames) = args.frame.zip(args.frames).map_or((0.0, STANDS), |(a, b)| (f64::from(a), f64::from(b)));
    let motion = genome.turning(settings.size, frames);
    let refused = |error: RenderError| args.genome_fatal(Exit::Malformed, error.into());
    let demand = motion.demand(frame, &settings).map_err(refused)?;
    let threads = args.threads_for(demand.bytes, demand.bytes_per_thread)?;
    let watch = Stopwatch::start();
    let threads = Threads::new(threads.get()).map_err(|error| Fatal::new(Exit::Unreadable, error))?;
    let drawn = motion.frame(frame, &settings, &threads).map_err(refused)?;
    Ok(Timed { drawn, cpu_s: watch.cpu().as_secs_f64(), seconds: watch.wall().as_secs_f64(), facts: None })
}

impl FlameFacts {
    /// Where it comes from and its tone, if that is not flam3's.
    fn lines(&self) -> impl Iterator<Item = String> {
        let program = self.program.map(|program| format!("program   {program}"));
        let tone = (!self.tone.is_empty()).then(|| format!("tone      {}", self.tone.join(", ")));
        program.into_iter().chain(tone)
    }
}

impl Args {
    fn refused(&self, why: Refused) -> Fatal {
        let fatal = self.genome_fatal(why.exit, why.source);
        match why.hint {
            Some(hint) => fatal.hint(hint),
            None => fatal,
        }
    }

    /// The threads of a picture that takes `bytes` of memory, and `more` for each thread.
    /// Errors: [`Fatal`], which names the genome, where there is no room for one.
    pub(super) fn threads_for(&self, bytes: u64, more: u64) -> Result<NonZeroUsize, Fatal> {
        let named = |source| GenomeFileError { path: self.genome.clone(), source };
        machine::threads_that_fit(self.threads, bytes, more).map_err(|fatal| fatal.told_as(named))
    }

    /// Why the genome cannot be read or rendered.
    pub(super) fn genome_fatal(&self, exit: Exit, source: Box<dyn Error>) -> Fatal {
        Fatal::new(exit, GenomeFileError { path: self.genome.clone(), source })
    }
}

/// `image` as a PNG file.
fn png(image: &Image, depth: Depth) -> io::Result<Vec<u8>> {
    let io = |error: EncodingError| io::Error::other(error);
    let side = |pixels: usize| u32::try_from(pixels).map_err(io::Error::other);
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, side(image.width)?, side(image.height)?);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(match depth {
        Depth::Eight => BitDepth::Eight,
        Depth::Sixteen => BitDepth::Sixteen,
    });
    let mut writer = encoder.write_header().map_err(io)?;
    let samples = match depth {
        Depth::Eight => image.to_rgb8(),
        Depth::Sixteen => image.to_rgb16().into_iter().flat_map(u16::to_be_bytes).collect(),
    };
    writer.write_image_data(&samples).map_err(io)?;
    writer.finish().map_err(io)?;
    Ok(bytes)
}

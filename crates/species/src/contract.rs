//! The contract of a species.
//!
//! Owns the traits between those who make clips and those who know a genome, and the types that pass through them. Each
//! species promises: frame F of a loop of F frames is frame 0 to the bit; the ends of a transition are frames of the two
//! loops to the bit, and it sets out and arrives at their speeds; pixels are the same for any number of threads and on
//! every machine; a text is refused by name, or drawn within its demand.
//!
//! Start at [`Species`].

use std::any::Any;
use std::error::Error;
use std::fmt::Debug;

use crate::image::Image;
use crate::lineage::Lineage;
use crate::threads::Threads;

/// Why a text is no genome, or a genome is not drawn: in words for people, with the line and the column if it is of a text.
pub type Refusal = Box<dyn Error + Send + Sync>;

/// A kind of sheep.
pub trait Species: Send + Sync {
    /// What people call one of them, with its article: `a flame`.
    fn name(&self) -> &'static str;

    /// The ending of its files, without the dot.
    fn ending(&self) -> &'static str;

    /// Whether `text` begins as its files do, whatever the file is called.
    fn begins(&self, text: &str) -> bool;

    /// Reads a genome. What is not known in it, and means nothing to pictures, is kept.
    ///
    /// # Errors
    /// Says what is not understood, and where.
    fn parse(&self, text: &str) -> Result<Box<dyn Genome>, Refusal>;
}

/// What a sheep is made from.
pub trait Genome: Any + Debug + Send + Sync {
    /// What the artist calls it.
    fn name(&self) -> Option<&str>;

    /// The size that the artist made it for, width and height in pixels; `None` if it suits every size.
    fn made_for(&self) -> Option<[u32; 2]> {
        None
    }

    /// The text of its file.
    fn text(&self) -> String;

    /// What it says of its origin.
    fn lineage(&self) -> Lineage;

    /// The same genome, whose file says this of its origin and nothing else.
    fn with_lineage(&self, lineage: &Lineage) -> Box<dyn Genome>;

    /// All that its pictures depend on besides motion.
    fn recipe(&self, settings: &Settings) -> Recipe;

    /// Its loop in `frames` frames (> 0), in pictures of `size`, width and height in pixels.
    fn turning(&self, size: [u32; 2], frames: f64) -> Box<dyn Motion>;

    /// The transition to `to` in `frames` frames (> 0): frame 0 is frame 0 of its loop of `turns[0]` frames, and frame
    /// `frames` is frame 0 of the other's loop of `turns[1]`. `None` if the two have so little in common, or so little
    /// contrast on the way, that a [`Dissolve`](crate::Dissolve) of their pictures is better, or are of different species.
    fn transition(&self, to: &dyn Genome, size: [u32; 2], turns: [f64; 2], frames: f64) -> Option<Box<dyn Motion>>;
}

impl dyn Genome + '_ {
    /// Itself: for transitions and breeding, which need both of one species.
    pub fn as_any(&self) -> &dyn Any {
        self
    }
}

/// Something that has a picture at every frame.
pub trait Motion: Send + Sync {
    /// What the picture at `frame` takes. Nothing is drawn.
    ///
    /// # Errors
    /// As [`Motion::frame`]: what passes here can be drawn.
    fn demand(&self, frame: f64, settings: &Settings) -> Result<Demand, RenderError>;

    /// The picture at `frame`, in frames from the start; fractions lie between frames.
    ///
    /// # Errors
    /// [`RenderError::Refused`] says what cannot be drawn; [`RenderError::Stopped`] if `threads` were told to stop.
    fn frame(&self, frame: f64, settings: &Settings, threads: &Threads) -> Result<Drawn, RenderError>;

    /// Whether its pictures have noise that falls with the samples per pixel.
    fn is_noisy(&self) -> bool {
        false
    }
}

/// How pictures are drawn. A species leaves alone what means nothing to it; where there is `None`, the genome or the
/// species decides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Samples per pixel, > 0.
    pub spp: Option<f64>,
    /// Peak signal-to-noise ratio in decibels instead of samples per pixel, where pictures have noise.
    pub psnr: Option<f64>,
    /// Histogram cells per pixel in each direction, 1 or more.
    pub supersample: Option<u32>,
    /// Moments in a frame, 1 or more. 1 switches motion blur off.
    pub temporal_samples: Option<u32>,
    /// Whether the noise of few samples is smoothed.
    pub smooths: bool,
    /// Which random numbers, where pictures have noise.
    pub seed: u64,
}

/// All that pictures depend on besides motion, in three texts: equal for equal pictures.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recipe {
    /// The renderer and its version.
    pub version: String,
    /// The settings that it heeds.
    pub settings: String,
    /// The genome, without what changes no picture.
    pub genome: String,
}

/// What a picture takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Demand {
    /// Most samples that are drawn.
    pub samples: u64,
    /// Most bytes of memory that are in use at once, with one thread.
    pub bytes: u64,
    /// Bytes that each thread more needs.
    pub bytes_per_thread: u64,
}

/// A picture, and what it took.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawn {
    /// The picture.
    pub image: Image,
    /// Samples drawn.
    pub samples: u64,
    /// Its peak signal-to-noise ratio in decibels, as measured; only where [`Settings::psnr`] asks and pictures have noise.
    pub psnr: Option<f64>,
}

/// Why a picture is not drawn.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// It cannot be.
    #[error(transparent)]
    Refused(Refusal),
    /// Drawing was stopped by the caller.
    #[error("rendering was stopped")]
    Stopped,
}

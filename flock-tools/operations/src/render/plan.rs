//! The plan of a clip: what it is rendered from, and how.
//!
//! Owns how sheep become motions, and motions pictures of clips. Knows of a species no more than its contract, and the
//! version of what GPUs draw: the folder `species` names them. Never touches a disk and never chooses the clips:
//! `selection.rs` does for a flock, `dreams demo` for its own.
//!
//! Start at [`SheepMotion`], then [`ClipPlan`]; `make.rs` makes files of plans.

use std::fmt::Write;

use flock::{ClipHash, ClipPath, SheepId};
use species::{Demand, Dissolve, Drawn, Genome, Middle, Motion, Recipe, RenderError, Settings, Threads};
use timing::FrameCount;
use video::{Form, Quality, Tuning, Yuv420p};

/// The version of what turns light into frames of a clip: another one makes other pictures of the same light.
const VERSION: u32 = 1;

/// The default seed. Every frame of a clip is drawn from the same random numbers: the noise then moves with the flame,
/// which looks calmer and costs fewer bits than noise that flickers.
pub const SEED: u64 = 1;

/// x264's preset for everything that we render: a frame costs so much more than its encoding.
pub const PRESET: &str = "slower";

/// x264's default constant rate factor: 15 to 23 Mbit/s of the demo, at 1280x720 and 30 frames a second.
pub const CRF: f32 = 22.0;

/// Equal parts of a clip, at whose ends it is told what memory frames take.
const PLACES: u32 = 8;

/// Memory that a pixel takes between the renderer and the encoder.
const BYTES_ON_THE_WAY: u64 = 24;

/// How clips look: all that they depend on besides genomes and motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Size and rate of the clips.
    pub form: Form,
    /// Samples per pixel; the genome's own where `None`.
    pub spp: Option<f64>,
    /// Peak signal-to-noise ratio in decibels, instead of samples per pixel.
    pub psnr: Option<f64>,
    /// Histogram cells per pixel in each direction; the genome's own where `None`.
    pub supersample: Option<u32>,
    /// Moments in a frame; the genome's own where `None`.
    pub temporal_samples: Option<u32>,
    /// Which random numbers.
    pub seed: u64,
    /// The hash of the name of the GPU that draws; `None` where the processor does.
    pub gpu: Option<ClipHash>,
    /// How the pictures are encoded.
    pub quality: Quality<'static>,
}

/// The part of the graph that a clip shows.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum ClipRole {
    /// A sheep's loop.
    Loop(SheepId),
    /// The way from the first sheep to the second.
    Transition(SheepId, SheepId),
}

/// A sheep that turns once in so many frames.
#[derive(Debug)]
pub struct SheepMotion {
    genome: Box<dyn Genome>,
    turn: FrameCount,
}

/// A clip to be made.
pub struct ClipPlan {
    /// The part of the graph that it shows.
    pub role: ClipRole,
    /// Its path in the flock's folder.
    pub path: ClipPath,
    /// Its length.
    pub frames: FrameCount,
    /// The motion that its frames show.
    pub motion: Box<dyn Motion>,
    /// Whether its pictures are dissolves of two loops' pictures: there is no transition of their genomes, or a duller one.
    pub is_dissolve: bool,
    /// How its pictures are encoded.
    pub quality: Quality<'static>,
    /// The hash of all that its pictures depend on.
    pub picture_recipe: ClipHash,
    /// The hash of all that its pictures and its encoding depend on.
    pub recipe: ClipHash,
}

impl ClipRole {
    /// The sheep that it starts and ends with.
    pub fn sheep(&self) -> [&SheepId; 2] {
        match self {
            Self::Loop(id) => [id, id],
            Self::Transition(from, to) => [from, to],
        }
    }
}

impl Look {
    /// Clips of `form` as `dreams render` makes them by default: everything else is the genomes'.
    pub fn of_genomes(form: Form) -> Self {
        let quality = Quality { crf: CRF, preset: PRESET, tuning: Tuning::Gradients, max_bits_per_second: None };
        Self { form, spp: None, psnr: None, supersample: None, temporal_samples: None, seed: SEED, gpu: None, quality }
    }

    /// The settings of the renderer.
    pub fn settings(&self) -> Settings {
        Settings {
            size: [self.form.size.0, self.form.size.1],
            spp: self.spp,
            psnr: self.psnr,
            supersample: self.supersample,
            temporal_samples: self.temporal_samples,
            smooths: true,
            seed: self.seed,
        }
    }
}

impl SheepMotion {
    /// `genome` as it turns once in `turn` frames.
    pub fn new(genome: Box<dyn Genome>, turn: FrameCount) -> Self {
        Self { genome, turn }
    }

    /// The samples and the memory that a frame of its loop takes.
    /// Errors: [`RenderError`] if it cannot be rendered at all.
    pub fn demand(&self, look: &Look) -> Result<Demand, RenderError> {
        demand(&*self.turning(look), 0.0, look)
    }

    /// Whether its pictures have noise that falls with the samples per pixel.
    pub fn is_noisy(&self, look: &Look) -> bool {
        self.turning(look).is_noisy()
    }

    /// Whether the transition to `to` in so many frames is a dissolve of both loops' pictures.
    pub fn is_dissolved_to(&self, to: &Self, frames: FrameCount, look: &Look) -> bool {
        self.transition(to, frames, look).1
    }

    /// The motion to `to` in so many frames, and whether it is a dissolve of their pictures.
    fn transition(&self, to: &Self, frames: FrameCount, look: &Look) -> (Box<dyn Motion>, bool) {
        let frames = f64::from(frames.0);
        let turns = [self, to].map(|sheep| f64::from(sheep.turn.0));
        match self.genome.transition(&*to.genome, look.settings().size, turns, frames) {
            Some(motion) => (motion, false),
            None => (Box::new(Dissolve::new([self.turning(look), to.turning(look)], frames)), true),
        }
    }

    fn turning(&self, look: &Look) -> Box<dyn Motion> {
        self.genome.turning(look.settings().size, f64::from(self.turn.0))
    }
}

impl ClipPlan {
    /// The loop of the sheep `id`, of the motion `sheep`, `frames` long.
    pub fn of_loop(id: SheepId, sheep: &SheepMotion, path: ClipPath, frames: FrameCount, look: &Look) -> Self {
        Self::new(ClipRole::Loop(id), path, frames, (sheep.turning(look), false), &[sheep], look)
    }

    /// The transition between the sheep `ids`, of the motions `ends`, `frames` long.
    pub fn of_transition(
        ids: [SheepId; 2],
        ends: [&SheepMotion; 2],
        path: ClipPath,
        frames: FrameCount,
        look: &Look,
    ) -> Self {
        let motion = ends[0].transition(ends[1], frames, look);
        let [from, to] = ids;
        Self::new(ClipRole::Transition(from, to), path, frames, motion, &ends, look)
    }

    fn new(
        role: ClipRole,
        path: ClipPath,
        frames: FrameCount,
        (motion, is_dissolve): (Box<dyn Motion>, bool),
        ends: &[&SheepMotion],
        look: &Look,
    ) -> Self {
        let mut recipe = text_of(ends, frames, look);
        if is_dissolve {
            write!(recipe, "\ndissolve {}", Dissolve::VERSION).expect("a text grows");
        }
        let mut picture_recipe = recipe.clone();
        if let Some(gpu) = look.gpu.filter(|_| motion.is_noisy()) {
            // Two GPUs draw other noise, so that one clip is of one of them; but either is as good as the other.
            let version = flame::GPU_VERSION;
            write!(picture_recipe, "\nby the GPU {gpu}, {version}").expect("a text grows");
            write!(recipe, "\nby a GPU, {version}").expect("a text grows");
        }
        let encoding = look.quality.tuning.parameters();
        write!(recipe, "\n{} fps\n{:?}\n{encoding}", look.form.fps, look.quality).expect("a text grows");
        let hash = |text: &str| ClipHash::of(text.as_bytes()).expect("reading memory does not fail");
        let (picture_recipe, recipe, quality) = (hash(&picture_recipe), hash(&recipe), look.quality);
        Self { role, path, frames, motion, is_dissolve, quality, picture_recipe, recipe }
    }

    /// How good it is half way; `None` of a loop.
    /// Errors: The renderer's error.
    pub fn middle(&self, look: &Look, threads: &Threads) -> Result<Option<Middle>, RenderError> {
        if matches!(self.role, ClipRole::Loop(_)) {
            return Ok(None);
        }
        Middle::of(&*self.motion, f64::from(self.frames.0), look.settings().size, threads).map(Some)
    }

    /// The samples that its first frame takes, or one half way where that shows one of two sides only; and the most
    /// memory of frames at [`PLACES`] and at the ends: a transition may hold both sides on the way, and one at its ends.
    /// Errors: [`RenderError`] if it cannot be rendered at all.
    pub fn demand(&self, look: &Look) -> Result<Demand, RenderError> {
        let at = |part: f64| demand(&*self.motion, f64::from(self.frames.0) * part, look);
        let mut most = at(if self.is_dissolve { 0.5 } else { 0.0 })?;
        for place in 0..=PLACES {
            let Demand { bytes, bytes_per_thread, .. } = at(f64::from(place) / f64::from(PLACES))?;
            most.bytes = most.bytes.max(bytes);
            most.bytes_per_thread = most.bytes_per_thread.max(bytes_per_thread);
        }
        Ok(most)
    }

    /// Renders frame `number` as the encoder takes it; `None` if `threads` were stopped.
    /// Errors: The renderer's error.
    pub fn picture(&self, number: u32, look: &Look, threads: &Threads) -> Result<Option<Yuv420p>, String> {
        let image = match self.motion.frame(f64::from(number), &look.settings(), threads) {
            Err(RenderError::Stopped) => return Ok(None),
            drawn => drawn.map(|Drawn { image, .. }| image).map_err(|error| error.to_string())?,
        };
        let (width, height) = look.form.size;
        let picture = Yuv420p::from_rgb16_dithered(width, height, &image.to_rgb16());
        picture.map(Some).map_err(|error| error.to_string())
    }
}

/// All that the pictures of a clip between `ends` depend on. What both ends have in common is said once.
fn text_of(ends: &[&SheepMotion], frames: FrameCount, look: &Look) -> String {
    let settings = look.settings();
    let recipes: Vec<Recipe> = ends.iter().map(|end| end.genome.recipe(&settings)).collect();
    let once = |part: fn(&Recipe) -> &str| {
        let mut parts: Vec<&str> = recipes.iter().map(part).collect();
        parts.dedup();
        parts.join(" and ")
    };
    let genomes: Vec<String> =
        ends.iter().zip(&recipes).map(|(end, recipe)| format!("{} frames\n{}", end.turn.0, recipe.genome)).collect();
    let (version, settings) = (once(|recipe| &recipe.version), once(|recipe| &recipe.settings));
    format!("{version}, frames {VERSION}\n{} frames\n{settings}\n{}", frames.0, genomes.join("\n"))
}

/// The samples and the memory that a frame of `motion` takes, until it is encoded.
fn demand(motion: &dyn Motion, frame: f64, look: &Look) -> Result<Demand, RenderError> {
    let demand = motion.demand(frame, &look.settings())?;
    let pixels = u64::from(look.form.size.0) * u64::from(look.form.size.1);
    Ok(Demand { bytes: demand.bytes + pixels * BYTES_ON_THE_WAY, ..demand })
}

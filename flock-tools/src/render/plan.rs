//! The plan of a clip: what it is rendered from, and how.
//!
//! Owns the one place where a species is linked: genomes become motions here, and motions pictures. Never touches a disk and
//! never chooses the clips: `selection.rs` does for a flock, `demo/plan.rs` for the demo.
//!
//! Start at [`SheepMotion`], then [`ClipPlan`]; `make.rs` makes files of plans.

use std::fmt::Write;
use std::sync::{Mutex, PoisonError};

use flame::{
    Arithmetic, Exposed, Exposure, Filter, Flame, FrameCost, Genome, Loop, Middle, Motion, RenderError, Renderer,
    Settings, Species, Transition,
};
use flock::{ClipHash, ClipPath, SheepId};
use timing::FrameCount;
use video::{Form, Quality, Tuning, Yuv420p};

/// The version of what turns light into frames of a clip: another one makes other pictures of the same light.
const VERSION: u32 = 1;

/// The default seed. Every frame of a clip is drawn from the same random numbers: the noise then moves with the flame,
/// which looks calmer and costs fewer bits than noise that flickers.
pub(crate) const SEED: u64 = 1;

/// x264's preset for everything that we render: a frame costs so much more than its encoding.
pub(crate) const PRESET: &str = "slower";

/// x264's default constant rate factor: 15 to 23 Mbit/s of the demo, at 1280x720 and 30 frames a second.
pub(crate) const CRF: f32 = 22.0;

/// Memory that a pixel takes between the renderer and the encoder.
const BYTES_ON_THE_WAY: u64 = 24;

/// How clips look: all that they depend on besides genomes and motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Look {
    /// Size and rate of the clips.
    pub(crate) form: Form,
    /// Samples per pixel; the genome's own where `None`.
    pub(crate) spp: Option<f64>,
    /// Peak signal-to-noise ratio in decibels, instead of samples per pixel.
    pub(crate) psnr: Option<f64>,
    /// Histogram cells per pixel in each direction; the genome's own where `None`.
    pub(crate) supersample: Option<u32>,
    /// Moments in a frame; the genome's own where `None`.
    pub(crate) temporal_samples: Option<u32>,
    /// Which random numbers.
    pub(crate) seed: u64,
    /// The hash of the name of the GPU that draws; `None` where the processor does.
    pub(crate) gpu: Option<ClipHash>,
    /// How the pictures are encoded.
    pub(crate) quality: Quality<'static>,
}

/// The part of the graph that a clip shows.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) enum ClipRole {
    /// A sheep's loop.
    Loop(SheepId),
    /// The way from the first sheep to the second.
    Transition(SheepId, SheepId),
}

/// The motion of a sheep.
#[derive(Clone, Debug)]
pub(crate) struct SheepMotion {
    motion: Loop,
    /// Equal for equal pictures.
    text: String,
}

/// A clip to be made.
pub(crate) struct ClipPlan {
    /// The part of the graph that it shows.
    pub(crate) role: ClipRole,
    /// Its path in the flock's folder.
    pub(crate) path: ClipPath,
    /// Its length.
    pub(crate) frames: FrameCount,
    /// The motion that its frames show, but for its exposure.
    pub(crate) motion: Box<dyn Motion + Send>,
    /// Its exposure, once it has been measured.
    exposure: Mutex<Option<Exposure>>,
    /// How its pictures are encoded.
    pub(crate) quality: Quality<'static>,
    /// The hash of all that its pictures depend on.
    pub(crate) picture_recipe: ClipHash,
    /// The hash of all that its pictures and its encoding depend on.
    pub(crate) recipe: ClipHash,
}

impl ClipRole {
    /// The sheep that it starts and ends with.
    pub(crate) fn sheep(&self) -> [&SheepId; 2] {
        match self {
            Self::Loop(id) => [id, id],
            Self::Transition(from, to) => [from, to],
        }
    }
}

impl Look {
    /// Clips of `form` as `dreams render` makes them by default: everything else is the genomes'.
    pub(crate) fn of_genomes(form: Form) -> Self {
        let quality = Quality { crf: CRF, preset: PRESET, tuning: Tuning::Gradients, max_bits_per_second: None };
        Self { form, spp: None, psnr: None, supersample: None, temporal_samples: None, seed: SEED, gpu: None, quality }
    }

    /// The settings of the renderer.
    pub(crate) fn settings(&self) -> Settings {
        Settings {
            size: Some([self.form.size.0, self.form.size.1]),
            spp: self.spp,
            psnr: self.psnr,
            supersample: self.supersample,
            temporal_samples: self.temporal_samples,
            filter: Filter::Variance,
            seed: self.seed,
            arithmetic: Arithmetic::Fastest,
        }
    }
}

impl SheepMotion {
    /// `genome` in a flock of `look`, which turns once in `turn` frames.
    pub(crate) fn new(genome: &Genome, turn: FrameCount, look: &Look) -> Self {
        let size = [look.form.size.0, look.form.size.1];
        // Cameras of one size, so that a transition between genomes of two sizes has no jump half way; and nothing
        // that changes no picture.
        let genome = Genome {
            camera: genome.camera.resized(size),
            name: None,
            extra: Vec::new(),
            children: Vec::new(),
            ..genome.clone()
        };
        let text = format!("{} frames\n{}", turn.0, genome.to_xml());
        Self { motion: Loop::new(&genome, f64::from(turn.0)), text }
    }

    /// The samples and the memory that a frame of its loop takes.
    /// Errors: [`RenderError`] if it cannot be rendered at all.
    pub(crate) fn demand(&self, look: &Look) -> Result<FrameCost, RenderError> {
        demand(&self.motion, look)
    }
}

impl ClipPlan {
    /// The loop of the sheep `id`, of the motion `sheep`, `frames` long.
    pub(crate) fn of_loop(id: SheepId, sheep: &SheepMotion, path: ClipPath, frames: FrameCount, look: &Look) -> Self {
        Self::new(ClipRole::Loop(id), path, frames, Box::new(sheep.motion.clone()), &[sheep], look)
    }

    /// The transition between the sheep `ids`, of the motions `ends`, `frames` long.
    pub(crate) fn of_transition(
        ids: [SheepId; 2],
        ends: [&SheepMotion; 2],
        path: ClipPath,
        frames: FrameCount,
        look: &Look,
    ) -> Self {
        let motion = Transition::new(&ends[0].motion, &ends[1].motion, f64::from(frames.0));
        let [from, to] = ids;
        Self::new(ClipRole::Transition(from, to), path, frames, Box::new(motion), &ends, look)
    }

    fn new(
        role: ClipRole,
        path: ClipPath,
        frames: FrameCount,
        motion: Box<dyn Motion + Send>,
        ends: &[&SheepMotion],
        look: &Look,
    ) -> Self {
        let ends: Vec<&str> = ends.iter().map(|end| end.text.as_str()).collect();
        let mut recipe = format!(
            "light {}, frames {VERSION}\n{} frames\n{:?}\n{}",
            flame::VERSION,
            frames.0,
            look.settings(),
            ends.join("\n")
        );
        let mut picture_recipe = recipe.clone();
        if let Some(gpu) = look.gpu {
            // Two GPUs draw other noise, so that one clip is of one of them; but either is as good as the other.
            let version = flame::GPU_VERSION;
            write!(picture_recipe, "\nby the GPU {gpu}, {version}").expect("a text grows");
            write!(recipe, "\nby a GPU, {version}").expect("a text grows");
        }
        let encoding = look.quality.tuning.parameters();
        write!(recipe, "\n{} fps\n{:?}\n{encoding}", look.form.fps, look.quality).expect("a text grows");
        let hash = |text: &str| ClipHash::of(text.as_bytes()).expect("reading memory does not fail");
        let exposure = Mutex::new(matches!(role, ClipRole::Loop(_)).then_some(Exposure::EVEN));
        let (picture_recipe, recipe, quality) = (hash(&picture_recipe), hash(&recipe), look.quality);
        Self { role, path, frames, motion, exposure, quality, picture_recipe, recipe }
    }

    /// Its exposure. The first call measures that of a transition, in half a second; others wait for it.
    /// Errors: The renderer's error.
    pub(crate) fn exposure(&self, renderer: &Renderer) -> Result<Exposure, RenderError> {
        let mut exposure = self.exposure.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(measured) = &*exposure {
            return Ok(measured.clone());
        }
        let measured = Exposure::measure(&*self.motion, f64::from(self.frames.0), renderer)?;
        Ok(exposure.insert(measured).clone())
    }

    /// How good it is half way; `None` of a loop.
    /// Errors: The renderer's error.
    pub(crate) fn middle(&self, renderer: &Renderer) -> Result<Option<Middle>, RenderError> {
        if matches!(self.role, ClipRole::Loop(_)) {
            return Ok(None);
        }
        let exposure = self.exposure(renderer)?;
        Middle::of(&*self.motion, f64::from(self.frames.0), &exposure, renderer).map(Some)
    }

    /// The samples and the memory that its first frame takes.
    /// Errors: [`RenderError`] if it cannot be rendered at all.
    pub(crate) fn demand(&self, look: &Look) -> Result<FrameCost, RenderError> {
        demand(&*self.motion, look)
    }

    /// Renders frame `number` as the encoder takes it; `None` if `renderer` was stopped.
    /// Errors: The renderer's error.
    pub(crate) fn picture(&self, number: u32, look: &Look, renderer: &Renderer) -> Result<Option<Yuv420p>, String> {
        let image = self.exposure(renderer).and_then(|exposure| {
            let motion = Exposed { motion: &*self.motion, exposure: &exposure };
            Flame { motion, renderer }.frame(f64::from(number), &look.settings())
        });
        let image = match image {
            Err(RenderError::Stopped) => return Ok(None),
            image => image.map_err(|error| error.to_string())?,
        };
        let (width, height) = look.form.size;
        let picture = Yuv420p::from_rgb16_dithered(width, height, &image.to_rgb16());
        picture.map(Some).map_err(|error| error.to_string())
    }
}

/// The samples and the memory that the first frame of `motion` takes, until it is encoded.
fn demand(motion: &dyn Motion, look: &Look) -> Result<FrameCost, RenderError> {
    let demand = FrameCost::of(motion, 0.0, &look.settings())?;
    let pixels = u64::from(look.form.size.0) * u64::from(look.form.size.1);
    Ok(FrameCost { bytes: demand.bytes + pixels * BYTES_ON_THE_WAY, ..demand })
}

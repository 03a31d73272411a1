//! The renderer: draws a moving genome at a moment.
//!
//! Owns the order of the work and the promise that the number of threads changes no pixel: samples are
//! drawn in numbered batches, each with its own random stream (`chaos.rs`), and counted in integers
//! (`histogram.rs`). Never reads a file, a clock or the system's entropy.
//!
//! Start at [`Renderer::render`]; `plan.rs` compiles a genome, `filter.rs` and `tonemap.rs` make light.
//!
//! # Source
//! Draves & Reckase, *The Fractal Flame Algorithm* (2008).

mod chaos;
mod error;
mod estimator;
mod filter;
mod histogram;
mod plan;
mod spread;
mod tonemap;
mod view;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::{ThreadPool, ThreadPoolBuilder};

pub use error::RenderError;

use crate::animate::Motion;
use crate::genome::Genome;
use crate::image::Image;
use chaos::Batches;
use plan::Plan;
use view::View;

/// Most bytes of the compiled genomes of a frame's moments.
const MAX_PLANS: u64 = 2_000_000_000;

/// Settings that override the genome's; `None` keeps the genome's own.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Settings {
    /// Width and height in pixels. The scale follows, so that the genome's own frame stays in view.
    pub size: Option<[u32; 2]>,
    /// Samples per pixel at zoom 0, > 0.
    pub spp: Option<f64>,
    /// Histogram cells per pixel in each direction, 1 or more.
    pub supersample: Option<u32>,
    /// Moments in a frame, 1 or more. 1 switches motion blur off.
    pub temporal_samples: Option<u32>,
    /// How the noise of few samples is smoothed, as far as the genome's estimator allows.
    pub filter: Filter,
    /// The same seed gives the same pixels on any number of threads.
    pub seed: u64,
}

/// How the noise of few samples is smoothed. How far, the genome says: `estimator_radius`, `estimator_minimum`,
/// `estimator_curve`; a radius of 0 switches every filter off.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// Not at all.
    None,
    /// Cells are averaged with neighbours that differ by no more than chance. With many samples the filter has no effect.
    #[default]
    Variance,
    /// As flam3 does: every cell is spread by a kernel that narrows with its density, whatever its neighbours are.
    Flam3,
}

/// Samples and memory that rendering a frame needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameCost {
    /// Samples that are drawn, 1e12 at most.
    pub samples: u64,
    /// Cells that filtering and density estimation look at then, 2.1e12 at most.
    pub cell_steps: u64,
    /// Most bytes of memory that are in use at once, with one thread.
    pub bytes: u64,
    /// Bytes that each thread more needs.
    pub bytes_per_thread: u64,
}

/// Threads to render with.
#[derive(Debug)]
pub struct Renderer {
    pool: ThreadPool,
    stop: Arc<AtomicBool>,
}

/// A frame before its first sample is drawn.
struct FrameSetup {
    genome: Genome,
    view: View,
    plans: Vec<Plan>,
    samples: u64,
    cell_steps: u64,
    /// How open the shutter is on average, `0.0..=1.0`.
    light: f64,
}

impl Renderer {
    /// A renderer with `threads` threads of its own; 0 takes as many as there are cores.
    ///
    /// # Errors
    /// [`RenderError::Threads`] if the system refuses them.
    pub fn new(threads: usize) -> Result<Renderer, RenderError> {
        let pool = ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|error| RenderError::Threads { threads, reason: error.to_string() })?;
        Ok(Renderer { pool, stop: Arc::default() })
    }

    /// The same renderer, which stops within milliseconds once `stop` is set.
    #[must_use]
    pub fn with_stop_flag(self, stop: Arc<AtomicBool>) -> Renderer {
        Renderer { stop, ..self }
    }

    /// Renders the moment `frame` of `motion`, the shutter open around it.
    ///
    /// * `frame` — frames from the motion's start; fractions lie between frames.
    /// * Returns displayable light of the size that `settings` or the genome at `frame` asks for.
    ///
    /// # Errors
    /// [`RenderError`] names what the genome lacks or what this renderer does not know; [`RenderError::Stopped`] if
    /// `stop` was set.
    pub fn render(&self, motion: &dyn Motion, frame: f64, settings: &Settings) -> Result<Image, RenderError> {
        let setup = FrameSetup::new(motion, frame, settings)?;
        self.pool.install(|| {
            let batches = Batches::new(&setup.plans, setup.samples, settings.seed);
            let histogram = histogram::collect(&setup.view, &batches, &self.stop);
            if self.stop.load(Ordering::Relaxed) {
                return Err(RenderError::Stopped);
            }
            Ok(tonemap::tone_map(histogram, &setup.view, &setup.genome, setup.light, settings.filter))
        })
    }
}

impl FrameCost {
    /// What rendering the moment `frame` of `motion` needs. Nothing is drawn.
    ///
    /// # Errors
    /// As [`Renderer::render`]: what passes here can be rendered.
    pub fn of(motion: &dyn Motion, frame: f64, settings: &Settings) -> Result<FrameCost, RenderError> {
        let setup = FrameSetup::new(motion, frame, settings)?;
        let [width, height] = setup.view.cells;
        let cells = (width * height) as u64;
        let pixels = (setup.view.size[0] * setup.view.size[1]) as u64;
        let plans = setup.plans.iter().map(Plan::bytes).sum::<u64>();
        // While samples are drawn: the sums and each thread's tile. Then: the sums as floats, a guide and the smoothed.
        let drawing = cells * (histogram::BYTES_OF_SUMS + histogram::BYTES_OF_TILE);
        let tone_mapping = 3 * cells * size_of::<[f32; 4]>() as u64;
        let picture = pixels * size_of::<[f32; 3]>() as u64;
        Ok(FrameCost {
            samples: Batches::new(&setup.plans, setup.samples, settings.seed).samples(),
            cell_steps: setup.cell_steps,
            bytes: plans + picture + drawing.max(tone_mapping),
            bytes_per_thread: cells * histogram::BYTES_OF_TILE,
        })
    }
}

impl FrameSetup {
    fn new(motion: &dyn Motion, frame: f64, settings: &Settings) -> Result<FrameSetup, RenderError> {
        let mut genome = motion.at(frame);
        settings.apply_to(&mut genome);
        let view = View::new(&genome)?;
        let moments = filter::shutter(&genome.sampling)?;
        let samples = view.samples(&genome)?;
        let cell_steps = view.cell_steps(&genome.sampling, samples, settings.filter)?;
        let mut plans = Vec::with_capacity(moments.len());
        for moment in &moments {
            let mut then = motion.at(frame + moment.offset);
            settings.apply_to(&mut then);
            // All moments of a frame fall into one histogram, though the genome may change its form between them.
            then.camera = then.camera.resized(genome.camera.size);
            then.sampling = genome.sampling;
            let plan = Plan::new(&then, View::new(&then)?, moment.light)?;
            let all = plan.bytes() * moments.len() as u64;
            let fits = all <= MAX_PLANS;
            view::in_range("temporal_samples", moments.len() as f64, fits, "moments of at most 2e9 bytes together")?;
            plans.push(plan);
        }
        let light = moments.iter().map(|moment| moment.light).sum::<f64>() / moments.len() as f64;
        Ok(FrameSetup { genome, view, plans, samples, cell_steps, light })
    }
}

impl Settings {
    fn apply_to(&self, genome: &mut Genome) {
        let Genome { camera, sampling, .. } = genome;
        if let Some(size) = self.size {
            *camera = camera.resized(size);
        }
        sampling.quality = self.spp.unwrap_or(sampling.quality);
        sampling.supersample = self.supersample.unwrap_or(sampling.supersample);
        sampling.temporal_samples = self.temporal_samples.unwrap_or(sampling.temporal_samples);
    }
}

//! The renderer: a genome in motion and a moment become a picture.
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

/// What a render may change about a genome; `None` keeps the genome's own.
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
    /// Cells are averaged with neighbours that differ by no more than chance. What is known stays sharp: with many
    /// samples the filter goes to nothing.
    #[default]
    Variance,
    /// As flam3 does: every cell is spread by a kernel that narrows with its density, whatever its neighbours are.
    Flam3,
}

/// What a frame takes to be rendered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Demand {
    /// Samples that are drawn.
    pub samples: u64,
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

/// Everything that is known of a frame before its first sample is drawn.
struct Shot {
    genome: Genome,
    view: View,
    plans: Vec<Plan>,
    samples: u64,
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

    /// The same renderer, which leaves off within milliseconds once `stop` is set.
    #[must_use]
    pub fn stopped_by(self, stop: Arc<AtomicBool>) -> Renderer {
        Renderer { stop, ..self }
    }

    /// Renders the moment `frame` of `motion`, the shutter open around it.
    ///
    /// * `frame` — frames from the motion's start; fractions lie between frames.
    /// * Returns displayable light of the size that `settings` or the genome at `frame` asks for.
    ///
    /// # Errors
    /// [`RenderError`] names what the genome lacks or what this renderer does not know; [`RenderError::Stopped`] if it
    /// was told to leave off.
    pub fn render(&self, motion: &dyn Motion, frame: f64, settings: &Settings) -> Result<Image, RenderError> {
        let shot = Shot::new(motion, frame, settings)?;
        self.pool.install(|| {
            let batches = Batches::new(&shot.plans, shot.samples, settings.seed);
            let histogram = histogram::collect(&shot.view, &batches, &self.stop);
            if self.stop.load(Ordering::Relaxed) {
                return Err(RenderError::Stopped);
            }
            Ok(tonemap::develop(histogram, &shot.view, &shot.genome, shot.light, settings.filter))
        })
    }
}

impl Demand {
    /// What the moment `frame` of `motion` takes. Nothing is drawn.
    ///
    /// # Errors
    /// As [`Renderer::render`]: what passes here can be rendered.
    pub fn of(motion: &dyn Motion, frame: f64, settings: &Settings) -> Result<Demand, RenderError> {
        let shot = Shot::new(motion, frame, settings)?;
        let [width, height] = shot.view.cells;
        let cells = (width * height) as u64;
        let pixels = (shot.view.size[0] * shot.view.size[1]) as u64;
        let plans = shot.plans.iter().map(Plan::bytes).sum::<u64>();
        // While samples are drawn: the sums and each thread's tile. Then: the sums as floats, a guide and the smoothed.
        let drawing = cells * (histogram::BYTES_OF_SUMS + histogram::BYTES_OF_TILE);
        let developing = 3 * cells * size_of::<[f32; 4]>() as u64;
        let picture = pixels * size_of::<[f32; 3]>() as u64;
        Ok(Demand {
            samples: Batches::new(&shot.plans, shot.samples, settings.seed).samples(),
            bytes: plans + picture + drawing.max(developing),
            bytes_per_thread: cells * histogram::BYTES_OF_TILE,
        })
    }
}

impl Shot {
    fn new(motion: &dyn Motion, frame: f64, settings: &Settings) -> Result<Shot, RenderError> {
        let mut genome = motion.at(frame);
        settings.apply_to(&mut genome);
        let view = View::new(&genome)?;
        let moments = filter::shutter(&genome.sampling)?;
        let mut plans = Vec::with_capacity(moments.len());
        for moment in &moments {
            let mut then = motion.at(frame + moment.offset);
            settings.apply_to(&mut then);
            // All moments of a frame fall into one histogram, though the genome may change its form between them.
            then.camera = then.camera.resized(genome.camera.size);
            then.sampling = genome.sampling;
            plans.push(Plan::new(&then, View::new(&then)?, moment.light)?);
        }
        let light = moments.iter().map(|moment| moment.light).sum::<f64>() / moments.len() as f64;
        let samples = view.samples(&genome.sampling)?;
        Ok(Shot { genome, view, plans, samples, light })
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

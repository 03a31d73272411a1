//! The renderer: draws a moving genome at a moment.
//!
//! Owns the order of the work and the promise that neither the number of threads nor the processor changes a pixel.
//! A frame becomes plain data (`shot.rs`: compiled genomes of `plan.rs`, the palette, numbered parts). Parts are drawn in
//! any order (`draw.rs`), each with its own random stream (`pool.rs`; `chaos.rs` is the reference), and counted in whole
//! numbers (`bins.rs`, `histogram.rs`). `backend.rs` may have a GPU draw instead (`gpu`). Never reads a
//! file, a clock or the system's entropy.
//!
//! Start at [`Renderer::render`]; `filter.rs` and `tonemap.rs` make light.
//!
//! # Source
//! Draves & Reckase, *The Fractal Flame Algorithm* (2008).

mod backend;
mod bins;
mod chaos;
mod draw;
mod error;
mod estimator;
mod filter;
#[cfg(feature = "gpu")]
mod gpu;
mod histogram;
mod plan;
mod pool;
mod shot;
mod spread;
mod tonemap;
mod view;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::{ThreadPool, ThreadPoolBuilder};

pub use backend::{Backend, GPU_VERSION};
pub use error::RenderError;

use crate::animate::Motion;
use crate::genome::Genome;
use crate::image::Image;
use bins::Bins;
pub use draw::Arithmetic;
use shot::Shot;
use view::View;

/// The version of the pictures: with another one, the same genome and settings make other bits.
pub const VERSION: u32 = 2;

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
    /// How samples are calculated.
    pub arithmetic: Arithmetic,
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
    backend: Backend,
}

/// A frame before its first sample is drawn.
struct FrameSetup {
    genome: Genome,
    view: View,
    shot: Shot,
    /// How many samples the genome asks for.
    samples: u64,
    cell_steps: u64,
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
        Ok(Renderer { pool, stop: Arc::default(), backend: Backend::default() })
    }

    /// The same renderer, which stops within milliseconds once `stop` is set.
    #[must_use]
    pub fn with_stop_flag(self, stop: Arc<AtomicBool>) -> Renderer {
        Renderer { stop, ..self }
    }

    /// The same renderer, whose samples `backend` draws where they are drawn in [`Arithmetic::Fastest`] and `f32` is enough.
    #[must_use]
    pub fn with_backend(self, backend: Backend) -> Renderer {
        Renderer { backend, ..self }
    }

    /// Renders the moment `frame` of `motion`, the shutter open around it.
    ///
    /// * `frame` — frames from the motion's start; fractions lie between frames.
    /// * Returns displayable light of the size that `settings` or the genome at `frame` asks for.
    ///
    /// # Errors
    /// [`RenderError`] names what the genome lacks or what this renderer does not know, or what a GPU has failed at;
    /// [`RenderError::Stopped`] if `stop` was set.
    pub fn render(&self, motion: &dyn Motion, frame: f64, settings: &Settings) -> Result<Image, RenderError> {
        let setup = FrameSetup::new(motion, frame, settings)?;
        let [width, height] = setup.view.cells;
        let arithmetic = if setup.view.is_deep() { Arithmetic::Reference } else { settings.arithmetic };
        self.pool.install(|| {
            let drawn = self.backend.draw(&setup.shot, width * height, arithmetic, &self.stop)?;
            if self.stop.load(Ordering::Relaxed) {
                return Err(RenderError::Stopped);
            }
            let share = drawn.samples as f64 / setup.samples as f64;
            Ok(tonemap::tone_map(drawn.cells, &setup.view, &setup.genome, share, settings.filter))
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
        // While samples are drawn: the sums, and what they carried. Then: the sums as floats, a guide and the smoothed.
        let drawing = 2 * cells * histogram::BYTES_OF_CELL;
        let tone_mapping = 3 * cells * size_of::<[f32; 4]>() as u64;
        let picture = pixels * size_of::<[f32; 3]>() as u64;
        let bytes_per_thread = Bins::bytes(cells as usize) + pool::BYTES;
        Ok(FrameCost {
            samples: setup.shot.samples(),
            cell_steps: setup.cell_steps,
            bytes: setup.shot.bytes() + picture + drawing.max(tone_mapping) + bytes_per_thread,
            bytes_per_thread,
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
        let mut genomes = Vec::with_capacity(moments.len());
        for moment in &moments {
            let mut then = motion.at(frame + moment.offset);
            settings.apply_to(&mut then);
            // All moments of a frame fall into one histogram, though the genome may change its form between them.
            then.camera = then.camera.resized(genome.camera.size);
            then.sampling = genome.sampling;
            let view = View::new(&then)?;
            genomes.push((then, view));
        }
        let shot = Shot::new(&genomes, &moments, samples, settings.seed)?;
        Ok(FrameSetup { genome, view, shot, samples, cell_steps })
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

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
mod tonemap;
mod view;

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
    /// The same seed gives the same pixels on any number of threads.
    pub seed: u64,
}

/// Threads to render with.
#[derive(Debug)]
pub struct Renderer {
    pool: ThreadPool,
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
        Ok(Renderer { pool })
    }

    /// Renders the moment `frame` of `motion`, the shutter open around it.
    ///
    /// * `frame` — frames from the motion's start; fractions lie between frames.
    /// * Returns displayable light of the size that `settings` or the genome at `frame` asks for.
    ///
    /// # Errors
    /// [`RenderError`] names what the genome lacks or what this renderer does not know.
    pub fn render(&self, motion: &dyn Motion, frame: f64, settings: &Settings) -> Result<Image, RenderError> {
        let mut genome = motion.at(frame);
        settings.apply_to(&mut genome);
        let view = View::new(&genome)?;
        let moments = filter::shutter(&genome.sampling);
        let total = view.samples(&genome.sampling);
        let mut plans = Vec::with_capacity(moments.len());
        for moment in &moments {
            let mut then = motion.at(frame + moment.offset);
            settings.apply_to(&mut then);
            plans.push(Plan::new(&then, View::new(&then)?, moment.light)?);
        }
        let batches = Batches::new(&plans, total, settings.seed);
        let light = moments.iter().map(|moment| moment.light).sum::<f64>() / moments.len() as f64;
        Ok(self.pool.install(|| {
            let histogram = histogram::collect(&view, &batches);
            tonemap::develop(&histogram, &view, &genome, light)
        }))
    }
}

impl Settings {
    fn apply_to(&self, genome: &mut Genome) {
        let Genome { camera, sampling, .. } = genome;
        if let Some(size) = self.size {
            let ratio = |axis: usize| f64::from(size[axis]) / f64::from(camera.size[axis]);
            camera.scale *= ratio(0).min(ratio(1));
            camera.size = size;
        }
        sampling.quality = self.spp.unwrap_or(sampling.quality);
        sampling.supersample = self.supersample.unwrap_or(sampling.supersample);
        sampling.temporal_samples = self.temporal_samples.unwrap_or(sampling.temporal_samples);
    }
}

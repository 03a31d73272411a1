//! The renderer: draws a moving genome at a moment.
//!
//! Owns the order of the work and the promise that neither the number of threads nor the processor changes a pixel.
//! A frame becomes plain data (`shot.rs`: compiled genomes of `plan.rs`, the palette, numbered parts). Parts are drawn in
//! any order (`draw.rs`), each with its own random stream (`pool.rs`; `chaos.rs` is the reference), and counted in whole
//! numbers (`bins.rs`, `histogram.rs`), in two halves (`film.rs`), until there are enough (`target.rs`). `backend.rs` may
//! have a GPU draw instead (`gpu`). Never reads a file, a clock or the system's entropy.
//!
//! Start at [`Renderer::render`]; `density.rs`, `wiener.rs` and `tonemap.rs` make light.
//!
//! # Source
//! Draves & Reckase, *The Fractal Flame Algorithm* (2008).

mod backend;
mod bins;
mod chaos;
mod density;
mod device;
mod draw;
mod error;
mod escape;
mod film;
mod filter;
#[cfg(feature = "gpu")]
mod gpu;
mod histogram;
mod look;
mod plan;
mod pool;
mod projection;
mod shot;
mod spread;
mod stages;
mod target;
mod tonemap;
mod view;
mod wiener;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

pub use backend::{Backend, GPU_VERSION};
pub use error::RenderError;
pub use filter::Filter;

use crate::animate::Motion;
use crate::genome::Genome;
use bins::Bins;
pub use draw::Arithmetic;
use film::Film;
use plan::Plan;
use shot::Shot;
use species::{Image, Threads, ThreadsError};
use target::Target;
use view::{View, in_range};

/// The version of the pictures: with another one, the same genomes and settings make other bits.
pub const VERSION: u32 = 4;

/// Why no noise is aimed at.
const NOT_FLAM3: &str = "none with flam3's filter, whose errors are no noise";

/// Settings that override the genome's; `None` keeps the genome's own.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Settings {
    /// Width and height in pixels. The scale follows, so that the genome's own frame stays in view.
    pub size: Option<[u32; 2]>,
    /// Samples per pixel at zoom 0, > 0.
    pub spp: Option<f64>,
    /// Peak signal-to-noise ratio in decibels, `10.0..=60.0`, instead of a fixed number of samples: as many are drawn, a
    /// million per pixel at most, until the noise that is left is that small. Not with [`Filter::Flam3`], whose errors
    /// are no noise.
    pub psnr: Option<f64>,
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

/// A rendered frame, and what it took.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// The picture.
    pub image: Image,
    /// Samples drawn, but for those of orbits that escaped.
    pub samples: u64,
    /// Peak signal-to-noise ratio of the picture in decibels, as its halves tell; only where [`Settings::psnr`] asks.
    pub psnr: Option<f64>,
}

/// Samples and memory that rendering a frame needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameCost {
    /// Samples that are drawn, 1e12 at most; with [`Settings::psnr`] the most that may be.
    pub samples: u64,
    /// Cells and pixels that filters look at then, 2.1e12 at most.
    pub cell_steps: u64,
    /// Most bytes of memory that are in use at once, with one thread.
    pub bytes: u64,
    /// Bytes that each thread more needs.
    pub bytes_per_thread: u64,
}

/// Threads to render with.
#[derive(Debug)]
pub struct Renderer {
    threads: Threads,
    backend: Backend,
}

/// A frame before its first sample is drawn.
struct FrameSetup {
    genome: Genome,
    view: View,
    shot: Shot,
    /// How many samples are asked for.
    samples: u64,
    cell_steps: u64,
    filter: Filter,
    target: Option<Target>,
    arithmetic: Arithmetic,
    /// Bytes that the genomes of its moments took while they were compiled.
    preparing: u64,
}

impl Renderer {
    /// A renderer with `threads` threads of its own; 0 takes as many as there are cores.
    ///
    /// # Errors
    /// [`RenderError::Threads`] if the system refuses them.
    pub fn new(threads: usize) -> Result<Renderer, RenderError> {
        Ok(Renderer { threads: Threads::new(threads)?, backend: Backend::default() })
    }

    /// The same renderer, which stops within milliseconds once `stop` is set.
    #[must_use]
    pub fn with_stop_flag(self, stop: Arc<AtomicBool>) -> Renderer {
        Renderer { threads: self.threads.with_stop_flag(stop), ..self }
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
        Ok(self.render_measured(motion, frame, settings)?.image)
    }

    /// Renders as [`Renderer::render`] does, and tells what was drawn and what noise is left.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn render_measured(
        &self,
        motion: &dyn Motion,
        frame: f64,
        settings: &Settings,
    ) -> Result<Measured, RenderError> {
        draw_frame(motion, frame, settings, &self.backend, &self.threads)
    }
}

/// Renders the moment `frame` of `motion` on `threads`, its samples drawn by `backend`.
pub(crate) fn draw_frame(
    motion: &dyn Motion,
    frame: f64,
    settings: &Settings,
    backend: &Backend,
    threads: &Threads,
) -> Result<Measured, RenderError> {
    let setup = FrameSetup::new(motion, frame, settings)?;
    threads.run(|| setup.draw(backend, threads.stop()))
}

/// At most `count` points of `genome` that are seen, wherever its camera stands: fewer where orbits escape.
pub(crate) fn points(genome: &Genome, count: usize, seed: u64) -> Result<Vec<[f64; 2]>, RenderError> {
    let plan = Plan::new(genome, &View::new(genome)?)?;
    Ok(chaos::points(&plan, count, seed))
}

impl From<ThreadsError> for RenderError {
    fn from(ThreadsError { threads, reason }: ThreadsError) -> RenderError {
        RenderError::Threads { threads, reason }
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
        let half = if setup.is_halved() { cells * film::BYTES_OF_HALF } else { 0 };
        // The sums, and what they carried.
        let film = 2 * cells * histogram::BYTES_OF_CELL + half;
        let filtering = match setup.filter {
            Filter::None => pixels * size_of::<[f32; 8]>() as u64,
            // The picture with its noise and their powers, of all levels.
            Filter::Variance => 2 * pixels * size_of::<[f32; 8]>() as u64 * 4 / 3,
            // Light, its logarithms and what they are spread to.
            Filter::Flam3 => 3 * cells * size_of::<[f32; 4]>() as u64,
        };
        let picture = pixels * size_of::<[f32; 3]>() as u64;
        let bytes_per_thread = Bins::bytes(cells as usize) + pool::BYTES;
        let drawing = picture + film + filtering + bytes_per_thread;
        Ok(FrameCost {
            samples: setup.target.map_or(2 * setup.shot.again(setup.samples.div_ceil(2), 0).samples(), Target::most),
            cell_steps: setup.cell_steps,
            bytes: setup.shot.bytes() + drawing + setup.preparing,
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
        let filter = if genome.sampling.estimator_radius > 0.0 { settings.filter } else { Filter::None };
        let target = settings.psnr.map(|psnr| Target::new(psnr, &view)).transpose()?;
        let fits = target.is_none() || filter != Filter::Flam3;
        in_range("psnr", settings.psnr.unwrap_or_default(), fits, NOT_FLAM3)?;
        let cell_steps = view.cell_steps(&genome.sampling, samples, filter)?;
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
        // The compiled genomes are copied once.
        let moments = genomes.iter().map(|(genome, view)| genome.bytes() + size_of_val(view) as u64);
        let preparing = moments.sum::<u64>() + shot.bytes();
        let arithmetic = if view.is_deep() { Arithmetic::Reference } else { settings.arithmetic };
        Ok(FrameSetup { genome, view, shot, samples, cell_steps, filter, target, arithmetic, preparing })
    }

    /// Whether halves of the samples are told apart.
    fn is_halved(&self) -> bool {
        self.filter == Filter::Variance || self.target.is_some()
    }

    /// Draws the frame by `backend`, or on the threads of the current pool.
    fn draw(&self, backend: &Backend, stop: &AtomicBool) -> Result<Measured, RenderError> {
        let [width, height] = self.view.cells;
        let mut film = Film::new(width * height, self.is_halved());
        let (mut asked, mut more) = (0, self.target.map_or(self.samples, Target::first));
        loop {
            film.expose(&self.shot, more, backend, self.arithmetic, stop)?;
            asked += more;
            let kept = film.samples() as f64;
            let lost = (asked as f64 - kept).max(0.0) * self.genome.finish.lost_samples;
            let share = (kept + lost) / self.samples as f64;
            let developed = tonemap::develop(&mut film, self, share, stop);
            if stop.load(Ordering::Relaxed) {
                return Err(RenderError::Stopped);
            }
            more = self.target.zip(developed.noise).map_or(0, |(target, noise)| target.next(asked, noise));
            if more == 0 {
                let psnr = developed.noise.map(Target::psnr);
                return Ok(Measured { image: developed.image, samples: film.samples(), psnr });
            }
        }
    }
}

impl Settings {
    fn apply_to(&self, genome: &mut Genome) {
        let Genome { camera, sampling, .. } = genome;
        if let Some(size) = self.size {
            *camera = camera.resized(size);
        }
        // How many samples a target takes does not depend on how many the genome asks for, at any zoom.
        sampling.quality = self.psnr.map_or(self.spp.unwrap_or(sampling.quality), |_| libm::exp2(-2.0 * camera.zoom));
        sampling.supersample = self.supersample.unwrap_or(sampling.supersample);
        sampling.temporal_samples = self.temporal_samples.unwrap_or(sampling.temporal_samples);
    }
}

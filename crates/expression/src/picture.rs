//! From a motion and a moment to a picture.
//!
//! Owns the order of the work, the threads, and what a frame costs, which is known before it is drawn. Never knows what a
//! function means: a frame is four tapes (`lower.rs`, `tape.rs`), one for each moment of the shutter, run over tiles
//! (`tile.rs`).
//!
//! Start at [`Renderer::render`].

use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use rayon::{ThreadPool, ThreadPoolBuilder};
use species::Image;

use crate::error::ExpressionError;
use crate::genome::Genome;
use crate::graph::Graph;
use crate::lower::lowered;
use crate::motion::{Loop, Motion};
use crate::sampling::{MOMENTS, shutter};
use crate::tape::{Registers, Tape};
use crate::tile::{Frame, Samples, Tile};

/// The most pixels along a side.
const LARGEST: u32 = 16_384;
/// The most nanoseconds a sample.
pub const MOST_NS: f32 = 1000.0;

/// How large and how good a picture is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Width and height in pixels, `1..=16384`.
    pub size: [u32; 2],
    /// Samples of a pixel.
    pub samples: Samples,
}

/// What a frame costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost {
    /// Nanoseconds a sample on one core, by the table of `kernels`.
    pub ns_per_sample: f32,
    /// The least and the most samples of the frame.
    pub samples: [u64; 2],
    /// Bytes of the picture, while its tiles are put together.
    pub bytes: u64,
    /// Bytes that each thread needs.
    pub bytes_per_thread: u64,
}

/// Threads to draw with.
#[derive(Debug)]
pub struct Renderer {
    pool: ThreadPool,
}

impl Renderer {
    /// A renderer with `threads` threads of its own; 0 takes as many as there are cores.
    ///
    /// # Errors
    /// [`ExpressionError::Threads`] if the system refuses them.
    pub fn new(threads: usize) -> Result<Renderer, ExpressionError> {
        let pool = ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|error| ExpressionError::Threads { threads, reason: error.to_string() })?;
        Ok(Renderer { pool })
    }

    /// The picture at `frame`; fractions lie between frames.
    ///
    /// # Errors
    /// [`ExpressionError::Size`] and [`ExpressionError::Slow`].
    pub fn render(&self, motion: &dyn Motion, frame: f64, settings: &Settings) -> Result<Image, ExpressionError> {
        Ok(self.render_counted(motion, frame, settings)?.0)
    }

    /// The picture at `frame`, and the samples that it took.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn render_counted(
        &self,
        motion: &dyn Motion,
        frame: f64,
        settings: &Settings,
    ) -> Result<(Image, u64), ExpressionError> {
        let tapes = tapes(motion, frame, settings)?;
        let [width, height] = settings.size.map(|side| side as usize);
        let frame = Frame { width, height, map: motion.map(frame), samples: settings.samples };
        let tiles = frame.tiles();
        let registers = || tapes.iter().map(Tape::registers).collect::<Vec<Registers>>();
        let draw = |registers: &mut Vec<Registers>, tile: &Tile| tile.draw(&frame, &tapes, registers);
        let drawn: Vec<(Vec<[f32; 3]>, u64)> =
            self.pool.install(|| tiles.par_iter().map_init(registers, draw).collect());
        let mut pixels = vec![[0.0; 3]; width * height];
        let samples = drawn.iter().map(|(_, samples)| samples).sum();
        for (tile, (drawn, _)) in tiles.iter().zip(drawn) {
            for (row, line) in drawn.chunks(tile.width).enumerate() {
                let start = (tile.top + row) * width + tile.left;
                pixels[start..start + tile.width].copy_from_slice(line);
            }
        }
        Ok((Image { width, height, pixels }, samples))
    }
}

impl Genome {
    /// Nanoseconds a sample of its loop, by the table of `kernels`.
    ///
    /// # Errors
    /// [`ExpressionError::Slow`] if that is more than may be.
    pub fn ns_per_sample(&self) -> Result<f32, ExpressionError> {
        let sketch = Settings { size: [1; 2], samples: Samples::One };
        Ok(cost(&Loop::new(self, 1.0), 0.0, &sketch)?.ns_per_sample)
    }
}

/// What the picture at `frame` costs.
///
/// # Errors
/// As [`Renderer::render`], which this tells before anything is drawn.
pub fn cost(motion: &dyn Motion, frame: f64, settings: &Settings) -> Result<Cost, ExpressionError> {
    let tapes = tapes(motion, frame, settings)?;
    let pixels = settings.size.map(u64::from).iter().product::<u64>();
    Ok(Cost {
        ns_per_sample: tapes.iter().map(Tape::ns).sum::<f32>() / tapes.len() as f32,
        samples: settings.samples.range().map(|samples| samples * pixels),
        bytes: 2 * pixels * size_of::<[f32; 3]>() as u64,
        bytes_per_thread: tapes.iter().map(Tape::bytes).sum::<usize>() as u64 + Tile::BYTES,
    })
}

/// A tape for each moment of the shutter.
fn tapes(motion: &dyn Motion, frame: f64, settings: &Settings) -> Result<Vec<Tape>, ExpressionError> {
    let [width, height] = settings.size;
    if settings.size.iter().any(|side| !(1..=LARGEST).contains(side)) {
        return Err(ExpressionError::Size { width, height, most: LARGEST });
    }
    let scale = motion.map(frame).scale;
    let shutters: Vec<f64> =
        if settings.samples == Samples::One { vec![0.0] } else { (0..MOMENTS).map(shutter).collect() };
    let tape = |shutter: f64| {
        let (mut graph, at) = Graph::new();
        let colours = lowered(&motion.still(frame, shutter), scale, &mut graph, at);
        let tape = Tape::of(&graph, colours);
        let is_slow = graph.is_full() || tape.ns() > MOST_NS;
        if is_slow { Err(ExpressionError::Slow { most_ns: MOST_NS }) } else { Ok(tape) }
    };
    shutters.into_iter().map(tape).collect()
}

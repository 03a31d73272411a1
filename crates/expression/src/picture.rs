//! From what is moving and a moment to a picture.
//!
//! Owns the order of the work, and what a frame costs, which is known before it is drawn. Never knows what a function means:
//! a frame is four tapes (`lower.rs`, `tape.rs`), one for each moment of the shutter, run over tiles (`tile.rs`).
//!
//! Start at [`render`].

use ::species::{Demand, Image, RenderError, Threads, shutter};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use crate::error::ExpressionError;
use crate::genome::Genome;
use crate::graph::Graph;
use crate::lower::lowered;
use crate::motion::{Loop, Moving};
use crate::sampling::MOMENTS;
use crate::tape::{Registers, Tape};
use crate::tile::{Frame, Moment, Samples, Tile};

/// The most pixels along a side.
const LARGEST: u32 = 16_384;
/// The most nanoseconds a sample.
pub const MOST_NS: f32 = 1000.0;
/// Bytes for the first frame's tables, which do not grow with it.
const TABLES: u64 = 64 << 10;

/// How large and how good a picture is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Width and height in pixels, `1..=16384`.
    pub size: [u32; 2],
    /// Samples of a pixel.
    pub samples: Samples,
    /// Whether samples lie at four moments, while the shutter is open, or at its middle. One sample always lies there.
    pub is_blurred: bool,
}

/// What a frame costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost {
    /// Nanoseconds a sample on one core, by the table of `kernels`.
    pub ns_per_sample: f32,
    /// The least and the most samples of the frame.
    pub samples: [u64; 2],
    /// Bytes of the picture while its tiles are put together, and of what is done for each of its samples.
    pub bytes: u64,
    /// Bytes that each thread needs.
    pub bytes_per_thread: u64,
}

/// What is done for each moment of the shutter, and the bytes that this takes, and took while it was found out.
struct Moments {
    moments: Vec<Moment>,
    bytes: u64,
}

/// The picture at `frame`, and the samples that it took; fractions lie between frames.
///
/// # Errors
/// [`RenderError::Refused`] where [`cost`] refuses, [`RenderError::Stopped`] if `threads` were told to stop.
pub fn render(
    moving: &dyn Moving,
    frame: f64,
    settings: &Settings,
    threads: &Threads,
) -> Result<(Image, u64), RenderError> {
    let moments = Moments::of(moving, frame, settings).map_err(|error| RenderError::Refused(error.into()))?.moments;
    let [width, height] = settings.size.map(|side| side as usize);
    let frame = Frame { width, height, samples: settings.samples };
    let tiles = frame.tiles();
    let registers = || moments.iter().map(|moment| moment.tape.registers()).collect::<Vec<Registers>>();
    let draw = |registers: &mut Vec<Registers>, tile: &Tile| {
        if threads.are_stopped() { None } else { Some(tile.draw(&frame, &moments, registers)) }
    };
    let drawn: Option<Vec<(Vec<[f32; 3]>, u64)>> = threads.run(|| tiles.par_iter().map_init(registers, draw).collect());
    let drawn = drawn.ok_or(RenderError::Stopped)?;
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

impl Genome {
    /// Nanoseconds a sample of its loop, by the table of `kernels`.
    ///
    /// # Errors
    /// [`ExpressionError::Slow`] if that is more than may be.
    pub fn ns_per_sample(&self) -> Result<f32, ExpressionError> {
        let sketch = Settings { size: [1; 2], samples: Samples::One, is_blurred: false };
        Ok(cost(&Loop::new(self, 1.0), 0.0, &sketch)?.ns_per_sample)
    }
}

/// What the picture at `frame` costs.
///
/// # Errors
/// [`ExpressionError::Size`] and [`ExpressionError::Slow`]; what passes here is drawn.
pub fn cost(moving: &dyn Moving, frame: f64, settings: &Settings) -> Result<Cost, ExpressionError> {
    let Moments { moments, bytes } = Moments::of(moving, frame, settings)?;
    let tapes = || moments.iter().map(|moment| &moment.tape);
    let pixels = settings.size.map(u64::from).iter().product::<u64>();
    let tiles: u64 = settings.size.map(|side| u64::from(side).div_ceil(Tile::SIDE)).iter().product();
    Ok(Cost {
        ns_per_sample: tapes().map(Tape::ns).sum::<f32>() / moments.len() as f32,
        samples: settings.samples.range().map(|samples| samples * pixels),
        bytes: 2 * pixels * size_of::<[f32; 3]>() as u64 + tiles * Tile::KEPT + bytes + TABLES,
        bytes_per_thread: tapes().map(Tape::bytes).sum::<usize>() as u64 + Tile::BYTES,
    })
}

impl Moments {
    fn of(moving: &dyn Moving, frame: f64, settings: &Settings) -> Result<Moments, ExpressionError> {
        let [width, height] = settings.size;
        if settings.size.iter().any(|side| !(1..=LARGEST).contains(side)) {
            return Err(ExpressionError::Size { width, height, most: LARGEST });
        }
        let is_blurred = settings.is_blurred && settings.samples != Samples::One;
        let shutters: Vec<f64> = if is_blurred {
            (0..MOMENTS).map(|moment| shutter(moment as u32, MOMENTS as u32)).collect()
        } else {
            vec![0.0]
        };
        let mut all = Moments { moments: Vec::with_capacity(shutters.len()), bytes: 0 };
        let mut most: u64 = 0;
        for shutter in shutters {
            let (mut graph, at) = Graph::new();
            let still = moving.still(frame, shutter);
            let view = moving.view(frame, shutter);
            let colours = lowered(&still, view.scale, &mut graph, at);
            let tape = Tape::of(&graph, colours);
            if graph.is_full() || tape.ns() > MOST_NS {
                return Err(ExpressionError::Slow { most_ns: MOST_NS });
            }
            most = most.max(still.bytes() + graph.bytes());
            all.bytes += tape.own_bytes();
            all.moments.push(Moment { tape, view });
        }
        all.bytes += most;
        Ok(all)
    }
}

impl From<Cost> for Demand {
    fn from(cost: Cost) -> Demand {
        let Cost { samples: [_, samples], bytes, bytes_per_thread, .. } = cost;
        // What one thread needs is needed always.
        Demand { samples, bytes: bytes + bytes_per_thread, bytes_per_thread }
    }
}

//! The camera: which histogram cell a point falls into.
//!
//! Owns the size of the histogram, with the rim that the spatial filter needs, and the mapping to it. Never
//! iterates and never filters.
//!
//! Start at [`View::new`].

use super::filter::{Filter, Spatial};
use super::histogram::MAX_SAMPLES;
use super::{RenderError, wiener};
use crate::genome::{Affine, Genome, Sampling};

/// Most cells a histogram may have: 40 to 80 bytes each, as the filter asks for.
const MAX_CELLS: f64 = 1e9;

/// Rows of pixels that are made together: what they have in common of the cells is looked at once.
pub(super) const BAND: usize = 32;

/// Most cells that the spatial filter adds up in a frame, along rows and then along columns. At 4K, 4 cells a pixel and the
/// widest kernel of radius 1 it is 1.1e9; this many take half a minute.
const MAX_FILTERED: f64 = 2e10;

/// The part of a cell by which `f32` may miss it.
const PRECISION: f64 = 1.0 / 16.0;

/// Most cells that density estimation looks at in a frame. Radius 11 at 4K and 4 cells a pixel takes 1.1e12 if no cell has
/// two samples; this many take an hour or two.
const MAX_SMOOTHED: f64 = 2e12;

/// Widest density estimation in cells; flam3's kernels of every width up to here take 150 MB.
const WIDEST_ESTIMATE: f64 = 256.0;

/// Most samples of a pixel: their noise is a thousandth, below what a byte shows.
pub(super) const MAX_SAMPLES_PER_PIXEL: f64 = 1e6;

/// A camera, ready to place points.
#[derive(Clone, Debug)]
pub(crate) struct View {
    /// Pixels of the picture.
    pub(crate) size: [usize; 2],
    /// Cells of the histogram, rim included.
    pub(crate) cells: [usize; 2],
    /// Cells per pixel in each direction.
    pub(crate) supersample: usize,
    /// The spatial filter.
    pub(crate) spatial: Spatial,
    /// From a point to its place in cells.
    pub(crate) to_cells: Affine,
    /// Pixels per unit, zoom included.
    pixels_per_unit: f64,
    /// 2^zoom.
    magnification: f64,
    /// The point in the middle.
    center: [f64; 2],
}

impl View {
    /// Prepares the camera of `genome`.
    /// Errors: [`RenderError::Range`] where a size, a scale or the filter is out of range.
    pub(crate) fn new(genome: &Genome) -> Result<View, RenderError> {
        let camera = &genome.camera;
        let sampling = &genome.sampling;
        let scale_is_fine = camera.scale > 0.0 && camera.scale.is_finite();
        in_range("scale", camera.scale, scale_is_fine, "a finite number above 0")?;
        in_range("supersample", sampling.supersample.into(), (1..=64).contains(&sampling.supersample), "1 to 64")?;
        in_range("filter", sampling.filter_radius, (0.0..=64.0).contains(&sampling.filter_radius), "0 to 64 pixels")?;
        let supersample = sampling.supersample as usize;
        let spatial = Spatial::new(sampling.filter_shape, sampling.filter_radius, supersample);
        let pixels = f64::from(camera.size[0]) * f64::from(camera.size[1]);
        let rim = (spatial.width() - supersample) / 2;
        let cells = camera.size.map(|pixels| pixels as usize * supersample + 2 * rim);
        let count = cells[0] as f64 * cells[1] as f64;
        in_range("size", pixels, camera.size.iter().all(|side| *side > 0), "1 pixel or more")?;
        let (name, value) = if supersample > 1 { ("supersample", supersample as f64) } else { ("size", pixels) };
        in_range(name, value, count <= MAX_CELLS, "at most 1e9 histogram cells")?;
        let fits = filter_steps(camera.size.map(f64::from), &spatial, supersample) <= MAX_FILTERED;
        in_range("filter", sampling.filter_radius, fits, "a radius by which a frame adds up at most 2e10 cells")?;
        let magnification = libm::exp2(camera.zoom);
        let pixels_per_unit = camera.scale * magnification;
        let scale = pixels_per_unit * supersample as f64;
        let (sin, cos) = libm::sincos(camera.rotate.to_radians());
        let [x, y] = camera.center;
        let turned = Affine { a: scale * cos, b: -scale * sin, c: 0.0, d: scale * sin, e: scale * cos, f: 0.0 };
        let (turned_x, turned_y) = turned.apply(x, y);
        let middle = |turned: f64, still: f64| turned * camera.center_turns + still * (1.0 - camera.center_turns);
        let (across, down) = (middle(turned_x, scale * x), middle(turned_y, scale * y));
        let to_cells = Affine { c: cells[0] as f64 / 2.0 - across, f: cells[1] as f64 / 2.0 - down, ..turned };
        let size = camera.size.map(|pixels| pixels as usize);
        Ok(View { size, cells, supersample, spatial, to_cells, pixels_per_unit, magnification, center: camera.center })
    }

    /// How many samples a frame of this view takes.
    /// Errors: [`RenderError::Range`] where there are none, or more than [`MAX_SAMPLES`].
    pub(crate) fn samples(&self, genome: &Genome) -> Result<u64, RenderError> {
        let each = self.samples_per_pixel(&genome.sampling);
        let samples = (each * (self.size[0] * self.size[1]) as f64).ceil();
        let fits = each <= MAX_SAMPLES_PER_PIXEL && (1.0..=MAX_SAMPLES).contains(&samples);
        let zoomed = genome.camera.zoom.abs() > genome.sampling.quality.log2().abs() / 2.0;
        let (name, value) = if zoomed { ("zoom", genome.camera.zoom) } else { ("quality", genome.sampling.quality) };
        in_range(name, value, fits, "quality * 4^zoom of at most 1e6 in a pixel, and 1 to 1e12 samples in a frame")?;
        Ok(samples as u64)
    }

    /// How many cells filters look at, if so many `samples` lie as thinly as they can.
    /// Errors: [`RenderError::Range`] where density estimation is too wide, or looks at more than [`MAX_SMOOTHED`].
    pub(crate) fn cell_steps(&self, sampling: &Sampling, samples: u64, smoothing: Filter) -> Result<u64, RenderError> {
        let size = self.size.map(|side| side as f64);
        let filtered = filter_steps(size, &self.spatial, self.supersample) as u64;
        match smoothing {
            Filter::None => return Ok(filtered),
            Filter::Variance => return Ok(filtered + (size[0] * size[1]) as u64 * wiener::STEPS_OF_PIXEL),
            Filter::Flam3 => {}
        }
        let reach = (sampling.estimator_radius * self.supersample as f64).ceil() + 1.0;
        let side = |cells: usize| (2.0 * reach + 1.0).min(cells as f64);
        let [width, height] = self.cells;
        let all = (width * height) as f64;
        // Each cell first looks for samples around it, then each lit one at all that are within reach.
        let around = ((self.supersample + 1) * (self.supersample + 1)) as f64;
        let smoothed = all * around.max(9.0) + all.min(samples as f64) * side(width) * side(height);
        let fits = reach <= WIDEST_ESTIMATE + 1.0 && smoothed <= MAX_SMOOTHED;
        let expected = "a radius of at most 256 cells, by which a frame looks at most at 2e12 cells";
        in_range("estimator_radius", sampling.estimator_radius, fits, expected)?;
        Ok(filtered + smoothed as u64)
    }

    /// Samples per pixel, zoom included.
    pub(crate) fn samples_per_pixel(&self, sampling: &Sampling) -> f64 {
        sampling.quality * self.magnification * self.magnification
    }

    /// Whether cells are so small that `f32` does not tell points of neighbouring cells apart.
    pub(crate) fn is_deep(&self) -> bool {
        let far = self.center.iter().fold(1.0_f64, |far, axis| far.max(axis.abs()));
        let scale = self.pixels_per_unit * self.supersample as f64;
        far * scale * f64::from(f32::EPSILON) > PRECISION
    }

    /// What the picture covers, in square units.
    pub(crate) fn area(&self) -> f64 {
        (self.size[0] * self.size[1]) as f64 / (self.pixels_per_unit * self.pixels_per_unit)
    }
}

/// How many cells the spatial filter adds up for a picture of `size`.
fn filter_steps([width, height]: [f64; 2], spatial: &Spatial, supersample: usize) -> f64 {
    let (taps, each) = (spatial.width() as f64, supersample as f64);
    // Bands overlap by a filter's width.
    let rows = height * each + (height / BAND as f64).ceil() * taps;
    width * (rows + height) * taps
}

/// Refuses `value` unless `holds`.
pub(crate) fn in_range(name: &'static str, value: f64, holds: bool, expected: &'static str) -> Result<(), RenderError> {
    if holds { Ok(()) } else { Err(RenderError::Range { name, value, expected }) }
}

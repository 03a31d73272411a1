//! The camera: which histogram cell a point falls into.
//!
//! Owns the size of the histogram, with the rim that the spatial filter needs, and the mapping to it. Never
//! iterates and never filters.
//!
//! Start at [`View::new`].

use super::RenderError;
use super::filter::Spatial;
use crate::genome::{Affine, Genome, Sampling};

/// Most cells a histogram may have: 48 bytes each.
const MAX_CELLS: f64 = 1e9;

/// Widest spatial filter, in cells: each pixel looks at all of them, in both directions.
const WIDEST_FILTER: usize = 1024;

/// Most samples of a frame: a year of a hundred cores. No sum of a cell overflows before.
const MAX_SAMPLES: f64 = 1e15;

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
        let wide = spatial.width();
        in_range("filter", wide as f64, wide <= WIDEST_FILTER, "a radius and a supersample of at most 1024 cells")?;
        let rim = (spatial.width() - supersample) / 2;
        let cells = camera.size.map(|pixels| pixels as usize * supersample + 2 * rim);
        let count = cells[0] as f64 * cells[1] as f64;
        in_range("size", count, camera.size.iter().all(|side| *side > 0) && count <= MAX_CELLS, "1 to 1e9 cells")?;
        let magnification = camera.zoom.exp2();
        let pixels_per_unit = camera.scale * magnification;
        let scale = pixels_per_unit * supersample as f64;
        let (sin, cos) = camera.rotate.to_radians().sin_cos();
        let [x, y] = camera.center;
        let turned = Affine { a: scale * cos, b: -scale * sin, c: 0.0, d: scale * sin, e: scale * cos, f: 0.0 };
        let (across, down) = turned.apply(x, y);
        let to_cells = Affine { c: cells[0] as f64 / 2.0 - across, f: cells[1] as f64 / 2.0 - down, ..turned };
        let size = camera.size.map(|pixels| pixels as usize);
        Ok(View { size, cells, supersample, spatial, to_cells, pixels_per_unit, magnification })
    }

    /// How many samples a frame of this view takes.
    /// Errors: [`RenderError::Range`] where there are none, or more than [`MAX_SAMPLES`].
    pub(crate) fn samples(&self, sampling: &Sampling) -> Result<u64, RenderError> {
        let samples = (self.samples_per_pixel(sampling) * (self.size[0] * self.size[1]) as f64).ceil();
        in_range("samples", samples, (1.0..=MAX_SAMPLES).contains(&samples), "1 to 1e15 in a frame")?;
        Ok(samples as u64)
    }

    /// Samples per pixel, zoom included.
    pub(crate) fn samples_per_pixel(&self, sampling: &Sampling) -> f64 {
        sampling.quality * self.magnification * self.magnification
    }

    /// What the picture covers, in square units.
    pub(crate) fn area(&self) -> f64 {
        (self.size[0] * self.size[1]) as f64 / (self.pixels_per_unit * self.pixels_per_unit)
    }
}

/// Refuses `value` unless `holds`.
pub(crate) fn in_range(name: &'static str, value: f64, holds: bool, expected: &'static str) -> Result<(), RenderError> {
    if holds { Ok(()) } else { Err(RenderError::Range { name, value, expected }) }
}

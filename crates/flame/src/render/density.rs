//! From cells to pixels: log-density, and the spatial filter.
//!
//! Owns the logarithm of densities and the convolution, by rows and then by columns. Works on any number of channels, so
//! that a picture and its noise pass together. Never knows what the channels are for.
//!
//! Start at [`pixels`] and [`Scale`].

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::{IndexedParallelIterator, ParallelIterator, ParallelSliceMut};

use super::film::Film;
use super::histogram::{UNIT, written};
use super::view::{BAND, View};
use crate::genome::{Finish, Genome};

/// Log-density at `brightness` 1 and a density of e - 1.
const GAIN: f64 = 268.0 / 256.0;

/// What turns light of a cell into log-density; `THIN` if cells of few samples have light of their own.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale<const THIN: bool> {
    gain: f32,
    /// By which a density is 1 where samples lie evenly over a square unit.
    evenly: f32,
    /// Log-density of a cell without samples.
    thin: f32,
    /// By which a density is 1 where a pixel has one sample.
    hits: f32,
}

impl<const THIN: bool> Scale<THIN> {
    /// For a frame of `genome` of which `share` of its samples was drawn.
    pub(super) fn new(genome: &Genome, view: &View, share: f64) -> Self {
        let Finish { contrast, log_gain, low_density, .. } = genome.finish;
        let cells_per_pixel = (view.supersample * view.supersample) as f64;
        let drawn = view.samples_per_pixel(&genome.sampling) * share;
        let expected = view.area() * drawn * f64::from(UNIT);
        Scale {
            gain: (genome.tone.brightness * GAIN * log_gain * contrast) as f32,
            evenly: (cells_per_pixel / expected / contrast) as f32,
            thin: (low_density / (contrast * drawn)) as f32,
            hits: (cells_per_pixel / f64::from(UNIT)) as f32,
        }
    }

    /// By what the light of a cell of this `density` is multiplied, if a sample is worth `worth` of the usual.
    #[inline]
    fn of(self, density: f32, worth: f32) -> f32 {
        if density > 0.0 {
            let log = self.gain * ln_1p(density * worth * self.evenly);
            let thin = if THIN { self.thin / (1.0 + density * worth * self.hits) } else { 0.0 };
            (if THIN { log + thin } else { log }) / density
        } else {
            0.0
        }
    }

    /// The log-density of a cell.
    #[inline]
    pub(super) fn log(self, cell: [f32; 4]) -> [f32; 4] {
        let scale = self.of(cell[3], 1.0);
        cell.map(|light| light * scale)
    }

    /// The log-density of a cell by both its halves, and half of what they differ by: a noise as large as its own.
    #[inline]
    fn of_halves(self, [a, b]: [[f32; 4]; 2]) -> [f32; 8] {
        let both = a[3] + b[3];
        if both <= 0.0 {
            return [0.0; 8];
        }
        let (all, one, other) = (self.of(both, 1.0), self.of(a[3], 2.0), self.of(b[3], 2.0));
        let mut out = [0.0; 8];
        for channel in 0..4 {
            out[channel] = (a[channel] + b[channel]) * all;
            out[4 + channel] = 0.5 * (a[channel] * one - b[channel] * other);
        }
        out
    }
}

/// The log-density of each pixel, and its noise.
///
/// * `film` — one whose halves are told apart.
/// * Returns `[height][width][8]`: red, green, blue, density; then a noise as large as theirs.
pub(super) fn of_halves<const THIN: bool>(
    film: &Film,
    scale: Scale<THIN>,
    view: &View,
    stop: &AtomicBool,
) -> Vec<[f32; 8]> {
    let width = view.cells[0];
    pixels(view, stop, |row, out| {
        for (cell, out) in (row * width..).zip(out) {
            *out = scale.of_halves(film.halves_at(cell));
        }
    })
}

/// The log-density of each pixel: `[height][width][4]`.
pub(super) fn of_film<const THIN: bool>(
    film: &Film,
    scale: Scale<THIN>,
    view: &View,
    stop: &AtomicBool,
) -> Vec<[f32; 4]> {
    let width = view.cells[0];
    pixels(view, stop, |row, out| {
        for (cell, out) in (row * width..).zip(out) {
            *out = scale.log(film.at(cell));
        }
    })
}

/// Pixels of a picture whose cells are known row by row, weighted by the spatial filter.
///
/// * `cells` — writes a row of cells, given its number.
/// * Returns `[height][width]`; anything, once `stop` is set.
pub(super) fn pixels<const CHANNELS: usize>(
    view: &View,
    stop: &AtomicBool,
    cells: impl Fn(usize, &mut [[f32; CHANNELS]]) + Sync,
) -> Vec<[f32; CHANNELS]> {
    let ([width, height], each) = (view.size, view.supersample);
    let weights: Vec<f32> = view.spatial.weights().iter().map(|weight| *weight as f32).collect();
    let mut pixels = written(width * height, [0.0; CHANNELS]);
    pixels.par_chunks_mut(width * BAND).enumerate().for_each(|(band, pixels)| {
        let mut line = vec![[0.0; CHANNELS]; view.cells[0]];
        let mut narrow = vec![[0.0; CHANNELS]; width];
        let rows = pixels.len() / width;
        for row in 0..(rows - 1) * each + weights.len() {
            if stop.load(Ordering::Relaxed) {
                return;
            }
            cells(band * BAND * each + row, &mut line);
            for (column, sum) in narrow.iter_mut().enumerate() {
                *sum = weighted(&line[column * each..], &weights);
            }
            // The pixels that this row of cells counts in.
            let first = (row + 1).saturating_sub(weights.len()).div_ceil(each);
            for to in first..=(row / each).min(rows - 1) {
                let weight = weights[row - to * each];
                for (sum, part) in pixels[to * width..(to + 1) * width].iter_mut().zip(&narrow) {
                    for (sum, part) in sum.iter_mut().zip(part) {
                        *sum += weight * part;
                    }
                }
            }
        }
    });
    pixels
}

/// The sum of the first of `cells`, by their weights.
#[inline]
fn weighted<const CHANNELS: usize>(cells: &[[f32; CHANNELS]], weights: &[f32]) -> [f32; CHANNELS] {
    let mut sum = [0.0; CHANNELS];
    for (cell, weight) in cells.iter().zip(weights) {
        for (sum, light) in sum.iter_mut().zip(cell) {
            *sum += weight * light;
        }
    }
    sum
}

/// The natural logarithm of `1 + x`, to 3e-7 of it, for `x` from 0 on.
///
/// # Source
/// The series of the inverse hyperbolic tangent; what `1 + x` loses by rounding is added as Kahan does.
#[inline]
fn ln_1p(x: f32) -> f32 {
    // Beyond it lies infinity.
    let x = x.min(1e38);
    let y = 1.0 + x;
    let lost = (x - (y - 1.0)) / y;
    // Between the roots of 1/2 and of 2.
    let exponent = (y.to_bits() - 0x3f35_04f3) as i32 >> 23;
    let part = f32::from_bits(y.to_bits().wrapping_sub((exponent << 23) as u32));
    let slope = (part - 1.0) / (part + 1.0);
    let square = slope * slope;
    let series = 1.0 + square * (1.0 / 3.0 + square * (0.2 + square * (1.0 / 7.0 + square * (1.0 / 9.0))));
    exponent as f32 * std::f32::consts::LN_2 + (2.0 * slope * series + lost)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_logarithm_is_right_from_the_darkest_to_the_brightest() {
        let mut x = 1e-30_f32;
        while x < 1e37 {
            let truth = libm::log1p(f64::from(x));
            let error = (f64::from(ln_1p(x)) / truth - 1.0).abs();
            assert!(error < 3e-7, "{x}: {error}");
            x *= 1.037;
        }
        assert_eq!(ln_1p(0.0), 0.0);
        assert!(ln_1p(f32::INFINITY).is_finite());
    }
}

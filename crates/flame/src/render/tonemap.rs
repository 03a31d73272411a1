//! From a histogram to displayable light.
//!
//! Owns log-density, spatial filtering, gamma, vibrancy and highlights. Never draws samples.
//!
//! Start at [`tone_map`].
//!
//! # Source
//! Draves & Reckase, *The Fractal Flame Algorithm* (2008), log-density display, gamma, vibrancy. The constants
//! are those that make `brightness` mean what it means in flam3 files, found by comparing pictures.

use rayon::prelude::{IndexedParallelIterator, ParallelIterator, ParallelSliceMut};

use super::Filter;
use super::estimator;
use super::histogram::UNIT;
use super::spread::Spread;
use super::view::View;
use crate::genome::palette::{from_hsv, to_hsv};
use crate::genome::{Genome, Tone};
use crate::image::Image;

/// Log-density at `brightness` 1 and a density of e - 1.
const GAIN: f64 = 268.0 / 256.0;

/// Full light in flam3's own scale of 256 steps to a byte's 255.
const WHITE: f64 = 256.0 / 255.0;

/// Tone-maps a histogram to displayable light.
///
/// * `cells` — `[height][width][4]` of `view.cells`: linear red, green, blue and density.
/// * `share` — how many samples were drawn, as a part of those that the genome asks for.
/// * `smoothing` — how noise is smoothed, where the genome's estimator has a radius.
pub(crate) fn tone_map(mut cells: Vec<[f32; 4]>, view: &View, genome: &Genome, share: f64, smoothing: Filter) -> Image {
    let cells_per_pixel = (view.supersample * view.supersample) as f64;
    let expected = view.area() * view.samples_per_pixel(&genome.sampling) * share * f64::from(UNIT);
    let gain = genome.tone.brightness * GAIN;
    let smoothing = if genome.sampling.estimator_radius > 0.0 { smoothing } else { Filter::None };
    if smoothing == Filter::Variance {
        cells = estimator::smooth(&cells, view, &genome.sampling);
    }
    let kernels = (smoothing == Filter::Flam3).then(|| Spread::new(&cells, view, &genome.sampling));
    cells.par_chunks_mut(view.cells[0]).flatten().filter(|cell| cell[3] > 0.0).for_each(|cell| {
        let density = f64::from(cell[3]);
        let scale = gain * libm::log1p(density * cells_per_pixel / expected) / density;
        *cell = cell.map(|channel| (f64::from(channel) * scale) as f32);
    });
    if let Some(spread) = kernels {
        cells = spread.apply(&cells);
    }
    let [width, height] = view.size;
    let mut pixels = vec![[0.0; 3]; width * height];
    pixels.par_chunks_mut(width).enumerate().for_each(|(row, pixels)| {
        for (column, pixel) in pixels.iter_mut().enumerate() {
            *pixel = expose(filtered(&cells, view, column, row), &genome.tone);
        }
    });
    Image { width, height, pixels }
}

/// The log-density of a pixel: the cells around it, weighted by the spatial filter.
fn filtered(logs: &[[f32; 4]], view: &View, column: usize, row: usize) -> [f64; 4] {
    let weights = view.spatial.weights();
    let mut sum = [0.0; 4];
    for (down, outer) in weights.iter().enumerate() {
        let start = (row * view.supersample + down) * view.cells[0] + column * view.supersample;
        for (cell, inner) in logs[start..start + weights.len()].iter().zip(weights) {
            for (sum, channel) in sum.iter_mut().zip(cell) {
                *sum += outer * inner * f64::from(*channel);
            }
        }
    }
    sum
}

/// Gamma, vibrancy, highlights and background of one pixel.
fn expose([red, green, blue, density]: [f64; 4], tone: &Tone) -> [f32; 3] {
    let power = 1.0 / tone.gamma;
    let alpha = if density > 0.0 { opacity(density, power, tone.gamma_threshold) } else { 0.0 };
    let vivid = if density > 0.0 { tone.vibrancy * WHITE * alpha / density } else { 0.0 };
    let covered = alpha.clamp(0.0, 1.0);
    let lit = highlights([red, green, blue], vivid, tone.highlight_power);
    std::array::from_fn(|i| {
        let plain = libm::pow([red, green, blue][i].max(0.0), power);
        let value = lit[i] + (1.0 - tone.vibrancy) * WHITE * plain + (1.0 - covered) * tone.background[i];
        // NaN, from an extreme gamma or brightness, is shown as black.
        if value > 0.0 { value.min(1.0) as f32 } else { 0.0 }
    })
}

/// Gamma with a straight beginning, so that single hits in the dark do not glare.
fn opacity(density: f64, power: f64, threshold: f64) -> f64 {
    let curve = libm::pow(density, power);
    if density >= threshold {
        return curve;
    }
    let part = density / threshold;
    (1.0 - part) * density * libm::pow(threshold, power) / threshold + part * curve
}

/// Scales a colour by `scale`; values above white are clamped, fading to white by `highlight_power`.
fn highlights(colour: [f64; 3], scale: f64, highlight_power: f64) -> [f64; 3] {
    let brightest = colour[0].max(colour[1]).max(colour[2]);
    if scale == 0.0 || brightest <= 0.0 {
        return [0.0; 3];
    }
    let held = 1.0 / brightest;
    if scale <= held {
        return colour.map(|channel| channel * scale);
    }
    if highlight_power >= 0.0 {
        let [hue, saturation, value] = to_hsv(colour.map(|channel| channel * held));
        return from_hsv([hue, saturation * libm::pow(held / scale, highlight_power), value]);
    }
    let clipped = (-highlight_power).min(1.0);
    colour.map(|channel| channel * ((1.0 - clipped) * held + clipped * scale))
}

//! The noise filter: what halves of the samples agree on stays, what they differ by goes.
//!
//! Owns a pyramid of the picture and of its noise, and the shares of its levels that are kept. Where noise is small
//! against the picture all is kept, so that the filter vanishes as samples grow. Never knows how noise was measured:
//! `density.rs` brings it.
//!
//! Start at [`denoise`].
//!
//! # Source
//! Burt & Adelson, *The Laplacian pyramid as a compact image code* (1983); the share of a level is that of Wiener's
//! filter, with local variances.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::{IndexedParallelIterator, ParallelIterator, ParallelSliceMut};

/// A pixel: red, green, blue, density; then a noise as large as theirs.
pub(super) type Pixel = [f32; 8];

/// Most levels of the pyramid: the coarsest is left as it is.
const LEVELS: usize = 6;

/// No level is narrower than this.
const NARROWEST: usize = 8;

/// Weights of a window in which variances are measured, from its middle to its rim.
const WINDOW: [f32; 4] = [0.25, 0.2, 0.12, 0.055];

/// Density from which on noise is less visible.
const DARK: f32 = 0.03;

/// How much noise counts for. Measured on five genomes at 20 to 2600 samples per pixel: 1.7 loses 0.1 to 0.4 dB against 1.
const CAUTION: f32 = 1.1;

/// How much the other channels' powers count for beside a channel's own: measured to be best at few samples.
const OTHERS: f32 = 0.3;

/// Pixels that are looked at for each of the picture: making all levels, subtracting, measuring and adding them.
pub(super) const STEPS_OF_PIXEL: u64 = 40;

/// Pixels in rows, one after the other.
struct Level {
    width: usize,
    height: usize,
    pixels: Vec<Pixel>,
}

/// Filters `pixels` of `size`. Afterwards their noise is that which the filter left, and what it blurred.
/// Once `stop` is set the result may be anything.
pub(super) fn denoise(pixels: Vec<Pixel>, size: [usize; 2], stop: &AtomicBool) -> Vec<Pixel> {
    let mut levels = vec![Level { width: size[0], height: size[1], pixels }];
    let mut powers = Vec::new();
    while levels.len() < LEVELS {
        let finest = levels.last_mut().expect("there is one level at least");
        if finest.width.min(finest.height) < 2 * NARROWEST || stop.load(Ordering::Relaxed) {
            break;
        }
        let coarser = finest.reduced();
        powers.push(finest.subtract(&coarser));
        levels.push(coarser);
    }
    let mut coarser = levels.pop().expect("there is one level at least");
    for (mut level, powers) in levels.into_iter().zip(powers).rev() {
        if stop.load(Ordering::Relaxed) {
            break;
        }
        level.add(&coarser, &powers);
        coarser = level;
    }
    coarser.pixels
}

impl Level {
    fn row(&self, row: usize) -> &[Pixel] {
        &self.pixels[row * self.width..(row + 1) * self.width]
    }

    /// The same picture of half the size.
    fn reduced(&self) -> Level {
        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        let mut pixels = vec![[0.0; 8]; width * height];
        pixels.par_chunks_mut(width).enumerate().for_each(|(row, out)| {
            let mut sums = vec![[0.0; 8]; self.width];
            for (weight, from) in [0.0625, 0.25, 0.375, 0.25, 0.0625].into_iter().zip(0..) {
                add(&mut sums, self.row((2 * row + from).saturating_sub(2).min(self.height - 1)), weight);
            }
            let at = |column: usize| sums[column.saturating_sub(2).min(self.width - 1)];
            for (column, out) in out.iter_mut().enumerate() {
                let near = [0, 1, 2, 3, 4].map(|step| at(2 * column + step));
                for (channel, out) in out.iter_mut().enumerate() {
                    *out = 0.0625 * (near[0][channel] + near[4][channel])
                        + 0.25 * (near[1][channel] + near[3][channel])
                        + 0.375 * near[2][channel];
                }
            }
        });
        Level { width, height, pixels }
    }

    /// Row `row` of this picture at twice its size.
    fn expanded(&self, row: usize, out: &mut [Pixel]) {
        let mut sums = vec![[0.0; 8]; self.width];
        for (from, weight) in steps(row, self.height) {
            add(&mut sums, self.row(from), weight);
        }
        for (column, out) in out.iter_mut().enumerate() {
            *out = [0.0; 8];
            for (from, weight) in steps(column, self.width) {
                for (out, sum) in out.iter_mut().zip(sums[from]) {
                    *out += weight * sum;
                }
            }
        }
    }

    /// Leaves what `coarser` does not have. Returns the powers of that, picture and noise, around each pixel.
    fn subtract(&mut self, coarser: &Level) -> Vec<Pixel> {
        let width = self.width;
        let mut powers = vec![[0.0; 8]; self.pixels.len()];
        self.pixels.par_chunks_mut(width).zip(powers.par_chunks_mut(width)).enumerate().for_each(
            |(row, (own, out))| {
                let mut squares = vec![[0.0; 8]; width];
                coarser.expanded(row, &mut squares);
                for (own, square) in own.iter_mut().zip(&mut squares) {
                    let visible = visible(square[3]);
                    for (own, square) in own.iter_mut().zip(square) {
                        *own -= *square;
                        *square = visible * *own * *own;
                    }
                }
                averaged(&squares, out);
            },
        );
        powers
    }

    /// Adds `coarser` to the share of this level that is kept.
    fn add(&mut self, coarser: &Level, powers: &[Pixel]) {
        let (width, height) = (self.width, self.height);
        self.pixels.par_chunks_mut(width).enumerate().for_each(|(row, own)| {
            let mut around = vec![[0.0; 8]; width];
            let line = |row: usize| &powers[row * width..(row + 1) * width];
            add(&mut around, line(row), WINDOW[0]);
            for (step, weight) in (1..).zip(&WINDOW[1..]) {
                add(&mut around, line(row.saturating_sub(step)), *weight);
                add(&mut around, line((row + step).min(height - 1)), *weight);
            }
            let mut base = vec![[0.0; 8]; width];
            coarser.expanded(row, &mut base);
            for ((own, around), base) in own.iter_mut().zip(around).zip(base) {
                let power = with_others([around[0], around[1], around[2], around[3]]);
                let noise = with_others([around[4], around[5], around[6], around[7]]);
                for channel in 0..4 {
                    let (share, left) = share(power[channel], noise[channel]);
                    own[channel] = base[channel] + share * own[channel];
                    own[4 + channel] = base[4 + channel] + left * own[4 + channel];
                }
            }
        });
    }
}

/// The powers of all channels, each joined by the others.
#[inline]
fn with_others(powers: [f32; 4]) -> [f32; 4] {
    let all = OTHERS * (powers[0] + powers[1] + powers[2] + powers[3]);
    powers.map(|power| (1.0 - OTHERS) * power + all)
}

/// Which share of a level is kept where the picture with its noise has this `power` and the noise that; and the error that
/// is then left, in sizes of the noise: what is kept of the noise, and what is lost of the picture.
#[inline]
fn share(power: f32, noise: f32) -> (f32, f32) {
    if noise <= 0.0 {
        return (1.0, 1.0);
    }
    let share = (1.0 - CAUTION * noise / power).max(0.0);
    let lost = (1.0 - share) * (1.0 - share) * (power - noise).max(0.0) / noise;
    (share, (share * share + lost).sqrt())
}

/// How visible a change is beside the same change in another place, squared.
#[inline]
fn visible(density: f32) -> f32 {
    let light = density.max(0.0) + DARK;
    1.0 / (light * light.sqrt())
}

/// The places of the coarser level that place `at` lies between, with their weights.
#[inline]
fn steps(at: usize, length: usize) -> [(usize, f32); 3] {
    let middle = at / 2;
    let next = (middle + 1).min(length - 1);
    if at.is_multiple_of(2) {
        [(middle.saturating_sub(1), 0.125), (middle, 0.75), (next, 0.125)]
    } else {
        [(middle, 0.5), (next, 0.5), (middle, 0.0)]
    }
}

/// Adds `row`, weighted, to `sums`.
#[inline]
fn add(sums: &mut [Pixel], row: &[Pixel], weight: f32) {
    for (sum, pixel) in sums.iter_mut().zip(row) {
        for (sum, channel) in sum.iter_mut().zip(pixel) {
            *sum += weight * channel;
        }
    }
}

/// The means of `row` in windows along it.
fn averaged(row: &[Pixel], out: &mut [Pixel]) {
    let last = row.len() - 1;
    for (column, out) in out.iter_mut().enumerate() {
        let mut sum = row[column].map(|power| WINDOW[0] * power);
        for (step, weight) in (1..).zip(&WINDOW[1..]) {
            let (before, after) = (&row[column.saturating_sub(step)], &row[(column + step).min(last)]);
            for (channel, sum) in sum.iter_mut().enumerate() {
                *sum += weight * (before[channel] + after[channel]);
            }
        }
        *out = sum;
    }
}

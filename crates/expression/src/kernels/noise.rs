//! Noise on a lattice, points in cells, and numbers by chance, all from hashes of whole numbers.
//!
//! Owns the hash, and the third axis of the lattice, which is time: it has three layers and then the first again, so that
//! noise has an exact period. Never keeps a table.
//!
//! Start at [`noise`].
//!
//! # Source
//! The mixing steps are those of the public domain generators of Ellis and of Wellons (2018); fade after Perlin,
//! *Improving Noise* (2002).

use std::hash::{Hash, Hasher};

use crate::math::{cos, fade, settled, sin_of_turns, split};

/// Layers of the lattice in time.
const PERIOD: f64 = 3.0;
/// Positions on the lattice are cut off here.
const FAR: f32 = 2_097_152.0;
/// Multiplied with a hash that is taken as a signed number, it lies from -1 to 1.
const TO_UNIT: f32 = 1.0 / 2_147_483_648.0;
/// Tells rows from columns.
const ROW: u32 = 0x85eb_ca6b;
/// How much of noise is value; the rest is slope.
const VALUE: f32 = 0.35;

/// A moment, as noise sees it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Slice {
    /// Turns of time, `0.0..1.0`.
    turns: f64,
}

impl Slice {
    /// The slice after so many turns.
    #[inline(always)]
    pub(crate) fn at(turns: f64) -> Slice {
        Slice { turns: turns - turns.floor() }
    }

    /// The layers before and after, and how far the second one is blended in.
    #[inline(always)]
    fn layers(self) -> ([u32; 2], f32) {
        let time = PERIOD * self.turns;
        let before = time.floor();
        let layer = before as u32 % PERIOD as u32;
        ([layer, (layer + 1) % PERIOD as u32], fade((time - before) as f32))
    }
}

impl PartialEq for Slice {
    fn eq(&self, other: &Slice) -> bool {
        self.turns.to_bits() == other.turns.to_bits()
    }
}

impl Eq for Slice {}

impl Hash for Slice {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.turns.to_bits().hash(state);
    }
}

/// One step of mixing.
#[inline(always)]
fn mixed(bits: u32) -> u32 {
    let bits = (bits ^ (bits >> 16)).wrapping_mul(0x7feb_352d);
    bits ^ (bits >> 15)
}

/// A whole number from a seed, any of whose bits matters.
#[inline(always)]
fn seeded(seed: f32, salt: u32) -> u32 {
    mixed(seed.to_bits() ^ salt)
}

/// A place on the lattice.
#[inline(always)]
fn place(position: f32, size: f32) -> f32 {
    settled(position / size).clamp(-FAR, FAR)
}

#[inline(always)]
fn unit(bits: u32) -> f32 {
    bits as i32 as f32 * TO_UNIT
}

/// What a corner of the lattice contributes to a sample that is `x`, `y` away from it: a value and a slope.
#[inline(always)]
fn corner(sum: u32, x: f32, y: f32) -> f32 {
    let bits = mixed(sum);
    VALUE * unit(bits) + (1.0 - VALUE) * (unit(bits << 11) * x + unit(bits << 21) * y)
}

/// Noise of one of three channels from -1 to 1 with mean 0; of u, v, size and seed.
#[inline(always)]
pub(super) fn noise(channel: u8, slice: Slice, [u, v, size, seed]: [&[f32]; 4], out: &mut [f32]) {
    let (layers, blend) = slice.layers();
    let layers = layers.map(|layer| mixed(layer.wrapping_add(0x51_7cc1).wrapping_mul(0x9e37_79b9)));
    let salt = 0x68e3_1da4_u32.wrapping_mul(u32::from(channel) + 1);
    let (length, out) = (out.len(), out);
    let (u, v, size, seed) = (&u[..length], &v[..length], &size[..length], &seed[..length]);
    for at in 0..length {
        let (column, x) = split(place(u[at], size[at]));
        let (row, y) = split(place(v[at], size[at]));
        let columns = [mixed(column), mixed(column.wrapping_add(1))];
        let seed = seeded(seed[at], salt);
        let rows = [row, row.wrapping_add(1)].map(|row| mixed(row.wrapping_mul(ROW) ^ seed));
        let (across, up) = (fade(x), fade(y));
        let layer = |bits: u32| {
            let line = |row: u32, y: f32| {
                let left = corner(columns[0].wrapping_add(row).wrapping_add(bits), x, y);
                let right = corner(columns[1].wrapping_add(row).wrapping_add(bits), x - 1.0, y);
                left + (right - left) * across
            };
            let (low, high) = (line(rows[0], y), line(rows[1], y - 1.0));
            low + (high - low) * up
        };
        let (before, after) = (layer(layers[0]), layer(layers[1]));
        out[at] = spread(spread(before + (after - before) * blend));
    }
}

/// Spreads what lies mostly near 0 over -1 to 1, as smooth as it was.
#[inline(always)]
fn spread(value: f32) -> f32 {
    let z = value * value;
    value * (1.875 + z * (-1.25 + z * 0.375)) + 0.0
}

/// The distance to the nearest of points, one in every cell, that turn once in a turn, in sizes, at most 1; of u, v, size
/// and seed.
#[inline(always)]
pub(super) fn cell(slice: Slice, [u, v, size, seed]: [&[f32]; 4], out: &mut [f32]) {
    let (sine, cosine) = (sin_of_turns(slice.turns), cos(slice.turns as f32 * std::f32::consts::TAU));
    let (length, out) = (out.len(), out);
    let (u, v, size, seed) = (&u[..length], &v[..length], &size[..length], &seed[..length]);
    for at in 0..length {
        let (column, x) = split(place(u[at], size[at]));
        let (row, y) = split(place(v[at], size[at]));
        let seed = seeded(seed[at], 0x2545_f491);
        let mut nearest = 1.0_f32;
        for down in 0..3_u8 {
            let row = mixed(row.wrapping_add(u32::from(down)).wrapping_mul(ROW) ^ seed);
            for right in 0..3_u8 {
                let bits = mixed(mixed(column.wrapping_add(u32::from(right))).wrapping_add(row));
                // At most half a cell from the middle of its own.
                let (a, b) = (0.35 * unit(bits), 0.35 * unit(bits << 16));
                let across = f32::from(right) - 0.5 + a * cosine - b * sine - x;
                let up = f32::from(down) - 0.5 + a * sine + b * cosine - y;
                let distance = across * across + up * up;
                nearest = if distance < nearest { distance } else { nearest };
            }
        }
        out[at] = nearest.sqrt();
    }
}

/// A number from -1 to 1, by a seed and an index.
#[inline(always)]
pub(super) fn chance(index: u8, seed: &[f32], out: &mut [f32]) {
    let salt = 0x9e37_79b9_u32.wrapping_mul(u32::from(index) + 1);
    for (out, seed) in out.iter_mut().zip(seed) {
        *out = unit(mixed(seeded(*seed, salt))) + 0.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Noise on a grid of 64 by 64 samples, `step` sizes apart.
    fn field(channel: u8, turns: f64, seed: f32, step: f32) -> Vec<f32> {
        let mut out = vec![0.0; 64 * 64];
        let u: Vec<f32> = (0..out.len()).map(|at| (at % 64) as f32 * step).collect();
        let v: Vec<f32> = (0..out.len()).map(|at| (at / 64) as f32 * step).collect();
        let (size, seed) = (vec![1.0; out.len()], vec![seed; out.len()]);
        noise(channel, Slice::at(turns), [&u, &v, &size, &seed], &mut out);
        out
    }

    fn mean(of: &[f32]) -> f32 {
        of.iter().sum::<f32>() / of.len() as f32
    }

    #[test]
    fn noise_has_mean_zero_and_fills_the_range() {
        let fields: Vec<f32> =
            (0..40).flat_map(|seed| field(seed % 3, 0.13 * f64::from(seed), seed.into(), 0.73)).collect();
        let mean_square = mean(&fields.iter().map(|value| value * value).collect::<Vec<_>>());
        assert!(mean(&fields).abs() < 0.02 && (0.08..0.3).contains(&mean_square), "{} {mean_square}", mean(&fields));
        assert!(fields.iter().all(|value| value.abs() <= 1.0));
        assert!(fields.iter().any(|value| *value > 0.8) && fields.iter().any(|value| *value < -0.8));
    }

    #[test]
    fn a_seed_is_a_pattern_and_another_seed_channel_or_moment_is_another() {
        let correlation = |a: &[f32], b: &[f32]| {
            let product: Vec<f32> = a.iter().zip(b).map(|(a, b)| a * b).collect();
            let square = |of: &[f32]| mean(&of.iter().map(|value| value * value).collect::<Vec<_>>());
            mean(&product) / (square(a) * square(b)).sqrt()
        };
        let first = field(0, 0.0, 7.0, 0.73);
        assert_eq!(first, field(0, 0.0, 7.0, 0.73));
        for other in [field(0, 0.0, 8.0, 0.73), field(1, 0.0, 7.0, 0.73), field(0, 1.0 / 3.0, 7.0, 0.73)] {
            assert!(correlation(&first, &other).abs() < 0.08, "{}", correlation(&first, &other));
        }
    }

    #[test]
    fn noise_and_cells_are_continuous_in_place_and_over_the_seam_of_time() {
        // Three cells along each axis.
        let fine = field(0, 0.4, 3.0, 0.05);
        let jump = |from: usize, to: usize| (fine[to] - fine[from]).abs();
        let jumps = (0..63 * 64).map(|at| jump(at, at + 64).max(if at % 64 < 63 { jump(at, at + 1) } else { 0.0 }));
        let largest = jumps.fold(0.0, f32::max);
        assert!(largest < 0.3, "{largest}");
        let [before, after] = [-1e-4, 1e-4].map(|turns| field(0, turns, 3.0, 0.7));
        assert!(before.iter().zip(&after).all(|(before, after)| (before - after).abs() < 1e-3));
        let u: Vec<f32> = (0..4096).map(|at| at as f32 * 0.01).collect();
        let mut out = vec![0.0; u.len()];
        cell(Slice::at(0.3), [&u, &u, &vec![1.0; 4096], &vec![5.0; 4096]], &mut out);
        assert!(out.windows(2).all(|pair| (pair[1] - pair[0]).abs() < 0.016));
        assert!(out.iter().any(|distance| *distance < 0.2) && out.iter().any(|distance| *distance > 0.5));
    }

    #[test]
    fn one_turn_later_noise_is_the_same_to_the_bit() {
        assert_eq!(field(2, 0.25, 3.0, 0.7), field(2, 1.25, 3.0, 0.7));
        assert_eq!(Slice::at(3.0), Slice::at(0.0));
    }
}

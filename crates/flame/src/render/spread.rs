//! Density estimation as flam3 does it: every cell's light is spread by a kernel that narrows with its density.
//!
//! Owns the choice of kernels and the spreading. Kept for pictures that must look like flam3's; `wiener.rs` keeps
//! edges that this one blurs.
//!
//! Start at [`Spread::new`], before densities become logarithms; then [`Spread::apply`].
//!
//! # Source
//! Draves & Reckase, *The Fractal Flame Algorithm* (2008), density estimation; the meaning of radius, minimum and curve
//! as in flame files.

use rayon::prelude::{IndexedParallelIterator, ParallelIterator, ParallelSliceMut};

use super::histogram::UNIT;
use super::view::View;
use crate::genome::Sampling;

/// Up to this many samples every count has its own kernel; from there on counts a twentieth apart.
const FINE: usize = 100;
const STEP: f64 = 1.05;

/// The reach of the kernel's bell, in its widths.
const SUPPORT: f64 = 1.5;

/// What each cell is to be spread by.
pub(super) struct Spread {
    kernels: Vec<Kernel>,
    /// For each cell the number of its kernel.
    chosen: Vec<u16>,
    width: usize,
    height: usize,
}

/// A bell with a sharp rim.
struct Kernel {
    /// Cells from the middle to the rim.
    reach: usize,
    /// One quarter with the middle lines, `[reach + 1][reach + 1]`; all four sum to 1.
    weights: Vec<f32>,
}

impl Spread {
    /// Chooses a kernel for each of `cells`: `[height][width][4]` of `view.cells`, density last, in [`UNIT`]s.
    pub(super) fn new(cells: &[[f32; 4]], view: &View, sampling: &Sampling) -> Spread {
        let [width, height] = view.cells;
        let finest = view.supersample as f64;
        let widest = sampling.estimator_radius * finest + 1.0;
        let narrowest = (sampling.estimator_minimum.max(0.0) * finest + 1.0).min(widest);
        let mut counts: Vec<f64> = Vec::new();
        let mut kernels = Vec::new();
        let mut count = 1.0;
        while kernels.len() < usize::from(u16::MAX) {
            let radius = (widest / libm::pow(count, sampling.estimator_curve)).clamp(narrowest, widest);
            counts.push(count);
            kernels.push(Kernel::new(radius));
            if radius <= narrowest || count > 1e12 {
                break;
            }
            count = if counts.len() < FINE { count + 1.0 } else { (count * STEP).ceil() };
        }
        let number = |samples: f64| counts.partition_point(|count| *count <= samples).saturating_sub(1) as u16;
        let mut chosen = vec![0; cells.len()];
        chosen.par_chunks_mut(width).enumerate().for_each(|(row, chosen)| {
            for (column, chosen) in chosen.iter_mut().enumerate() {
                *chosen = number(samples(cells, view, column, row));
            }
        });
        Spread { kernels, chosen, width, height }
    }

    /// `cells`, each spread by its kernel. What falls over the rim is lost.
    pub(super) fn apply(&self, cells: &[[f32; 4]]) -> Vec<[f32; 4]> {
        let most = self.kernels.iter().map(|kernel| kernel.reach).max().unwrap_or(0);
        let mut out = vec![[0.0; 4]; cells.len()];
        out.par_chunks_mut(self.width).enumerate().for_each(|(row, out)| {
            for from in row.saturating_sub(most)..=(row + most).min(self.height - 1) {
                let line = from * self.width..(from + 1) * self.width;
                let sources = cells[line.clone()].iter().zip(&self.chosen[line]).enumerate();
                for (column, (cell, chosen)) in sources.filter(|(_, (cell, _))| cell[3] > 0.0) {
                    self.kernels[usize::from(*chosen)].add(out, column, row.abs_diff(from), cell);
                }
            }
        });
        out
    }
}

/// How many samples lie around a cell, as many cells taken as make a pixel.
fn samples(cells: &[[f32; 4]], view: &View, column: usize, row: usize) -> f64 {
    let [width, height] = view.cells;
    let reach = view.supersample / 2;
    let mut sum = 0.0;
    for down in row.saturating_sub(reach)..=(row + reach).min(height - 1) {
        for across in column.saturating_sub(reach)..=(column + reach).min(width - 1) {
            sum += f64::from(cells[down * width + across][3]);
        }
    }
    let window = (2 * reach + 1) as f64;
    let pixel = view.supersample as f64;
    sum / f64::from(UNIT) * (pixel * pixel) / (window * window)
}

impl Kernel {
    fn new(radius: f64) -> Kernel {
        let reach = radius.ceil().max(1.0) as usize - 1;
        let weight = |down: usize, across: usize| {
            let far = libm::hypot(down as f64, across as f64) / radius;
            if far <= 1.0 { libm::exp(-2.0 * (SUPPORT * far).powi(2)) } else { 0.0 }
        };
        let side = reach + 1;
        let mut weights = Vec::with_capacity(side * side);
        let mut sum = 0.0;
        for (down, across) in (0..side).flat_map(|down| (0..side).map(move |across| (down, across))) {
            let twice = |part: usize| if part == 0 { 1.0 } else { 2.0 };
            weights.push(weight(down, across));
            sum += weight(down, across) * twice(down) * twice(across);
        }
        Kernel { reach, weights: weights.iter().map(|weight| (weight / sum) as f32).collect() }
    }

    /// Adds what `cell`, in `column` of a row `down` away, gives to the row `out`.
    #[inline]
    fn add(&self, out: &mut [[f32; 4]], column: usize, down: usize, cell: &[f32; 4]) {
        if down > self.reach {
            return;
        }
        let line = &self.weights[down * (self.reach + 1)..(down + 1) * (self.reach + 1)];
        let first = column.saturating_sub(self.reach);
        let last = (column + self.reach).min(out.len() - 1);
        for (across, sum) in out[first..=last].iter_mut().enumerate() {
            let weight = line[(first + across).abs_diff(column)];
            for (sum, channel) in sum.iter_mut().zip(cell) {
                *sum += weight * channel;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kernel_keeps_all_light_and_reaches_its_radius() {
        for radius in [1.0, 1.3, 2.0, 7.9, 19.0] {
            let kernel = Kernel::new(radius);
            let mut rows = vec![vec![[0.0_f32; 4]; 41]; 41];
            for (row, out) in rows.iter_mut().enumerate() {
                kernel.add(out, 20, row.abs_diff(20), &[1.0; 4]);
            }
            let sum: f32 = rows.iter().flatten().map(|cell| cell[3]).sum();
            assert!((sum - 1.0).abs() < 1e-5, "radius {radius}: {sum}");
            assert!(kernel.reach as f64 <= radius && kernel.reach as f64 + 1.0 >= radius);
        }
        assert_eq!(Kernel::new(1.0).weights, [1.0]);
    }
}

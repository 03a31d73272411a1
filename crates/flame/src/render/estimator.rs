//! Density estimation: averaging over cells that differ by no more than chance.
//!
//! Owns the smoothing of a histogram that has few samples. Never blurs what is known: the window shrinks to one
//! cell where there are many samples, and a cell beyond an edge of density or colour hardly counts in it.
//!
//! Start at [`smooth`].
//!
//! # Source
//! The radius shrinks with density as in Suykens & Willems, *Adaptive filtering for progressive Monte Carlo image
//! rendering* (2000), and in flame files; the weights follow Lee, *Digital image smoothing and the sigma filter*
//! (1983), with the variance of counted samples for its sigma.

use rayon::prelude::{IndexedParallelIterator, ParallelIterator, ParallelSliceMut};

use super::histogram::UNIT;
use super::view::View;
use crate::genome::Sampling;

/// What is left of the variance of a cell's count after averaging by 1-2-1 in both directions: (6/16)².
const GUIDE_VARIANCE: f32 = 0.140_625;

/// Variance of one sample's colour, over three channels in units of full light: a palette's middling contrast.
const COLOUR_VARIANCE: f32 = 0.1;

/// The same light, spread over cells that differ by chance only.
///
/// * `cells` — `[height][width][4]` of `view.cells`: linear red, green, blue and density in [`UNIT`]s.
pub(super) fn smooth(cells: &[[f32; 4]], view: &View, sampling: &Sampling) -> Vec<[f32; 4]> {
    let [width, height] = view.cells;
    let mut guide = vec![[0.0; 4]; cells.len()];
    guide.par_chunks_mut(width).enumerate().for_each(|(row, out)| {
        for (column, out) in out.iter_mut().enumerate() {
            *out = estimate(cells, width, height, column, row);
        }
    });
    let finest = view.supersample as f32;
    let widest = sampling.estimator_radius as f32 * finest;
    let narrowest = sampling.estimator_minimum as f32 * finest;
    let curve = sampling.estimator_curve as f32;
    let mut out = cells.to_vec();
    out.par_chunks_mut(width).enumerate().for_each(|(row, out)| {
        for (column, out) in out.iter_mut().enumerate() {
            let here = guide[row * width + column];
            if here[3] > 0.0 {
                let radius = ((widest + 1.0) / libm::powf(here[3], curve)).clamp(narrowest.min(widest), widest);
                if radius >= 1.0 {
                    let window = Window { cells, guide: &guide, width, height };
                    *out = window.average(column, row, radius);
                }
            }
        }
    });
    out
}

/// A first guess at a cell: mean colour in `0.0..=1.0` and samples, over its eight neighbours and itself.
fn estimate(cells: &[[f32; 4]], width: usize, height: usize, column: usize, row: usize) -> [f32; 4] {
    let mut sum = [0.0_f32; 4];
    for (down, outer) in [(row.saturating_sub(1), 0.25), (row, 0.5), ((row + 1).min(height - 1), 0.25)] {
        for (across, inner) in [(column.saturating_sub(1), 0.25), (column, 0.5), ((column + 1).min(width - 1), 0.25)] {
            for (sum, channel) in sum.iter_mut().zip(cells[down * width + across]) {
                *sum += outer * inner * channel;
            }
        }
    }
    let [red, green, blue, density] = sum;
    if density > 0.0 { [red / density, green / density, blue / density, density / UNIT as f32] } else { [0.0; 4] }
}

/// What a cell may be averaged over.
struct Window<'a> {
    cells: &'a [[f32; 4]],
    guide: &'a [[f32; 4]],
    width: usize,
    height: usize,
}

impl Window<'_> {
    /// The mean of the cells within `radius` cells, each weighted by how likely it shows the same light.
    fn average(&self, column: usize, row: usize, radius: f32) -> [f32; 4] {
        let here = self.guide[row * self.width + column];
        let reach = radius as usize;
        let mut sum = [0.0_f32; 4];
        let mut weights = 0.0_f32;
        for down in row.saturating_sub(reach)..=(row + reach).min(self.height - 1) {
            for across in column.saturating_sub(reach)..=(column + reach).min(self.width - 1) {
                let far = down.abs_diff(row).pow(2) + across.abs_diff(column).pow(2);
                let near = 1.0 - far as f32 / ((radius + 1.0) * (radius + 1.0));
                if near <= 0.0 {
                    continue;
                }
                let there = down * self.width + across;
                let weight = near * likeness(here, self.guide[there]);
                weights += weight;
                for (sum, channel) in sum.iter_mut().zip(self.cells[there]) {
                    *sum += weight * channel;
                }
            }
        }
        sum.map(|channel| channel / weights)
    }
}

/// How well chance alone explains the difference of two guesses: 1 if fully, 0 if not at all.
fn likeness(a: [f32; 4], b: [f32; 4]) -> f32 {
    let counts = (a[3] - b[3]).powi(2) / (GUIDE_VARIANCE * (a[3] + b[3]));
    let mut colours = 0.0;
    if b[3] > 0.0 {
        let apart: f32 = a[..3].iter().zip(&b[..3]).map(|(a, b)| (a - b) * (a - b)).sum();
        colours = apart / (COLOUR_VARIANCE * GUIDE_VARIANCE * (1.0 / a[3] + 1.0 / b[3]));
    }
    libm::expf(0.5 * (2.0 - counts - colours).min(0.0))
}

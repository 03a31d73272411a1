//! The samples of a frame, in two halves.
//!
//! Owns the histogram of a frame, what one half of the samples has in it, and the numbering of the random streams: each
//! round draws two halves, by random numbers of their own. The sum of the halves is the picture, their difference is its
//! noise. Never filters and never makes light: `density.rs` does.
//!
//! Start at [`Film::expose`].

use std::sync::atomic::AtomicBool;

use rayon::prelude::{IndexedParallelIterator, ParallelIterator, ParallelSliceMut};

use super::RenderError;
use super::backend::Backend;
use super::draw::Arithmetic;
use super::histogram::{Sums, TILE_CELLS, written};
use super::shot::Shot;
use species::Rng;

/// What a cell takes of memory where halves are told apart.
pub(super) const BYTES_OF_HALF: u64 = size_of::<[Rounded; 4]>() as u64;

/// Bits that a rounded sum lacks of an `f32`.
const DROPPED: u32 = 13;

/// A sum to 11 binary digits, in half the memory. Its error of up to 1/2048 is small against noise: so is that of four
/// million samples in a cell.
#[derive(Clone, Copy, Debug, Default)]
struct Rounded(u16);

/// What has been drawn of a frame.
#[derive(Debug)]
pub(super) struct Film {
    /// All samples, to the last one.
    sums: Sums,
    /// What one of the halves has in each cell; empty where they are not told apart.
    half: Vec<[Rounded; 4]>,
    /// Samples drawn so far, seen or not.
    samples: u64,
    rounds: u64,
}

impl Film {
    /// A film of so many `cells` with nothing on it. Only of one `in_halves` the noise is known.
    pub(super) fn new(cells: usize, in_halves: bool) -> Film {
        let half = written(if in_halves { cells } else { 0 }, [Rounded::default(); 4]);
        Film { sums: Sums::new(cells), half, samples: 0, rounds: 0 }
    }

    /// Has `backend` draw another round of `shot`, of at least `samples`. The picture is the same whether halves are told
    /// apart or not.
    /// Errors: those of the back-end.
    pub(super) fn expose(
        &mut self,
        shot: &Shot,
        samples: u64,
        backend: &Backend,
        arithmetic: Arithmetic,
        stop: &AtomicBool,
    ) -> Result<(), RenderError> {
        for half in 0..2 {
            let seed = Rng::stream(shot.seed, 2 * self.rounds + half).bits();
            let shot = shot.again(samples.div_ceil(2), seed);
            if half == 1 {
                self.take_the_other_half();
            }
            self.samples += backend.draw(&shot, &mut self.sums, arithmetic, stop)?;
        }
        self.rounds += 1;
        Ok(())
    }

    /// Keeps the other half: what is drawn next goes to the one that was kept before.
    fn take_the_other_half(&mut self) {
        self.half.par_chunks_mut(TILE_CELLS).enumerate().for_each(|(tile, half)| {
            for (cell, half) in (tile * TILE_CELLS..).zip(half) {
                let sum = self.sums.at(cell);
                *half = [0, 1, 2, 3].map(|channel| Rounded::new(sum[channel] - half[channel].value()));
            }
        });
    }

    /// Samples drawn so far, seen or not.
    pub(super) fn samples(&self) -> u64 {
        self.samples
    }

    /// Whether halves are told apart.
    pub(super) fn is_halved(&self) -> bool {
        !self.half.is_empty()
    }

    /// Light of a cell.
    #[inline]
    pub(super) fn at(&self, cell: usize) -> [f32; 4] {
        self.sums.at(cell)
    }

    /// Light of a cell by both halves, which are told apart.
    #[inline]
    pub(super) fn halves_at(&self, cell: usize) -> [[f32; 4]; 2] {
        let (sum, half) = (self.sums.at(cell), self.half[cell]);
        let half = [0, 1, 2, 3].map(|channel| half[channel].value().min(sum[channel]));
        [half, [0, 1, 2, 3].map(|channel| sum[channel] - half[channel])]
    }

    /// All light of all cells.
    pub(super) fn light(&self, cells: usize) -> Vec<[f32; 4]> {
        (0..cells).map(|cell| self.at(cell)).collect()
    }

    /// Frees what was drawn, but for the number of samples.
    pub(super) fn clear(&mut self) {
        (self.sums, self.half) = (Sums::new(0), Vec::new());
    }
}

impl Rounded {
    /// `sum`, rounded; 0 where it is less.
    #[inline]
    fn new(sum: f32) -> Rounded {
        let above_one = (sum.max(0.0) + 1.0).to_bits() - 1.0_f32.to_bits();
        Rounded(((above_one + (1 << (DROPPED - 1))) >> DROPPED) as u16)
    }

    #[inline]
    fn value(self) -> f32 {
        f32::from_bits((u32::from(self.0) << DROPPED) + 1.0_f32.to_bits()) - 1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::histogram::{MAX_SAMPLES, UNIT};

    #[test]
    fn sums_keep_eleven_digits_up_to_the_largest() {
        let largest = MAX_SAMPLES * f64::from(UNIT);
        for sum in (0..1 << 12)
            .map(|sum| f64::from(sum) / 2.0)
            .chain((0..=520).map(|step| largest.powf(f64::from(step) / 520.0)))
        {
            let kept = f64::from(Rounded::new(sum as f32).value());
            assert!((kept - sum).abs() <= (sum + 1.0) / 2048.0, "{sum} is kept as {kept}");
        }
        assert_eq!((Rounded::new(-3.0).value(), Rounded::new(f32::from(2040_u16)).value()), (0.0, 2040.0));
    }
}

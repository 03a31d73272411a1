//! The samples of a frame, in two halves.
//!
//! Owns the histograms of a frame and the numbering of its random streams: each round draws two halves, by random numbers
//! of their own. The sum of the halves is the picture, their difference is its noise. Never filters and never makes light:
//! `density.rs` does.
//!
//! Start at [`Film::expose`].

use std::sync::atomic::AtomicBool;

use super::RenderError;
use super::backend::Backend;
use super::draw::Arithmetic;
use super::histogram::Sums;
use super::shot::Shot;
use crate::rng::Rng;

/// What has been drawn of a frame.
#[derive(Debug)]
pub(super) struct Film {
    /// Both halves, or one histogram for both.
    sums: Vec<Sums>,
    /// Samples drawn so far, seen or not.
    samples: u64,
    rounds: u64,
}

impl Film {
    /// A film of so many `cells` with nothing on it. Only of one `in_halves` the noise is known; it takes twice the memory.
    pub(super) fn new(cells: usize, in_halves: bool) -> Film {
        Film { sums: (0..=usize::from(in_halves)).map(|_| Sums::new(cells)).collect(), samples: 0, rounds: 0 }
    }

    /// Has `backend` draw another round of `shot`, of at least `samples`. The picture is the same whether halves are kept
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
        let last = self.sums.len() - 1;
        for half in 0..2 {
            let seed = Rng::stream(shot.seed, 2 * self.rounds + half).bits();
            let shot = shot.again(samples.div_ceil(2), seed);
            self.samples += backend.draw(&shot, &mut self.sums[last.min(half as usize)], arithmetic, stop)?;
        }
        self.rounds += 1;
        Ok(())
    }

    /// Samples drawn so far, seen or not.
    pub(super) fn samples(&self) -> u64 {
        self.samples
    }

    /// Both halves, if they are kept apart.
    pub(super) fn halves(&self) -> Option<[&Sums; 2]> {
        match &self.sums[..] {
            [one, other] => Some([one, other]),
            _ => None,
        }
    }

    /// Frees what was drawn, but for the number of samples.
    pub(super) fn clear(&mut self) {
        self.sums.clear();
    }

    /// All light of a cell.
    pub(super) fn at(&self, cell: usize) -> [f32; 4] {
        self.sums.iter().map(|sums| sums.at(cell)).fold([0.0; 4], |all, light| [0, 1, 2, 3].map(|i| all[i] + light[i]))
    }

    /// All light of all cells.
    pub(super) fn light(&self, cells: usize) -> Vec<[f32; 4]> {
        (0..cells).map(|cell| self.at(cell)).collect()
    }
}

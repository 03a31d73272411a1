//! The histogram: how much light fell into each cell.
//!
//! Owns the sums. They are whole numbers, so that the order in which threads add them changes nothing. Never
//! knows how samples come to be (`chaos.rs`) or what they look like (`tonemap.rs`).
//!
//! Start at [`collect`].

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use rayon::prelude::{IndexedParallelIterator, ParallelIterator, ParallelSlice, ParallelSliceMut};

use super::chaos::Batches;
use super::view::View;

/// What one fully bright, fully visible sample adds: twice a byte, so that bytes are exact.
pub(crate) const UNIT: u32 = 510;

/// What a cell takes in the sums of all threads.
pub(crate) const BYTES_OF_SUMS: u64 = size_of::<[u64; 4]>() as u64;

/// What a cell takes in each thread.
pub(crate) const BYTES_OF_TILE: u64 = size_of::<[u32; 4]>() as u64;

/// Sums of all threads: red, green, blue and density in [`UNIT`]s, `[height][width][4]`.
pub(crate) type Sums = Vec<[u64; 4]>;

/// A thread's own sums since it last handed them in. They cannot overflow before [`Tile::is_full`].
#[derive(Debug)]
pub(crate) struct Tile {
    cells: Vec<[u32; 4]>,
    samples: u64,
}

impl Tile {
    /// Adds a sample to a cell.
    #[inline]
    pub(crate) fn add(&mut self, cell: usize, light: [u32; 4]) {
        let sum = &mut self.cells[cell];
        for (sum, light) in sum.iter_mut().zip(light) {
            *sum = sum.wrapping_add(light);
        }
    }

    fn is_full(&self, next: u64) -> bool {
        self.samples + next > u64::from(u32::MAX / UNIT)
    }

    fn hand_in(&mut self, sums: &Mutex<Sums>) {
        let mut sums = sums.lock().expect("a thread that adds numbers does not panic");
        for (sum, cell) in sums.iter_mut().zip(&mut self.cells) {
            if cell[3] == 0 && *cell == [0; 4] {
                continue;
            }
            for (sum, part) in sum.iter_mut().zip(std::mem::take(cell)) {
                *sum += u64::from(part);
            }
        }
        self.samples = 0;
    }
}

/// Runs all batches on the threads of the current pool and sums them up; once `stop` is set, only those begun.
pub(crate) fn collect(view: &View, batches: &Batches, stop: &AtomicBool) -> Sums {
    let cells = view.cells[0] * view.cells[1];
    let sums = Mutex::new(vec![[0_u64; 4]; cells]);
    let next = AtomicU64::new(0);
    rayon::broadcast(|_| {
        let mut tile = Tile { cells: Vec::new(), samples: 0 };
        while !stop.load(Ordering::Relaxed) {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if number >= batches.count() {
                break;
            }
            if tile.cells.is_empty() {
                tile.cells = vec![[0; 4]; cells];
            }
            if tile.is_full(batches.max_samples()) {
                tile.hand_in(&sums);
            }
            tile.samples += batches.max_samples();
            batches.run(number, &mut tile);
        }
        tile.hand_in(&sums);
    });
    sums.into_inner().expect("a thread that adds numbers does not panic")
}

/// Applies `change` to every cell, in parallel, giving a row-major buffer of the same shape.
pub(crate) fn map(sums: &Sums, width: usize, change: impl Fn(&[u64; 4]) -> [f32; 4] + Sync) -> Vec<[f32; 4]> {
    let mut out = vec![[0.0; 4]; sums.len()];
    out.par_chunks_mut(width).zip(sums.par_chunks(width)).for_each(|(out, sums)| {
        for (out, sum) in out.iter_mut().zip(sums) {
            *out = change(sum);
        }
    });
    out
}

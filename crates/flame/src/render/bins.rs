//! Samples on their way to the histogram.
//!
//! Owns a thread's own bins, one for each tile. A bin is handed in when it is full, so that a tile comes into the
//! processor's cache once for a thousand samples instead of once for each.
//!
//! Start at [`Bins::add`].

use super::histogram::{Histogram, Record, TILE, TILE_CELLS};

/// Most samples of a bin.
const LARGEST: usize = 1024;

/// Least samples of a bin.
const SMALLEST: usize = 16;

/// What all bins of a thread may take in memory, 7.5 MiB.
const BYTES: usize = 15 << 19;

/// A thread's samples that the histogram does not have yet.
#[derive(Debug)]
pub(crate) struct Bins<'h, 's> {
    histogram: &'h Histogram<'s>,
    /// `[tiles][size]` records.
    records: Vec<Record>,
    /// How many of them are there, in each bin.
    filled: Vec<u32>,
    /// Records of a bin.
    size: usize,
}

impl<'h, 's> Bins<'h, 's> {
    /// Empty bins for `histogram`.
    pub(crate) fn new(histogram: &'h Histogram<'s>) -> Bins<'h, 's> {
        let (tiles, size) = (histogram.tiles(), size(histogram.tiles()));
        Bins { histogram, records: vec![Record::default(); tiles * size], filled: vec![0; tiles], size }
    }

    /// What the bins of a thread take for this many cells.
    pub(crate) fn bytes(cells: usize) -> u64 {
        let tiles = cells.div_ceil(TILE_CELLS);
        (tiles * (size(tiles) * size_of::<Record>() + size_of::<u32>())) as u64
    }

    /// Adds a sample that fell into `cell` and is lit by the palette's `entry`.
    #[inline(always)]
    pub(crate) fn add(&mut self, cell: u32, entry: u32) {
        let tile = (cell >> TILE) as usize;
        let filled = &mut self.filled[tile];
        self.records[tile * self.size + *filled as usize] = Record::new(cell, entry);
        *filled += 1;
        if *filled as usize == self.size {
            self.hand_in(tile);
        }
    }

    /// Hands in whatever is left.
    pub(crate) fn finish(mut self) {
        for tile in 0..self.filled.len() {
            self.hand_in(tile);
        }
    }

    #[inline(never)]
    fn hand_in(&mut self, tile: usize) {
        let filled = std::mem::take(&mut self.filled[tile]) as usize;
        if filled > 0 {
            self.histogram.add(tile, &self.records[tile * self.size..][..filled]);
        }
    }
}

/// Records of each of so many bins.
fn size(tiles: usize) -> usize {
    (BYTES / size_of::<Record>() / tiles.max(1)).clamp(SMALLEST, LARGEST)
}

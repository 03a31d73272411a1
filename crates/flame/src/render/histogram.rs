//! The histogram: how much light fell into each cell.
//!
//! Owns the sums, in tiles that threads add to in turn. They are whole numbers, so that the order in which threads add
//! changes nothing. Never knows how samples come to be (`chaos.rs`, `pool.rs`) or what they look like (`tonemap.rs`).
//!
//! Start at [`Histogram`]; a thread adds by way of its [`Bins`](super::bins::Bins).

use std::sync::Mutex;

/// What one fully bright, fully visible sample adds: eight times a byte, so that bytes are exact.
pub(crate) const UNIT: u32 = 2040;

/// Most samples of a frame: hours of a core. All of them may fall into one cell. 4K at quality 2000 and zoom 2 takes 2.7e11.
pub(crate) const MAX_SAMPLES: f64 = 1e12;

const _: () = assert!((1_u64 << (32 + CARRY)) as f64 > MAX_SAMPLES * UNIT as f64, "a sum must not overflow");

/// Cells of a tile, as a power of 2: what is added to at a time lies in the processor's cache.
pub(crate) const TILE: u32 = 11;

/// Cells of a tile.
pub(crate) const TILE_CELLS: usize = 1 << TILE;

/// What a cell takes at first, and again once its tile has carried.
pub(crate) const BYTES_OF_CELL: u64 = size_of::<[u32; 4]>() as u64;

/// Bits of a sum that stay when a tile carries.
const CARRY: u32 = 20;

/// Samples that a tile takes before the sum of a cell could overflow.
const FULL: u32 = (u32::MAX - (1 << CARRY)) / UNIT;

/// Where a sample fell within its tile, and its colour: the cell in the upper [`TILE`] bits, the palette's entry below.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Record(u32);

/// Red, green, blue and density in [`UNIT`]s of cells in rows, row after row.
#[derive(Debug)]
pub(crate) struct Histogram<'s> {
    tiles: Vec<Mutex<Tile<'s>>>,
    palette: &'s [[u32; 4]],
}

/// Some cells that follow one another.
#[derive(Debug)]
struct Tile<'s> {
    sums: &'s mut [[u32; 4]],
    /// What the sums have carried, in units of 2^[`CARRY`].
    carried: Option<Box<[[u32; 4]]>>,
    /// Samples since the last carry.
    samples: u32,
}

impl Record {
    /// How many entries palettes may have in all.
    pub(crate) const ENTRIES: usize = 1 << (32 - TILE);

    /// A sample in `cell`, lit by the palette's `entry`.
    #[inline(always)]
    pub(crate) fn new(cell: u32, entry: u32) -> Record {
        Record(cell << (32 - TILE) | entry)
    }

    #[inline(always)]
    fn cell(self) -> usize {
        (self.0 >> (32 - TILE)) as usize
    }

    #[inline(always)]
    fn entry(self) -> usize {
        self.0 as usize & (Record::ENTRIES - 1)
    }
}

impl<'s> Histogram<'s> {
    /// An empty histogram on `sums`, which are all 0. Colours are looked up in `palette`.
    pub(crate) fn new(sums: &'s mut [[u32; 4]], palette: &'s [[u32; 4]]) -> Histogram<'s> {
        let tile = |sums| Mutex::new(Tile { sums, carried: None, samples: 0 });
        Histogram { tiles: sums.chunks_mut(TILE_CELLS).map(tile).collect(), palette }
    }

    /// How many tiles there are.
    pub(crate) fn tiles(&self) -> usize {
        self.tiles.len()
    }

    /// Adds all `records` to the tile of this number.
    pub(crate) fn add(&self, tile: usize, records: &[Record]) {
        let mut tile = self.tiles[tile].lock().expect("a thread that adds numbers does not panic");
        if tile.samples + records.len() as u32 > FULL {
            tile.carry();
        }
        tile.samples += records.len() as u32;
        let sums = &mut *tile.sums;
        for record in records {
            let light = self.palette[record.entry()];
            let sum = &mut sums[record.cell()];
            *sum = [0, 1, 2, 3].map(|channel| sum[channel].wrapping_add(light[channel]));
        }
    }

    /// What the tiles have carried, in units of 2^[`CARRY`]; nothing for a tile that never did.
    fn carried(self) -> Vec<Option<Box<[[u32; 4]]>>> {
        let carried = |tile: Mutex<Tile>| tile.into_inner().expect("a thread that adds numbers does not panic").carried;
        self.tiles.into_iter().map(carried).collect()
    }
}

impl Tile<'_> {
    #[cold]
    fn carry(&mut self) {
        let carried = self.carried.get_or_insert_with(|| vec![[0; 4]; self.sums.len()].into());
        for (carried, sum) in carried.iter_mut().zip(self.sums.iter_mut()) {
            for (carried, sum) in carried.iter_mut().zip(sum) {
                *carried += *sum >> CARRY;
                *sum &= (1 << CARRY) - 1;
            }
        }
        self.samples = 0;
    }
}

/// Lets `fill` add to a histogram of `cells` cells whose colours are those of `palette`, and returns its sums as floats.
pub(crate) fn filled(cells: usize, palette: &[[u32; 4]], fill: impl FnOnce(&Histogram)) -> Vec<[f32; 4]> {
    let mut sums = vec![[0_u32; 4]; cells];
    let histogram = Histogram::new(&mut sums, palette);
    fill(&histogram);
    let carried = histogram.carried();
    // In the place of the sums: a frame of many cells need not be in memory twice.
    let float = |(cell, sum): (usize, [u32; 4])| match &carried[cell >> TILE] {
        None => sum.map(|sum| sum as f32),
        Some(carried) => {
            let carried = carried[cell & (TILE_CELLS - 1)];
            std::array::from_fn(|channel| ((u64::from(carried[channel]) << CARRY) + u64::from(sum[channel])) as f32)
        }
    };
    sums.into_iter().enumerate().map(float).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_exact_far_beyond_32_bits() {
        let palette = [[UNIT, 1, 0, UNIT]];
        let records = vec![Record::new(7, 0); 1 << 20];
        let sums = filled(TILE_CELLS + 8, &palette, |histogram| {
            for _ in 0..100 {
                histogram.add(0, &records);
                histogram.add(1, &records[..1]);
            }
        });
        let samples = 100.0 * f64::from(1 << 20);
        let unit = f64::from(UNIT);
        assert_eq!(sums[7].map(f64::from), [samples * unit, samples, 0.0, samples * unit]);
        assert_eq!(sums[TILE_CELLS + 7].map(f64::from), [100.0 * unit, 100.0, 0.0, 100.0 * unit]);
        assert!(sums.iter().enumerate().all(|(cell, sum)| cell & (TILE_CELLS - 1) == 7 || *sum == [0.0; 4]));
    }
}

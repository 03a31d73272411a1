//! The histogram: how much light fell into each cell.
//!
//! Owns the sums, in tiles that threads add to in turn. They are whole numbers, so that the order in which threads add
//! changes nothing. Never knows how samples come to be (`chaos.rs`, `pool.rs`) or what they look like (`tonemap.rs`).
//!
//! Start at [`Sums`] and [`Histogram`]; a thread adds by way of its [`Bins`](super::bins::Bins).

use std::hint::black_box;
use std::sync::Mutex;

use rayon::prelude::{ParallelIterator, ParallelSliceMut};

/// What one fully bright, fully visible sample adds: eight times a byte, so that bytes are exact.
pub(crate) const UNIT: u32 = 2040;

/// Most samples of a frame: hours of a core. All of them may fall into one cell. 4K at quality 2000 and zoom 2 takes 2.7e11.
pub(crate) const MAX_SAMPLES: f64 = 1e12;

/// Least bytes of memory that the system gives at a time.
const PAGE: usize = 4096;

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

/// Red, green, blue and density in [`UNIT`]s of cells in rows, row after row, while no thread adds to them.
#[derive(Debug)]
pub(crate) struct Sums {
    cells: Vec<[u32; 4]>,
    /// What does not fit into them, one for each tile.
    spills: Vec<Spill>,
}

/// What the sums of a tile have carried.
#[derive(Debug, Default)]
struct Spill {
    /// In units of 2^[`CARRY`]; nothing for a tile that never carried.
    carried: Option<Box<[[u32; 4]]>>,
    /// Samples since the last carry.
    samples: u32,
}

/// Sums that threads add to.
#[derive(Debug)]
pub(crate) struct Histogram<'s> {
    tiles: Vec<Mutex<Tile<'s>>>,
    palette: &'s [[u32; 4]],
}

/// Some cells that follow one another.
#[derive(Debug)]
struct Tile<'s> {
    sums: &'s mut [[u32; 4]],
    spill: &'s mut Spill,
}

impl Sums {
    /// So many cells without light.
    pub(crate) fn new(cells: usize) -> Sums {
        let spills = (0..cells.div_ceil(TILE_CELLS)).map(|_| Spill::default()).collect();
        Sums { cells: written(cells, [0; 4]), spills }
    }

    /// Adds light of a channel of a cell that was added up elsewhere.
    #[cfg(feature = "gpu")]
    pub(crate) fn add(&mut self, cell: usize, channel: usize, light: u64) {
        let tile = cell >> TILE;
        let spill = &mut self.spills[tile];
        let sum = u64::from(self.cells[cell][channel]) + light;
        // No sum of the tile is larger than so many samples make it.
        let samples = sum.div_ceil(UNIT.into());
        if samples <= FULL.into() {
            self.cells[cell][channel] = sum as u32;
            spill.samples = spill.samples.max(samples as u32);
        } else {
            let carried = spill
                .carried
                .get_or_insert_with(|| vec![[0; 4]; TILE_CELLS.min(self.cells.len() - tile * TILE_CELLS)].into());
            carried[cell & (TILE_CELLS - 1)][channel] += (sum >> CARRY) as u32;
            self.cells[cell][channel] = sum as u32 & ((1 << CARRY) - 1);
        }
    }

    /// Light of a cell.
    #[inline]
    pub(crate) fn at(&self, cell: usize) -> [f32; 4] {
        let sum = self.cells[cell];
        match &self.spills[cell >> TILE].carried {
            None => sum.map(|sum| sum as f32),
            Some(carried) => {
                let carried = carried[cell & (TILE_CELLS - 1)];
                std::array::from_fn(|channel| ((u64::from(carried[channel]) << CARRY) + u64::from(sum[channel])) as f32)
            }
        }
    }
}

/// So many of `value`, in memory that was written to. The system gives fresh memory at the first write, but a page that is read
/// before is first one that all share; taking that away from each interrupts the other threads.
pub(super) fn written<T: Copy + Send + Sync>(count: usize, value: T) -> Vec<T> {
    let mut all = vec![value; count];
    all.par_chunks_mut((PAGE / size_of::<T>()).max(1)).for_each(|page| page[0] = black_box(value));
    all
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
    /// A histogram that goes on with `sums`. Colours are looked up in `palette`.
    pub(crate) fn new(sums: &'s mut Sums, palette: &'s [[u32; 4]]) -> Histogram<'s> {
        let tile = |(sums, spill)| Mutex::new(Tile { sums, spill });
        let tiles = sums.cells.chunks_mut(TILE_CELLS).zip(&mut sums.spills);
        Histogram { tiles: tiles.map(tile).collect(), palette }
    }

    /// How many tiles there are.
    pub(crate) fn tiles(&self) -> usize {
        self.tiles.len()
    }

    /// Adds all `records` to the tile of this number.
    pub(crate) fn add(&self, tile: usize, records: &[Record]) {
        let mut tile = self.tiles[tile].lock().expect("a thread that adds numbers does not panic");
        if tile.spill.samples + records.len() as u32 > FULL {
            tile.carry();
        }
        tile.spill.samples += records.len() as u32;
        let sums = &mut *tile.sums;
        for record in records {
            let light = self.palette[record.entry()];
            let sum = &mut sums[record.cell()];
            *sum = [0, 1, 2, 3].map(|channel| sum[channel].wrapping_add(light[channel]));
        }
    }
}

impl Tile<'_> {
    #[cold]
    fn carry(&mut self) {
        let carried = self.spill.carried.get_or_insert_with(|| vec![[0; 4]; self.sums.len()].into());
        for (carried, sum) in carried.iter_mut().zip(self.sums.iter_mut()) {
            for (carried, sum) in carried.iter_mut().zip(sum) {
                *carried += *sum >> CARRY;
                *sum &= (1 << CARRY) - 1;
            }
        }
        self.spill.samples = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A frame of the Dreams has 2.4e9 samples; here all fall into one cell.
    #[test]
    fn a_frame_of_a_wall_in_one_cell_is_counted_to_the_last_sample() {
        let palette = [[UNIT, 1, 0, UNIT]];
        let records = vec![Record::new(7, 0); 1 << 20];
        let mut sums = Sums::new(TILE_CELLS + 8);
        let rounds: u64 = 2_400_000_000 / (1 << 20) + 1;
        // In two rounds: what was carried is kept in between.
        for round in [0..rounds / 2, rounds / 2..rounds] {
            let histogram = Histogram::new(&mut sums, &palette);
            for _ in round {
                histogram.add(0, &records);
                histogram.add(1, &records[..1]);
            }
        }
        let samples = (rounds << 20) as f64;
        let expected = [samples * f64::from(UNIT), samples, 0.0, samples * f64::from(UNIT)].map(|sum| sum as f32);
        assert_eq!(sums.at(7), expected);
        let once = rounds as f32;
        assert_eq!(sums.at(TILE_CELLS + 7), [once * UNIT as f32, once, 0.0, once * UNIT as f32]);
        let lit = |(cell, light): (usize, [f32; 4])| (light != [0.0; 4]).then_some(cell);
        assert_eq!(
            (0..TILE_CELLS + 8).map(|cell| (cell, sums.at(cell))).filter_map(lit).collect::<Vec<_>>(),
            [7, TILE_CELLS + 7]
        );
    }

    #[test]
    #[cfg(feature = "gpu")]
    fn light_from_elsewhere_adds_to_the_samples_of_this_processor() {
        let palette = [[UNIT, 1, 0, UNIT]];
        let records = vec![Record::new(7, 0); FULL as usize];
        let mut sums = Sums::new(TILE_CELLS + 8);
        let large = 5 << 40;
        for round in 1..=3 {
            sums.add(7, 0, large);
            sums.add(7, 3, 9);
            sums.add(TILE_CELLS + 7, 2, u64::from(u32::MAX));
            Histogram::new(&mut sums, &palette).add(0, &records);
            let (samples, unit) = (f64::from(FULL), f64::from(UNIT));
            let once = [large as f64 + samples * unit, samples, 0.0, samples * unit + 9.0];
            assert_eq!(sums.at(7), once.map(|sum| (f64::from(round) * sum) as f32));
            assert_eq!(
                sums.at(TILE_CELLS + 7),
                [0.0, 0.0, f64::from(round) * f64::from(u32::MAX), 0.0].map(|sum| sum as f32)
            );
        }
    }

    #[test]
    fn the_most_samples_of_a_frame_do_not_overflow_a_cell() {
        let palette = [[UNIT; 4]];
        let records = vec![Record::new(0, 0); FULL as usize];
        let mut sums = Sums::new(1);
        let before = MAX_SAMPLES as u64;
        // As if nearly all of them were there already.
        let spilled = ((before - u64::from(FULL)) * u64::from(UNIT)) >> CARRY;
        sums.spills[0].carried = Some(vec![[u32::try_from(spilled).unwrap(); 4]].into());
        Histogram::new(&mut sums, &palette).add(0, &records);
        Histogram::new(&mut sums, &palette).add(0, &records[..1]);
        let expected = before as f64 * f64::from(UNIT);
        assert!(sums.at(0).iter().all(|sum| (f64::from(*sum) / expected - 1.0).abs() < 1e-6), "{:?}", sums.at(0));
    }
}

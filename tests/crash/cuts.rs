//! What a power cut leaves of a disk.
//!
//! Owns the choice, as a function of the log and a seed. Everything that was written before the last flush is there; of
//! what was written since, each write is there or not, or some of its sectors are: disks keep writes in memory and
//! choose their own order.
//!
//! Start at [`Cuts::next`].

use crate::block_log::BlockLog;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// How many writes in a hundred survive that were not flushed; one of these for each cut.
const SURVIVING: [u32; 5] = [0, 10, 50, 90, 100];
/// How many of those in a hundred are torn.
const TORN: u32 = 10;
/// How many entries a cut right behind another entry may be away from it.
const BEHIND: usize = 4;
/// What begins before this is not torn: ext4 writes its superblock in place, and trusts a disk with so much.
const UNTORN: usize = 4096;

/// Power cuts, one after the other through the life of a disk.
pub(crate) struct Cuts<'l> {
    log: &'l BlockLog,
    random: ChaCha8Rng,
    /// The cuts that are left, each behind so many entries; the latest first.
    places: Vec<usize>,
    /// The disk as far as it is sure to be.
    flushed: Vec<u8>,
    /// How many entries that is.
    done: usize,
}

impl<'l> Cuts<'l> {
    /// So many cuts, spread over the whole log; a quarter of them right behind the entries `reports`: what was reported
    /// then must be there at once.
    pub(crate) fn of(log: &'l BlockLog, reports: &[usize], count: usize, seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let length = log.entries.len();
        let mut below = |count: usize| random.next_u32() as usize % count;
        let mut places: Vec<usize> = Vec::with_capacity(count);
        for cut in 0..count {
            places.push(match reports {
                [_, ..] if cut % 4 == 0 => (reports[below(reports.len())] + 1 + below(BEHIND)).min(length),
                _ => below(length + 1),
            });
        }
        places.sort_unstable_by(|a, b| b.cmp(a));
        Self { log, random, places, flushed: log.base.clone(), done: 0 }
    }

    fn chance(&mut self, percent: u32) -> bool {
        self.random.next_u32() % 100 < percent
    }
}

impl Cuts<'_> {
    /// Makes `disk` what the next cut leaves. Returns behind how many entries that was; `None` if there are no more.
    pub(crate) fn next(&mut self, disk: &mut Vec<u8>) -> Option<usize> {
        let (log, place) = (self.log, self.places.pop()?);
        let flush = (self.done..place).rev().find(|at| log.entries[*at].is_flush);
        for entry in &log.entries[self.done..flush.unwrap_or(self.done)] {
            log.apply(entry, &mut self.flushed, |_| true);
        }
        self.done = flush.unwrap_or(self.done);
        disk.clone_from(&self.flushed);
        let surviving = SURVIVING[self.random.next_u32() as usize % SURVIVING.len()];
        for entry in &log.entries[self.done..place] {
            if self.chance(surviving) {
                let is_torn = entry.at >= UNTORN && self.chance(TORN);
                log.apply(entry, disk, |_| !is_torn || self.chance(50));
            }
        }
        Some(place)
    }
}

#[cfg(test)]
mod tests {
    use super::Cuts;
    use crate::block_log::tests::log;
    use crate::block_log::{BlockLog, SECTOR};
    use std::collections::BTreeSet;

    const FLUSH: u64 = 1;

    /// So many cuts: where they are, and what they leave.
    fn all(log: &BlockLog, count: usize) -> Vec<(usize, Vec<u8>)> {
        let (mut cuts, mut disk) = (Cuts::of(log, &[], count, 1), Vec::new());
        std::iter::from_fn(|| cuts.next(&mut disk).map(|place| (place, disk.clone()))).collect()
    }

    #[test]
    fn what_was_flushed_is_there_and_of_the_rest_any_part() {
        let log = log(11, &[(8, 1, 1, 0), (0, 0, 0, FLUSH), (9, 2, 2, 0), (8, 3, 1, 0), (0, 0, 0, FLUSH)]);
        let mut seen: Vec<BTreeSet<[u8; 3]>> = vec![BTreeSet::new(); 6];
        for (place, disk) in all(&log, 30_000) {
            seen[place].insert([8, 9, 10].map(|sector| disk[sector * SECTOR]));
        }
        let those = |disks: &[[u8; 3]]| disks.iter().copied().collect::<BTreeSet<_>>();
        assert_eq!(seen[0], those(&[[0, 0, 0]]));
        assert_eq!(seen[1], those(&[[0, 0, 0], [1, 0, 0]]));
        assert_eq!(seen[2], those(&[[1, 0, 0]]));
        assert_eq!(seen[3], those(&[[1, 0, 0], [1, 2, 0], [1, 0, 2], [1, 2, 2]]));
        assert_eq!(seen[4].len(), 8, "the later write may be there without the earlier one");
        assert_eq!(seen[5], those(&[[3, 2, 2]]));
    }
}

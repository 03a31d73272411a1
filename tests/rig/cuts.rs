//! What a power cut leaves of a disk.
//!
//! Owns the choice, as a function of the log and a seed. Everything before the last flush is on the disk. Each later
//! write is there, or not, or only some of its sectors: disks cache writes and choose their own order.
//!
//! Start at [`Cuts::next`] and [`survivors`].

use crate::block_log::{BlockLog, SECTOR};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::collections::BTreeSet;
use std::ops::Range;

/// The percentage of writes that survive without a flush; each cut has one of these.
const SURVIVING: [u32; 5] = [0, 10, 50, 90, 100];
/// The percentage of those that are torn.
const TORN: u32 = 10;
/// The greatest distance, in entries, of a cut right after an entry.
const BEHIND: usize = 4;
/// Writes before this offset of the partition are not torn: ext4 writes its superblock in place, and relies on that.
pub const UNTORN: usize = 4096;

/// Power cuts in the recording of a disk.
pub struct Cuts<'l> {
    log: &'l BlockLog,
    random: ChaCha8Rng,
    /// The cuts to come, each after so many entries; the latest first.
    places: Vec<usize>,
    /// The disk with everything that is certain so far.
    flushed: Vec<u8>,
    /// The number of entries in it.
    done: usize,
    /// The results so far.
    known: BTreeSet<State>,
}

/// Entries of a log, and which sectors of each.
pub type Survivors = Vec<(usize, Vec<bool>)>;

/// A result: the number of entries that are whole, the later entries with the sectors that survive, and the number of
/// reports.
type State = (usize, Survivors, usize);

impl<'l> Cuts<'l> {
    /// `count` cuts, spread over the whole log; a quarter of them right after the entries `reports`, since a report
    /// must hold from then on.
    pub fn of(log: &'l BlockLog, reports: &[usize], count: usize, seed: u64) -> Self {
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
        Self { log, random, places, flushed: log.base.clone(), done: 0, known: BTreeSet::new() }
    }
}

impl Cuts<'_> {
    /// Makes `disk` the result of the next cut that differs from all before. Returns the number of `reports` before it;
    /// `None` if there are no more cuts.
    pub fn next(&mut self, reports: &[usize], disk: &mut Vec<u8>) -> Option<usize> {
        let log = self.log;
        loop {
            let place = self.places.pop()?;
            let flush = (self.done..place).rev().find(|at| log.entries[*at].is_flush);
            for entry in &log.entries[self.done..flush.unwrap_or(self.done)] {
                log.apply(entry, &mut self.flushed, |_| true);
            }
            self.done = flush.unwrap_or(self.done);
            let told = reports.iter().filter(|report| **report < place).count();
            let survivors = survivors(log, self.done..place, |at| at < UNTORN, &mut self.random);
            if self.known.insert((self.done, survivors.clone(), told)) {
                disk.clone_from(&self.flushed);
                for (at, keeps) in survivors {
                    log.apply(&log.entries[at], disk, |sector| keeps[sector]);
                }
                return Some(told);
            }
        }
    }
}

/// Which sectors of these entries survive, none of which was flushed. `is_whole` says where nothing is torn.
pub fn survivors(
    log: &BlockLog,
    entries: Range<usize>,
    is_whole: impl Fn(usize) -> bool,
    random: &mut ChaCha8Rng,
) -> Survivors {
    let surviving = SURVIVING[random.next_u32() as usize % SURVIVING.len()];
    let mut chance = |percent: u32| random.next_u32() % 100 < percent;
    let mut survivors = Vec::new();
    for at in entries {
        let (begins, sectors) = (log.entries[at].at, log.entries[at].bytes.len() / SECTOR);
        if sectors > 0 && chance(surviving) {
            let is_torn = !is_whole(begins) && chance(TORN);
            let keeps: Vec<bool> = (0..sectors).map(|_| !is_torn || chance(50)).collect();
            if keeps.contains(&true) {
                survivors.push((at, keeps));
            }
        }
    }
    survivors
}

#[cfg(test)]
mod tests {
    use super::Cuts;
    use crate::block_log::tests::log;
    use crate::block_log::{BlockLog, SECTOR};
    use std::collections::BTreeSet;

    const FLUSH: u64 = 1;

    /// The results of `count` cuts, by the number of entries before them.
    fn all(log: &BlockLog, count: usize) -> Vec<(usize, Vec<u8>)> {
        let (mut cuts, mut disk) = (Cuts::of(log, &[], count, 1), Vec::new());
        let every: Vec<usize> = (0..log.entries.len()).collect();
        std::iter::from_fn(|| cuts.next(&every, &mut disk).map(|place| (place, disk.clone()))).collect()
    }

    #[test]
    fn what_was_flushed_is_there_and_of_the_rest_any_part_and_nothing_comes_twice() {
        let log = log(11, &[(8, 1, 1, 0), (0, 0, 0, FLUSH), (9, 2, 2, 0), (8, 3, 1, 0), (0, 0, 0, FLUSH)]);
        let mut seen: Vec<BTreeSet<[u8; 3]>> = vec![BTreeSet::new(); 6];
        for (place, disk) in all(&log, 30_000) {
            let is_new = seen[place].insert([8, 9, 10].map(|sector| disk[sector * SECTOR]));
            assert!(is_new, "{place} entries");
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

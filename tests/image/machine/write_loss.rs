//! The writes that a power cut takes from a disk: those after the last flush may be lost or torn.
//!
//! Owns the disk after the cut, made from the one before and the record. `claims::cuts` chooses, as it does for the
//! crash laboratory.

use claims::block_log::{BlockLog, SECTOR};
use claims::cuts::{UNTORN, survivors};
use rand_chacha::ChaCha8Rng;
use std::fs::{self, File};
use std::ops::Range;
use std::os::unix::fs::FileExt;
use std::path::Path;

/// Makes `disk` what a power cut leaves of the writes in `log`. The file system that begins at `data` writes its
/// superblock in place. Returns the number of writes, of those that were not flushed, and of those that survive of
/// them.
pub(crate) fn cut(log: &Path, disk: &Path, data: Option<u64>, random: &mut ChaCha8Rng) -> [usize; 3] {
    let log = fs::read(log).unwrap();
    if log.is_empty() {
        // Nothing was written.
        return [0; 3];
    }
    let log = BlockLog::read(Vec::new(), log);
    let disk = File::options().write(true).open(disk).unwrap();
    let write = |at: usize, keeps: &dyn Fn(usize) -> bool| {
        let entry = &log.entries[at];
        for (sector, bytes) in log.bytes(entry).chunks(SECTOR).enumerate().filter(|(sector, _)| keeps(*sector)) {
            disk.write_all_at(bytes, (entry.at + sector * SECTOR) as u64).unwrap();
        }
    };
    let flushed = log.entries.iter().rposition(|entry| entry.is_flush).unwrap_or(0);
    (0..flushed).for_each(|at| write(at, &|_| true));
    let superblock: Range<usize> = data.map_or(0..0, |data| data as usize..data as usize + UNTORN);
    let since = flushed..log.entries.len();
    let survivors = survivors(&log, since.clone(), |at| superblock.contains(&at), random);
    for (at, keeps) in &survivors {
        write(*at, &|sector| keeps[sector]);
    }
    let writes = |entries: Range<usize>| entries.filter(|at| !log.entries[*at].bytes.is_empty()).count();
    [writes(0..log.entries.len()), writes(since), survivors.len()]
}

//! The log of a disk: writes and flushes in their order, and marks.
//!
//! Owns the format of the log of QEMU's `blklogwrites`, which is that of Linux' dm-log-writes. What a power cut leaves
//! of the disk is in `cuts.rs`.
//!
//! Start at [`BlockLog::read`].

use std::ops::Range;

/// The first eight bytes of every log.
const MAGIC: u64 = 0x006a_7366_7773_6872;
/// Bytes of a sector, on every disk here.
pub const SECTOR: usize = 512;
const FLUSH: u64 = 1;
const DISCARD: u64 = 4;

/// One entry of the log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// Where on the disk its bytes belong.
    pub at: usize,
    /// Where its bytes are in the log; empty for a flush without data.
    pub bytes: Range<usize>,
    /// Whether all entries before it are on the disk when it is completed.
    pub is_flush: bool,
}

/// A disk, and everything that was written to it.
#[derive(Debug)]
pub struct BlockLog {
    /// The disk before the first entry.
    pub base: Vec<u8>,
    /// The entries, in order.
    pub entries: Vec<Entry>,
    log: Vec<u8>,
}

impl BlockLog {
    /// Reads `log`, recorded on a disk that held `base`.
    pub fn read(base: Vec<u8>, log: Vec<u8>) -> Self {
        let word = |at: usize| u64::from_le_bytes(log[at..at + 8].try_into().expect("eight bytes"));
        let count = word(16);
        assert_eq!((word(0), word(8), word(24) as u32 as usize), (MAGIC, 1, SECTOR), "this is no log of blocks");
        let (mut entries, mut at) = (Vec::new(), SECTOR);
        for _ in 0..count {
            let (sector, sectors, flags) = (word(at), word(at + 8) as usize, word(at + 16));
            at += SECTOR;
            // Discarded blocks keep their content here: nothing may rely on a discard.
            let length = if flags & DISCARD == 0 { sectors * SECTOR } else { 0 };
            entries.push(Entry { at: sector as usize * SECTOR, bytes: at..at + length, is_flush: flags & FLUSH != 0 });
            at += length;
        }
        Self { base, entries, log }
    }

    /// Writes those sectors of the entry to `disk` for which `keeps` is true.
    pub fn apply(&self, entry: &Entry, disk: &mut [u8], mut keeps: impl FnMut(usize) -> bool) {
        for (sector, bytes) in self.bytes(entry).chunks(SECTOR).enumerate() {
            let at = entry.at + sector * SECTOR;
            if keeps(sector) {
                disk[at..at + bytes.len()].copy_from_slice(bytes);
            }
        }
    }

    /// The bytes of the entry.
    pub fn bytes(&self, entry: &Entry) -> &[u8] {
        &self.log[entry.bytes.clone()]
    }

    /// The number of flushes.
    pub fn flushes(&self) -> usize {
        self.entries.iter().filter(|entry| entry.is_flush).count()
    }
}

#[cfg(test)]
pub mod tests {
    use super::{BlockLog, DISCARD, FLUSH, MAGIC, SECTOR};

    /// A log of these entries: sector, what each byte of it is, how many sectors, flags.
    pub fn log(disk_sectors: usize, entries: &[(u64, u8, u64, u64)]) -> BlockLog {
        let sector = |words: &[u64]| {
            let mut sector: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
            sector.resize(SECTOR, 0);
            sector
        };
        let mut bytes = sector(&[MAGIC, 1, entries.len() as u64, SECTOR as u64]);
        for (at, byte, sectors, flags) in entries {
            bytes.extend(sector(&[*at, *sectors, *flags, 0]));
            if flags & DISCARD == 0 {
                bytes.resize(bytes.len() + *sectors as usize * SECTOR, *byte);
            }
        }
        BlockLog::read(vec![0; disk_sectors * SECTOR], bytes)
    }

    #[test]
    fn a_log_is_read_as_it_was_kept() {
        let log = log(8, &[(2, 7, 3, 0), (0, 0, 0, FLUSH), (4, 0, 2, DISCARD), (7, 9, 1, 0)]);
        let told = |at: usize| (log.entries[at].at / SECTOR, log.entries[at].bytes.len() / SECTOR);
        assert_eq!([told(0), told(1), told(2), told(3)], [(2, 3), (0, 0), (4, 0), (7, 1)]);
        assert!(log.entries[1].is_flush && log.flushes() == 1);
        let mut disk = log.base.clone();
        for entry in &log.entries {
            log.apply(entry, &mut disk, |sector| sector != 1);
        }
        let sectors: Vec<u8> = disk.chunks(SECTOR).map(|sector| sector[0]).collect();
        assert_eq!(sectors, [0, 0, 7, 0, 7, 0, 0, 9]);
    }
}

//! The partition table of a disk: GPT, in sectors of 512 bytes.
//!
//! Owns the reading of a table, the change of an entry's name and type, and the two copies that are written. Never opens a
//! device. Own code, because a crate for it would write to the disk by itself, and `sfdisk` cannot write a table to two
//! places in an order of ours.
//!
//! # Source
//! UEFI Specification 2.10, chapter 5.3.
//!
//! Start at [`Table::parse`] and [`Table::copies`].

use std::array;

/// Bytes of a sector, of an entry, and of a header.
pub(crate) const SECTOR: u64 = 512;
const ENTRY: usize = 128;
const HEADER: usize = 92;
/// Entries of a table, and the sectors that they take.
const ENTRIES: usize = 128;
const ENTRIES_SECTORS: u64 = 32;
/// Bytes at the beginning of a disk that hold its table: the protective MBR, the header, the entries.
pub(crate) const LENGTH: usize = (2 + ENTRIES_SECTORS as usize) * SECTOR as usize;
/// The first sector of a partition of ours.
const FIRST: u64 = 2_048;
/// Where in the MBR the size of the protective partition is, in sectors.
const PROTECTED: usize = 446 + 12;
const SIGNATURE: [u8; 8] = *b"EFI PART";
/// The type of a partition that firmware starts from.
pub(crate) const EFI_SYSTEM: [u8; 16] =
    [0x28, 0x73, 0x2a, 0xc1, 0x1f, 0xf8, 0xd2, 0x11, 0xba, 0x4b, 0x00, 0xa0, 0xc9, 0x3e, 0xc9, 0x3b];

/// A partition table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Table {
    mbr: Vec<u8>,
    disk: [u8; 16],
    entries: Vec<[u8; ENTRY]>,
}

/// A partition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Partition {
    /// From 1.
    pub(crate) number: usize,
    /// The first sector.
    pub(crate) start: u64,
    /// How many sectors it has.
    pub(crate) sectors: u64,
}

/// The two copies of a table, for a disk of some size.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Copies {
    /// From the beginning of the disk.
    pub(crate) first: Vec<u8>,
    /// From the byte `second_at` until the end of the disk.
    pub(crate) second: Vec<u8>,
    pub(crate) second_at: u64,
}

impl Table {
    /// The table in the first [`LENGTH`] bytes of a disk; `None` if there is none, or if it is damaged.
    pub(crate) fn parse(bytes: &[u8]) -> Option<Self> {
        let header = bytes.get(SECTOR as usize..SECTOR as usize + HEADER)?;
        let entries = bytes.get(2 * SECTOR as usize..LENGTH)?;
        let number = |at: usize| u32::from_le_bytes(array::from_fn(|byte| header[at + byte]));
        let is_ours = header[..8] == SIGNATURE
            && number(12) as usize == HEADER
            && (number(80) as usize, number(84) as usize) == (ENTRIES, ENTRY);
        let blank = [&header[..16], &[0; 4], &header[20..]].concat();
        let is_whole = number(16) == crc32fast::hash(&blank) && number(88) == crc32fast::hash(entries);
        (is_ours && is_whole).then(|| Self {
            mbr: bytes[..SECTOR as usize].to_vec(),
            disk: array::from_fn(|byte| header[56 + byte]),
            entries: entries.chunks_exact(ENTRY).map(|entry| array::from_fn(|byte| entry[byte])).collect(),
        })
    }

    /// The partition of this name.
    pub(crate) fn find(&self, name: &str) -> Option<Partition> {
        let at = self.entries.iter().position(|entry| is_used(entry) && name_of(entry) == name)?;
        let entry = &self.entries[at];
        let (start, last) = (sector(entry, 32), sector(entry, 40));
        let sectors = last.checked_sub(start)?.checked_add(1)?;
        Some(Partition { number: at + 1, start, sectors })
    }

    /// The first sector behind all partitions but the one of the name `name`.
    pub(crate) fn end_without(&self, name: &str) -> u64 {
        let others = self.entries.iter().filter(|entry| is_used(entry) && name_of(entry) != name);
        others.map(|entry| sector(entry, 40).saturating_add(1)).max().unwrap_or(FIRST)
    }

    /// Gives the partition `number` this name, and makes firmware start from it.
    pub(crate) fn start_from(&mut self, number: usize, name: &str) {
        let entry = &mut self.entries[number - 1];
        entry[..16].copy_from_slice(&EFI_SYSTEM);
        entry[56..].fill(0);
        for (place, unit) in entry[56..].chunks_exact_mut(2).zip(name.encode_utf16()) {
            place.copy_from_slice(&unit.to_le_bytes());
        }
    }

    /// Takes the entry of the partition `number` from `other`.
    pub(crate) fn take(&mut self, number: usize, other: &Self) {
        self.entries[number - 1] = other.entries[number - 1];
    }

    /// What is written to a disk of `sectors` sectors.
    pub(crate) fn copies(&self, sectors: u64) -> Copies {
        let entries = self.entries.concat();
        let last = sectors - 1;
        let mut mbr = self.mbr.clone();
        let protected = u32::try_from(last).unwrap_or(u32::MAX);
        mbr[PROTECTED..PROTECTED + 4].copy_from_slice(&protected.to_le_bytes());
        let first = [mbr, self.header(1, last, 2, sectors, &entries), entries.clone()].concat();
        let at = last - ENTRIES_SECTORS;
        let second = [entries.clone(), self.header(last, 1, at, sectors, &entries)].concat();
        Copies { first, second, second_at: at * SECTOR }
    }

    /// The sector of the header that is at sector `own`, its copy at `other`, its entries from `entries_at` on.
    fn header(&self, own: u64, other: u64, entries_at: u64, sectors: u64, entries: &[u8]) -> Vec<u8> {
        let last_usable = sectors - ENTRIES_SECTORS - 2;
        let mut header =
            [&SIGNATURE[..], &0x1_0000_u32.to_le_bytes(), &(HEADER as u32).to_le_bytes(), &[0; 8]].concat();
        for number in [own, other, FIRST, last_usable] {
            header.extend(number.to_le_bytes());
        }
        header.extend(self.disk);
        header.extend(entries_at.to_le_bytes());
        for number in [ENTRIES as u32, ENTRY as u32, crc32fast::hash(entries)] {
            header.extend(number.to_le_bytes());
        }
        let sum = crc32fast::hash(&header);
        header[16..20].copy_from_slice(&sum.to_le_bytes());
        header.resize(SECTOR as usize, 0);
        header
    }
}

fn is_used(entry: &[u8; ENTRY]) -> bool {
    entry[..16] != [0; 16]
}

fn sector(entry: &[u8; ENTRY], at: usize) -> u64 {
    u64::from_le_bytes(array::from_fn(|byte| entry[at + byte]))
}

fn name_of(entry: &[u8; ENTRY]) -> String {
    let units = entry[56..].chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]]));
    let units: Vec<u16> = units.take_while(|unit| *unit != 0).collect();
    String::from_utf16_lossy(&units)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::{Copies, ENTRIES, ENTRY, LENGTH, Partition, SECTOR, Table};

    /// A table with partitions of these names, first and last sectors, by their numbers.
    pub(crate) fn table(partitions: &[(usize, &str, u64, u64)]) -> Table {
        let mut table = Table { mbr: vec![7; SECTOR as usize], disk: [9; 16], entries: vec![[0; ENTRY]; ENTRIES] };
        for (number, name, start, last) in partitions {
            table.start_from(*number, name);
            let entry = &mut table.entries[number - 1];
            entry[32..40].copy_from_slice(&start.to_le_bytes());
            entry[40..48].copy_from_slice(&last.to_le_bytes());
        }
        table
    }

    #[test]
    fn a_table_is_read_back_as_it_was_written() {
        let table = table(&[(1, "dreams_boot", 2_048, 4_095), (7, "dreams_spare", 8_192, 10_239)]);
        let Copies { first, second, second_at } = table.copies(20_480);
        assert_eq!((first.len(), second.len() as u64 + second_at), (LENGTH, 20_480 * SECTOR));
        let read = Table::parse(&first).unwrap();
        assert_eq!(read.entries, table.entries);
        assert_eq!(read.find("dreams_spare"), Some(Partition { number: 7, start: 8_192, sectors: 2_048 }));
        assert_eq!(
            (read.find("dreams_a"), read.end_without(""), read.end_without("dreams_spare")),
            (None, 10_240, 4_096)
        );
        assert_eq!(read.copies(20_480).first, first);
    }

    #[test]
    fn a_table_with_any_byte_changed_is_none() {
        let first = table(&[(1, "dreams_boot", 2_048, 4_095)]).copies(20_480).first;
        for at in [512, 524, 530, 552, 600, 610, 1_024, 1_100, 17_407] {
            let mut changed = first.clone();
            changed[at] ^= 1;
            assert_eq!(Table::parse(&changed), if at == 610 { Table::parse(&first) } else { None }, "byte {at}");
        }
        assert_eq!((Table::parse(&first[..17_000]), Table::parse(&vec![0; LENGTH])), (None, None));
    }
}

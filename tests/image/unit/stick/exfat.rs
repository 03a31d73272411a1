//! Files on exFAT, the file system of new sticks.
//!
//! Owns writing files into a file system that `mkfs.exfat` made; `fsck.exfat` checks the result. exfatprogs has no tool
//! that copies files, mtools knows FAT only, and mounting needs root and a kernel with exFAT, which the guests of
//! `tests/vkms` do not have. Every file and folder is contiguous, so that no cluster chains are needed. Names are
//! ASCII.
//!
//! Start at [`make`].

use crate::programs::succeed;
use std::fs::{self, File};
use std::os::unix::fs::FileExt;
use std::path::Path;
use std::process::Command;

/// The size of a directory entry, and its types.
const ENTRY: usize = 32;
const BITMAP: u8 = 0x81;
const FILE: u8 = 0x85;
const STREAM: u8 = 0xC0;
const NAME: u8 = 0xC1;
/// Characters of a name in one entry.
const NAME_PART: usize = 15;
const IS_FOLDER: u16 = 0x10;
/// Flags: the entry may have clusters; they are contiguous.
const MAY_HAVE: u8 = 1;
const IN_ONE_PIECE: u8 = 3;
/// The first day of 1980, the epoch of the timestamps.
const FIRST_DAY: u32 = 0x21 << 16;

/// A file system that is being filled.
struct Exfat {
    image: File,
    /// Where its clusters begin, and the size of each, in bytes.
    heap: u64,
    cluster: u64,
    root: u32,
    /// The allocation bitmap, and where it is.
    map_at: u64,
    map: Vec<u8>,
}

/// Makes the file system `image` of `bytes` bytes with the files in `folder`.
pub(crate) fn make(image: &Path, bytes: u64, folder: &Path) {
    File::create(image).unwrap().set_len(bytes).unwrap();
    succeed(Command::new("mkfs.exfat").args(["-c", "32K"]).arg(image));
    let mut exfat = Exfat::open(image);
    let (root, map_at) = (exfat.root, exfat.map_at);
    let mut entries = exfat.read(root);
    entries.truncate(entries.chunks(ENTRY).take_while(|entry| entry[0] != 0).count() * ENTRY);
    entries.extend(exfat.folder(folder));
    assert!(entries.len() as u64 <= exfat.cluster, "the root has one cluster");
    exfat.write(root, &entries);
    exfat.image.write_all_at(&exfat.map, map_at).unwrap();
    succeed(Command::new("fsck.exfat").arg("-n").arg(image));
}

impl Exfat {
    fn open(image: &Path) -> Self {
        let image = File::options().read(true).write(true).open(image).unwrap();
        let mut boot = [0; 512];
        image.read_exact_at(&mut boot, 0).unwrap();
        let word = |at: usize| u32::from_le_bytes(boot[at..at + 4].try_into().unwrap());
        let (sector, cluster) = (1 << boot[108], 1 << (boot[108] + boot[109]));
        let (heap, root) = (u64::from(word(88)) * sector, word(96));
        let mut exfat = Self { image, heap, cluster, root, map_at: 0, map: Vec::new() };
        let entries = exfat.read(root);
        let map = entries.chunks(ENTRY).find(|entry| entry[0] == BITMAP).unwrap();
        let number = |range: std::ops::Range<usize>| u64::from_le_bytes(map[range].try_into().unwrap());
        exfat.map_at = exfat.at(u32::try_from(number(20..28) & 0xFFFF_FFFF).unwrap());
        exfat.map = vec![0; usize::try_from(number(24..32)).unwrap()];
        exfat.image.read_exact_at(&mut exfat.map, exfat.map_at).unwrap();
        exfat
    }

    /// Where a cluster begins; the first one has number 2.
    fn at(&self, cluster: u32) -> u64 {
        self.heap + u64::from(cluster - 2) * self.cluster
    }

    fn read(&self, cluster: u32) -> Vec<u8> {
        let mut bytes = vec![0; usize::try_from(self.cluster).unwrap()];
        self.image.read_exact_at(&mut bytes, self.at(cluster)).unwrap();
        bytes
    }

    fn write(&self, cluster: u32, bytes: &[u8]) {
        self.image.write_all_at(bytes, self.at(cluster)).unwrap();
    }

    /// Allocates `count` clusters after all allocated ones; returns the first.
    fn take(&mut self, count: u64) -> u32 {
        let is_taken = |map: &[u8], at: usize| map[at / 8] & (1 << (at % 8)) != 0;
        let first = (0..self.map.len() * 8).rev().find(|at| is_taken(&self.map, *at)).unwrap() + 1;
        for at in first..first + usize::try_from(count).unwrap() {
            self.map[at / 8] |= 1 << (at % 8);
        }
        u32::try_from(first).unwrap() + 2
    }

    /// Writes the files in `folder`; returns their directory entries.
    fn folder(&mut self, folder: &Path) -> Vec<u8> {
        let mut names: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        names.sort();
        let mut entries = Vec::new();
        for name in names {
            let path = folder.join(&name);
            let is_folder = path.is_dir();
            let mut bytes = if is_folder { self.folder(&path) } else { fs::read(&path).unwrap() };
            let clusters = (bytes.len() as u64).div_ceil(self.cluster).max(u64::from(is_folder));
            if is_folder {
                bytes.resize(usize::try_from(clusters * self.cluster).unwrap(), 0);
            }
            let first = if clusters > 0 { self.take(clusters) } else { 0 };
            if clusters > 0 {
                self.write(first, &bytes);
            }
            entries.extend(entry(name.to_str().unwrap(), is_folder, first, bytes.len() as u64));
        }
        entries
    }
}

/// The directory entries of a file or folder.
fn entry(name: &str, is_folder: bool, first: u32, bytes: u64) -> Vec<u8> {
    let utf16 = |text: &str| text.encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<u8>>();
    let parts = name.len().div_ceil(NAME_PART);
    let mut file = [0; ENTRY];
    file[0] = FILE;
    file[1] = u8::try_from(1 + parts).unwrap();
    file[4..6].copy_from_slice(&if is_folder { IS_FOLDER } else { 0 }.to_le_bytes());
    for time in [8, 12, 16] {
        file[time..time + 4].copy_from_slice(&FIRST_DAY.to_le_bytes());
    }
    let mut stream = [0; ENTRY];
    stream[0] = STREAM;
    stream[1] = if first == 0 { MAY_HAVE } else { IN_ONE_PIECE };
    stream[3] = u8::try_from(name.len()).unwrap();
    let hash = utf16(&name.to_ascii_uppercase()).into_iter().fold(0, sum);
    stream[4..6].copy_from_slice(&hash.to_le_bytes());
    stream[8..16].copy_from_slice(&bytes.to_le_bytes());
    stream[20..24].copy_from_slice(&first.to_le_bytes());
    stream[24..32].copy_from_slice(&bytes.to_le_bytes());
    let mut set = [file, stream].concat();
    for part in utf16(name).chunks(2 * NAME_PART) {
        let mut entry = [0; ENTRY];
        entry[0] = NAME;
        entry[2..2 + part.len()].copy_from_slice(part);
        set.extend(entry);
    }
    // Over all but itself.
    let checksum = set.iter().enumerate().filter(|(at, _)| !matches!(at, 2 | 3)).map(|(_, byte)| *byte).fold(0, sum);
    set[2..4].copy_from_slice(&checksum.to_le_bytes());
    set
}

/// exFAT's checksum of names and entries: rotated by a bit before each byte.
fn sum(sum: u16, byte: u8) -> u16 {
    sum.rotate_right(1).wrapping_add(u16::from(byte))
}

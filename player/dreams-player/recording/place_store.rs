//! The walk's place on disk: a power cut loses at most the clip being played.
//!
//! Owns two files, written alternately: a number, the place, and a checksum over both. Whatever a power cut leaves of the
//! file being written, the other one is whole. Never knows what a place means: the flock does.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// The names of the files.
const FILES: [&str; 2] = ["place.0", "place.1"];
/// What a file begins with: its kind and version.
const MAGIC: &[u8; 8] = b"d-place\x01";
/// Magic, number, length of the place.
const HEAD: usize = 8 + 8 + 4;
/// CRC-32 of all before it.
const TAIL: usize = 4;

/// The two files of a unit.
#[derive(Debug)]
pub(crate) struct PlaceStore {
    dir: PathBuf,
    /// Which file is written next: never the one that holds the newest place.
    next: usize,
    /// The number that it gets.
    number: u64,
}

impl PlaceStore {
    /// Opens the files in `dir`, which is made if it is not there, and reads the newest whole place.
    ///
    /// # Errors
    /// What the file system says of `dir`. A file that is not whole or cannot be read is no error: it is the one to
    /// write next.
    pub(crate) fn open(dir: &Path) -> io::Result<(Self, Option<Vec<u8>>)> {
        fs::create_dir_all(dir)?;
        let newest = newest(dir);
        let (next, number) = newest.as_ref().map_or((0, 1), |(file, number, _)| (1 - file, number + 1));
        Ok((Self { dir: dir.to_owned(), next, number }, newest.map(|(_, _, place)| place)))
    }

    /// Saves `place`; returns when the disk has it.
    ///
    /// # Errors
    /// What the file system says. The place saved before stays.
    pub(crate) fn save(&mut self, place: &[u8]) -> io::Result<()> {
        let path = self.dir.join(FILES[self.next]);
        let bytes = written(self.number, place);
        if self.write(&path, &bytes).is_err() {
            // The file itself may be broken: a bad sector, or a folder of its name. Another attempt with a new file; the
            // broken one stays under another name, so that its bad sector is not used again.
            fs::rename(&path, self.dir.join(format!("{}.bad", FILES[self.next])))?;
            self.write(&path, &bytes)?;
        }
        self.next = 1 - self.next;
        self.number += 1;
        Ok(())
    }

    fn write(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        let is_new = !path.exists();
        let mut file = File::create(path)?;
        file.write_all(bytes)?;
        file.sync_all()?;
        if is_new {
            File::open(&self.dir)?.sync_all()?;
        }
        Ok(())
    }
}

/// The newest whole place in `dir`, for a reader only.
pub(crate) fn saved_place(dir: &Path) -> Option<Vec<u8>> {
    newest(dir).map(|(_, _, place)| place)
}

/// The file of the newest whole place in `dir`, its number, and the place.
fn newest(dir: &Path) -> Option<(usize, u64, Vec<u8>)> {
    let mut newest: Option<(usize, u64, Vec<u8>)> = None;
    for (file, name) in FILES.iter().enumerate() {
        // A file that cannot be read is treated as torn: the other one may be whole.
        let Ok(bytes) = fs::read(dir.join(name)) else { continue };
        if let Some((number, place)) = read(&bytes)
            && newest.as_ref().is_none_or(|(_, best, _)| number > *best)
        {
            newest = Some((file, number, place.to_vec()));
        }
    }
    newest
}

/// The bytes of a file.
fn written(number: u64, place: &[u8]) -> Vec<u8> {
    let length = u32::try_from(place.len()).expect("a place is far smaller than 4 GiB");
    let mut bytes = Vec::with_capacity(HEAD + place.len() + TAIL);
    bytes.extend_from_slice(MAGIC);
    bytes.extend_from_slice(&number.to_le_bytes());
    bytes.extend_from_slice(&length.to_le_bytes());
    bytes.extend_from_slice(place);
    bytes.extend_from_slice(&crc32fast::hash(&bytes).to_le_bytes());
    bytes
}

/// The number and the place in the bytes of a file, if they are whole.
fn read(bytes: &[u8]) -> Option<(u64, &[u8])> {
    let (head, rest) = bytes.split_at_checked(HEAD)?;
    let number = u64::from_le_bytes(head[8..16].try_into().ok()?);
    let length = u32::from_le_bytes(head[16..].try_into().ok()?) as usize;
    let (place, tail) = rest.split_at_checked(length)?;
    let checksum = u32::from_le_bytes(tail.try_into().ok()?);
    let is_whole = head.starts_with(MAGIC) && checksum == crc32fast::hash(&bytes[..HEAD + length]);
    is_whole.then_some((number, place))
}

#[cfg(test)]
mod tests {
    use super::{FILES, PlaceStore, saved_place, written};
    use std::fs;

    fn newest(dir: &std::path::Path) -> Option<Vec<u8>> {
        PlaceStore::open(dir).unwrap().1
    }

    #[test]
    fn a_place_comes_back_after_any_number_of_saves() {
        let dir = tempfile::tempdir().unwrap();
        let state = dir.path().join("not/yet/there");
        assert!(saved_place(&state).is_none() && !state.exists(), "who only reads makes no folder");
        assert_eq!(newest(&state), None);
        for step in 0..5u8 {
            let (mut store, _) = PlaceStore::open(&state).unwrap();
            store.save(&[step; 9]).unwrap();
            store.save(&[step, 1]).unwrap();
            assert_eq!((newest(&state), saved_place(&state)), (Some(vec![step, 1]), Some(vec![step, 1])));
        }
    }

    #[test]
    fn a_save_torn_at_any_byte_leaves_the_place_before() {
        let dir = tempfile::tempdir().unwrap();
        let (mut store, _) = PlaceStore::open(dir.path()).unwrap();
        for place in [&b"oldest, and the longest of them all"[..], b"before"] {
            store.save(place).unwrap();
        }
        let torn = dir.path().join(FILES[0]);
        let (old, new) = (fs::read(&torn).unwrap(), written(3, b"the newest"));
        for cut in 0..new.len() {
            // The file was emptied and refilled up to the cut, or its blocks still hold the old bytes behind it.
            fs::write(&torn, &new[..cut]).unwrap();
            assert_eq!(newest(dir.path()).as_deref(), Some(&b"before"[..]), "cut at {cut}");
            let mut mixed = new[..cut].to_vec();
            mixed.extend_from_slice(&old[cut..]);
            fs::write(&torn, &mixed).unwrap();
            assert_eq!(newest(dir.path()).as_deref(), Some(&b"before"[..]), "mixed at {cut}");
        }
        fs::write(&torn, &new).unwrap();
        assert_eq!(newest(dir.path()).as_deref(), Some(&b"the newest"[..]));
    }

    #[test]
    fn a_slot_that_cannot_be_read_costs_neither_the_other_one_nor_the_next_places() {
        for broken in FILES {
            let dir = tempfile::tempdir().unwrap();
            let (mut store, _) = PlaceStore::open(dir.path()).unwrap();
            store.save(b"one").unwrap();
            store.save(b"two").unwrap();
            fs::remove_file(dir.path().join(broken)).unwrap();
            fs::create_dir(dir.path().join(broken)).unwrap();
            let (mut store, kept) = PlaceStore::open(dir.path()).unwrap();
            assert_eq!(kept, Some(if broken == FILES[0] { b"two" } else { b"one" }.to_vec()));
            for place in [b"next", b"last"] {
                store.save(place).unwrap();
                assert_eq!(newest(dir.path()).as_deref(), Some(&place[..]));
            }
        }
    }

    #[test]
    fn a_flipped_bit_anywhere_is_seen() {
        let whole = written(7, b"somewhere");
        for bit in 0..whole.len() * 8 {
            let mut bytes = whole.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(super::read(&bytes), None, "bit {bit}");
        }
        assert_eq!(super::read(&whole), Some((7, &b"somewhere"[..])));
    }
}

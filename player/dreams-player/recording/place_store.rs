//! The walk's place on disk: a power cut loses at most the clip that is playing.
//!
//! Owns the form of the two files: a number, the place, and a checksum over both. They are written in turn, so that one
//! of them is whole at every moment ([`durable::Copies`]). Never knows what a place means: the flock does.

use durable::{Checksummed, Copies, Found, LocalFolder, framed, unframed};
use std::fs;
use std::io;
use std::path::Path;

/// What a file begins with: its kind and version.
const MAGIC: [u8; 8] = *b"d-place\x01";

/// The bytes of a place.
#[derive(Debug, PartialEq, Eq)]
struct SavedPlace(Vec<u8>);

/// The two files of a unit.
#[derive(Debug)]
pub(crate) struct PlaceStore {
    folder: LocalFolder,
    copies: Copies<SavedPlace>,
}

impl PlaceStore {
    /// Opens the files in `dir`, which is made if it is not there, and reads the newest whole place.
    /// Errors: What the file system says of `dir`. A file that is not whole or cannot be read is no error: it is the one to
    /// write next.
    pub(crate) fn open(dir: &Path) -> io::Result<(Self, Option<Vec<u8>>)> {
        fs::create_dir_all(dir)?;
        let folder = LocalFolder::new(dir);
        let (copies, found) = Copies::read(&folder);
        Ok((Self { folder, copies }, place(found)))
    }

    /// Saves `place`; returns when the disk has it.
    /// Errors: What the file system says. The place saved before stays.
    pub(crate) fn save(&mut self, place: &[u8]) -> io::Result<()> {
        self.copies.write_older(&self.folder, &SavedPlace(place.to_vec()))
    }
}

/// The newest whole place in `dir`, for a reader only.
pub(crate) fn saved_place(dir: &Path) -> Option<Vec<u8>> {
    place(Copies::read(&LocalFolder::new(dir)).1)
}

fn place(found: Found<SavedPlace>) -> Option<Vec<u8>> {
    match found {
        Found::State { state, .. } => Some(state.0),
        Found::Nothing | Found::Damaged | Found::Unreadable(_) => None,
    }
}

impl Checksummed for SavedPlace {
    const FILES: [&'static str; 2] = ["place.0", "place.1"];
    const LIMIT: u64 = u32::MAX as u64;

    fn to_file(&self, number: u64) -> io::Result<Vec<u8>> {
        framed(MAGIC, number, &self.0)
    }

    fn from_file(bytes: &[u8]) -> Option<(u64, Self)> {
        let (number, place) = unframed(MAGIC, bytes)?;
        Some((number, Self(place.to_vec())))
    }
}

#[cfg(test)]
mod tests {
    use super::{Checksummed, PlaceStore, SavedPlace, saved_place};
    use std::fs;
    use std::path::Path;

    fn newest(dir: &Path) -> Option<Vec<u8>> {
        PlaceStore::open(dir).unwrap().1
    }

    #[test]
    fn a_place_comes_back_after_any_number_of_saves() {
        let dir = tempfile::tempdir().unwrap();
        let state = dir.path().join("not/yet/there");
        assert!(saved_place(&state).is_none() && !state.exists(), "a reader makes no folder");
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
        let torn = dir.path().join(SavedPlace::FILES[0]);
        let (old, new) = (fs::read(&torn).unwrap(), SavedPlace(b"the newest".to_vec()).to_file(3).unwrap());
        for cut in 0..new.len() {
            // The file was emptied and refilled up to the cut, or its blocks still hold the old bytes behind it.
            fs::write(&torn, &new[..cut]).unwrap();
            assert_eq!(newest(dir.path()).as_deref(), Some(&b"before"[..]), "cut at {cut}");
            fs::write(&torn, [&new[..cut], &old[cut..]].concat()).unwrap();
            assert_eq!(newest(dir.path()).as_deref(), Some(&b"before"[..]), "mixed at {cut}");
        }
        fs::write(&torn, &new).unwrap();
        assert_eq!(newest(dir.path()).as_deref(), Some(&b"the newest"[..]));
    }

    #[test]
    fn a_flipped_bit_anywhere_is_seen() {
        let whole = SavedPlace(b"somewhere".to_vec()).to_file(7).unwrap();
        for bit in 0..whole.len() * 8 {
            let mut bytes = whole.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(SavedPlace::from_file(&bytes), None, "bit {bit}");
        }
        assert_eq!(SavedPlace::from_file(&whole), Some((7, SavedPlace(b"somewhere".to_vec()))));
    }
}

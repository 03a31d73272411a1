//! The corpus of a fuzzer, given to the function that it drives; for the tests of crates whose species are texts.
//!
//! Owns the walk over the files and the variations of each, which are the same on every machine. What must hold stands in the
//! target. Start at [`try_all`].

use std::fs;
use std::path::Path;

use species::Rng;

/// So many variations of each file.
const VARIATIONS: u64 = 60;

/// Gives `target` each file of `folder`, at least `least` of them, and variations in which some of `letters` are inserted.
/// Files whose names begin with `good` must be accepted, and no others.
pub(crate) fn try_all(folder: &Path, least: usize, letters: &[u8], target: fn(&[u8]) -> bool) {
    let mut files: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(files.len() >= least, "only {} files", files.len());
    for (number, path) in (0..).zip(&files) {
        let bytes = fs::read(path).unwrap();
        let is_good = path.file_name().unwrap().to_str().unwrap().starts_with("good");
        assert_eq!(target(&bytes), is_good, "{}", path.display());
        for variation in 0..VARIATIONS {
            target(&varied(&bytes, letters, &mut Rng::stream(number, variation)));
        }
    }
}

/// `bytes` with up to three things done to them.
fn varied(bytes: &[u8], letters: &[u8], rng: &mut Rng) -> Vec<u8> {
    let mut below = |count: usize| (rng.unit() * count as f64) as usize;
    let mut bytes = bytes.to_vec();
    for _ in 0..=below(3) {
        let at = below(bytes.len() + 1);
        match below(4) {
            0 if at < bytes.len() => bytes[at] ^= 1 << below(8),
            1 => bytes.insert(at, letters[below(letters.len())]),
            2 => bytes = [&bytes[..at], &bytes[at / 2..]].concat(),
            _ if at < bytes.len() => drop(bytes.remove(at)),
            _ => {}
        }
    }
    bytes
}

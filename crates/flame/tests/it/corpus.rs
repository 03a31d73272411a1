//! The corpus of the fuzzer, given to the same function that it drives.
//!
//! Each file as it is, and with some hundred things done to it, the same on every machine. What must hold stands in
//! `fuzz/target.rs`; `cargo +nightly fuzz run genome` looks further.

#[path = "../../fuzz/target.rs"]
mod target;

use std::fs;
use std::path::Path;

use flame::Rng;

/// So many variations of each file, of which one in so many is drawn.
const VARIATIONS: u64 = 400;
const DRAWN: u64 = 4;

#[test]
fn a_genome_is_refused_or_read_just_as_it_is_written_and_drawn_whatever_bytes_it_is_made_of() {
    let mut drawn = 0;
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus/genome");
    let mut files: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(files.len() >= 40, "only {} files", files.len());
    let all: Vec<Vec<u8>> = files.iter().map(|path| fs::read(path).unwrap()).collect();
    for ((number, bytes), path) in (0..).zip(&all).zip(&files) {
        let is_good = path.file_name().unwrap().to_str().unwrap().starts_with("good");
        assert_eq!(target::genome(bytes), is_good, "{}", path.display());
        drawn += u64::from(target::picture(bytes));
        for variation in 0..VARIATIONS {
            let varied = varied(bytes, &all, &mut Rng::stream(number, variation));
            target::genome(&varied);
            drawn += if variation.is_multiple_of(DRAWN) { u64::from(target::picture(&varied)) } else { 0 };
        }
    }
    assert!(drawn > files.len() as u64, "only {drawn} were drawn");
}

/// `bytes` with up to three things done to them.
fn varied(bytes: &[u8], others: &[Vec<u8>], rng: &mut Rng) -> Vec<u8> {
    let mut below = |count: usize| (rng.unit() * count as f64) as usize;
    let mut bytes = bytes.to_vec();
    for _ in 0..=below(3) {
        let at = below(bytes.len() + 1);
        let other = &others[below(others.len())];
        match below(7) {
            0 if at < bytes.len() => bytes[at] ^= 1 << below(8),
            1 => bytes.truncate(at),
            2 => bytes.insert(at, below(256) as u8),
            3 => bytes.insert(at, b"\n \"<&;/>=-09e."[below(14)]),
            4 => bytes = [&bytes[..at], &other[at.min(other.len())..]].concat(),
            5 => bytes = [&bytes[..at], &bytes[at / 2..]].concat(),
            _ if at < bytes.len() => drop(bytes.remove(at)),
            _ => {}
        }
    }
    bytes
}

//! The corpus of the fuzzer, given to the same function that it drives.
//!
//! Each file as it is, and with some things done to it, the same on every machine. What must hold stands in
//! `fuzz/target.rs`; `cargo +nightly fuzz run genome` looks further.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

#[path = "../fuzz/target.rs"]
mod target;

use std::fs;
use std::path::Path;

use species::Rng;

/// So many variations of each file.
const VARIATIONS: u64 = 60;

#[test]
fn a_plant_is_refused_or_read_just_as_it_is_written_and_drawn_whatever_bytes_it_is_made_of() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus/genome");
    let mut files: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(files.len() >= 16, "only {} files", files.len());
    for (number, path) in (0..).zip(&files) {
        let bytes = fs::read(path).unwrap();
        let is_good = path.file_name().unwrap().to_str().unwrap().starts_with("good");
        assert_eq!(target::genome(&bytes), is_good, "{}", path.display());
        for variation in 0..VARIATIONS {
            let mut rng = Rng::stream(number, variation);
            let mut below = |count: usize| (rng.unit() * count as f64) as usize;
            let mut varied = bytes.clone();
            for _ in 0..=below(3) {
                let at = below(varied.len() + 1);
                match below(4) {
                    0 if at < varied.len() => varied[at] ^= 1 << below(8),
                    1 => varied.insert(at, b"\n \"='#[]{},_+-09e."[below(18)]),
                    2 => varied = [&varied[..at], &varied[at / 2..]].concat(),
                    _ if at < varied.len() => drop(varied.remove(at)),
                    _ => {}
                }
            }
            target::genome(&varied);
        }
    }
}

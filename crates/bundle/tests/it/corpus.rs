//! The corpus of the fuzzer, given to the same functions that it drives.
//!
//! Each file as it is, and with some hundred things done to it, the same on every machine. What must hold stands in
//! `fuzz/targets.rs`; `cargo +nightly fuzz run TARGET` looks further.

#[path = "../../../../fuzz/targets.rs"]
mod targets;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::fs;
use std::path::Path;

/// So many variations of each file.
const VARIATIONS: u64 = 400;

/// Gives `target` every file of its corpus, which it takes in if the name begins with `good`, and variations.
fn replay(name: &str, target: fn(&[u8]) -> bool) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus").join(name);
    let mut files: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(files.len() >= 5, "{name} has a corpus");
    let all: Vec<Vec<u8>> = files.iter().map(|path| fs::read(path).unwrap()).collect();
    for ((number, bytes), path) in (0u64..).zip(&all).zip(&files) {
        let is_good = path.file_name().unwrap().to_str().unwrap().starts_with("good");
        assert_eq!(target(bytes), is_good, "{}", path.display());
        for variation in 0..VARIATIONS {
            let mut random = ChaCha8Rng::seed_from_u64(number * VARIATIONS + variation);
            target(&varied(bytes, &all, &mut random));
        }
    }
}

/// `bytes` with up to three things done to them.
fn varied(bytes: &[u8], others: &[Vec<u8>], random: &mut ChaCha8Rng) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..=random.next_u32() % 3 {
        let at = random.next_u32() as usize % (bytes.len() + 1);
        let other = &others[random.next_u32() as usize % others.len()];
        match random.next_u32() % 7 {
            0 if at < bytes.len() => bytes[at] ^= 1 << (random.next_u32() % 8),
            1 => bytes.truncate(at),
            2 => bytes.insert(at, random.next_u32() as u8),
            3 => bytes.insert(at, b"\n \r\0/.0"[random.next_u32() as usize % 7]),
            4 => bytes = [&bytes[..at], &other[at.min(other.len())..]].concat(),
            5 => bytes = [&bytes[..at], &bytes[at / 2..]].concat(),
            _ if at < bytes.len() => drop(bytes.remove(at)),
            _ => {}
        }
    }
    bytes
}

#[test]
fn no_seal_is_taken_for_another_or_without_its_signature() {
    replay("seal", targets::seal);
}

#[test]
fn settings_are_read_only_signed_and_as_they_were_written() {
    replay("settings", targets::settings);
}

#[test]
fn no_list_of_files_leads_astray_or_is_read_otherwise_than_it_was_written() {
    replay("contents", targets::contents);
}

#[test]
fn no_statement_is_learned_unsigned_nor_says_more_than_one_thing() {
    replay("statement", targets::statement);
}

#[test]
fn a_bundle_is_taken_in_as_it_was_packed_or_not_at_all() {
    replay("bundle", targets::bundle);
}

//! What must hold whatever bytes a file of an expression is made of.
//!
//! Owns the function that a fuzzer drives, and that `tests/it/corpus.rs` drives over the corpus. It panics if a refusal is
//! not at its place, or if a genome is read otherwise than it was written, and returns whether the bytes were accepted.
//!
//! Start at [`genome`].

#![allow(clippy::panic, reason = "a target fails by panicking")]

use expression::{Genome, Loop, MOST_NS, Samples, Settings, cost};

/// Where a small frame is drawn, what it takes is known.
const SKETCH: Settings = Settings { size: [8, 6], samples: Samples::Sixteen, is_blurred: true };

/// A file: refused in few words with its place, or read, written and read again without a loss; and what its picture takes
/// is told within the limits, or refused.
pub(crate) fn genome(data: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(data) else { return false };
    let genome = match Genome::parse(text) {
        Ok(genome) => genome,
        Err(error) => {
            let words = error.to_string();
            assert!(words.len() < 400, "a message of {} bytes", words.len());
            let Some(place) = error.place() else { panic!("{words} has no place") };
            let line = text.split('\n').nth(place.line - 1).unwrap_or_default();
            assert!((1..=line.chars().count() + 1).contains(&place.column), "{words}, in a line of {line:?}");
            return false;
        }
    };
    let written = genome.to_string();
    match Genome::parse(&written) {
        Ok(again) => assert_eq!(again, genome, "read otherwise than it was written: {written}"),
        // What is not known and nearly too long is indented when it is written.
        Err(error) => {
            assert!(written.len() > expression::MOST_BYTES, "written so that it is refused, {error}: {written}");
        }
    }
    if let Ok(cost) = cost(&Loop::new(&genome, 60.0), 7.0, &SKETCH) {
        assert!(cost.ns_per_sample <= MOST_NS && cost.bytes + cost.bytes_per_thread < 200 << 20, "{cost:?}: {written}");
    }
    true
}

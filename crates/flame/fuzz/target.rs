//! What must hold whatever bytes a file of genomes is made of.
//!
//! Owns the function that a fuzzer drives, and that `tests/corpus.rs` drives over the corpus. It panics if a genome is
//! read otherwise than it was written, and tells whether the bytes were accepted.
//!
//! Start at [`genome`].

#![allow(clippy::panic, reason = "a target fails by panicking")]

use flame::{Genome, GenomeError, KeyFrames, Motion};

/// A file of genomes: refused with a message that fits on a screen, or read, written and read again without a loss.
pub(crate) fn genome(data: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(data) else { return false };
    let flames = match Genome::split(text) {
        Ok(flames) => flames,
        Err(error) => {
            let error = error.to_string();
            assert!(error.len() < 2000, "a message of {} bytes", error.len());
            return false;
        }
    };
    for (genome, part) in &flames {
        assert_eq!(first(part).as_ref().unwrap_or(genome), genome, "read otherwise where it stands alone");
        let written = genome.to_xml();
        // Numbers and defaults are written in full, so that a large text may become too large.
        match Genome::parse_all(&written) {
            Ok(again) => assert_eq!(again.first(), Some(genome), "read otherwise than it was written: {written}"),
            Err(GenomeError::Limit { .. }) => {}
            Err(error) => panic!("written so that it is refused, {error}: {written}"),
        }
    }
    let times = flames.iter().map(|(genome, _)| genome.time);
    let middle = f64::midpoint(times.clone().fold(f64::MAX, f64::min), times.fold(f64::MIN, f64::max));
    if let Ok(keys) = KeyFrames::new(flames.iter().map(|(genome, _)| genome.clone()).collect()) {
        assert!(
            keys.at(middle).xforms.len()
                <= flames.iter().map(|(genome, _)| genome.with_symmetry().xforms.len()).max().unwrap_or(0)
        );
    }
    !flames.is_empty()
}

/// The first genome of a text that is read without an error.
fn first(text: &str) -> Option<Genome> {
    Genome::parse_all(text).ok()?.into_iter().next()
}

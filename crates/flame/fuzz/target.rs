//! What must hold whatever bytes a file of genomes is made of.
//!
//! Owns the functions that a fuzzer drives, and that `tests/it/corpus.rs` drives over the corpus. They panic if a genome
//! is read otherwise than it was written, or is not drawn within its demand, and tell whether the bytes were accepted, and
//! drawn.
//!
//! Start at [`genome`] and [`picture`].

#![allow(clippy::panic, reason = "a target fails by panicking")]

use flame::{Backend, Flames, Genome, GenomeError, KeyFrames, Motion};
use species::{Settings, Species, Threads};

/// What would take longer, or more memory, is told and not tried.
const MOST_SAMPLES: u64 = 2_000_000;
const MOST_BYTES: u64 = 200 << 20;

/// A file of genomes: refused with a message that fits on a screen, or read, written and read again without a loss.
pub(crate) fn genome(data: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(data) else { return false };
    let mut flames = Vec::new();
    let parts = Genome::split(text);
    for part in parts.as_ref().into_iter().flatten() {
        flames.extend(part.genome.as_ref().ok().map(|genome| (genome.clone(), &part.text)));
    }
    let wrong = parts.as_ref().into_iter().flatten().filter_map(|part| part.genome.as_ref().err());
    for error in parts.as_ref().err().into_iter().chain(wrong) {
        let error = error.to_string();
        assert!(error.len() < 2000, "a message of {} bytes", error.len());
    }
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
    parts.is_ok_and(|parts| !parts.is_empty() && parts.iter().all(|part| part.genome.is_ok()))
}

/// A small picture of a file of one genome: refused, or drawn within its demand.
pub(crate) fn picture(data: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(data) else { return false };
    let Ok(genome) = (Flames { backend: Backend::PROCESSOR, coloured: Ok }).parse(text) else { return false };
    let settings = Settings {
        size: [16, 9],
        spp: Some(2.0),
        psnr: None,
        supersample: None,
        temporal_samples: Some(2),
        smooths: true,
        seed: 1,
    };
    let turning = genome.turning(settings.size, 60.0);
    let Ok(demand) = turning.demand(7.0, &settings) else { return false };
    if demand.samples > MOST_SAMPLES || demand.bytes > MOST_BYTES {
        return false;
    }
    let threads = Threads::new(1).unwrap_or_else(|error| panic!("{error}"));
    let drawn = turning.frame(7.0, &settings, &threads).unwrap_or_else(|error| panic!("{error}: {text}"));
    assert!(drawn.samples <= demand.samples, "{} of {demand:?}: {text}", drawn.samples);
    assert!(drawn.image.pixels.as_flattened().iter().all(|light| (0.0..=1.0).contains(light)), "no light: {text}");
    true
}

/// The first genome of a text that is read without an error.
fn first(text: &str) -> Option<Genome> {
    Genome::parse_all(text).ok()?.into_iter().next()
}

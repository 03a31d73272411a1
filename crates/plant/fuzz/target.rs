//! What must hold whatever bytes a file of a plant is made of.
//!
//! Owns the function that a fuzzer drives, and that `tests/it/corpus.rs` drives over the corpus and `tests/it/texts.rs`
//! over damaged texts. It panics if a genome is read otherwise than it was written, or is not drawn within its demand, and tells
//! whether the bytes were accepted.
//!
//! Start at [`genome`].

#![allow(clippy::panic, reason = "a target fails by panicking")]

use plant::Plant;
use species::{Genome, Settings, Threads};

/// A plant: refused with a place and a message that fits on a screen, or read, written and read again without a loss,
/// and drawn.
pub(crate) fn genome(data: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(data) else { return false };
    let plant = match Plant::parse(text) {
        Ok(plant) => plant,
        Err(error) => {
            assert!(error.place().is_some(), "refused without a place: {error}");
            let error = error.to_string();
            assert!(error.len() < 2000, "a message of {} bytes", error.len());
            return false;
        }
    };
    assert!(plant.genes.iter().all(|gene| (0.0..=1.0).contains(gene)), "a gene is out of its range: {text}");
    let written = plant.to_toml();
    match Plant::parse(&written) {
        Ok(again) => assert_eq!(again, plant, "read otherwise than it was written: {written}"),
        Err(error) => panic!("written so that it is refused, {error}: {written}"),
    }
    let settings = Settings {
        size: [16, 9],
        spp: None,
        psnr: None,
        supersample: None,
        temporal_samples: Some(1),
        smooths: false,
        seed: 0,
    };
    let motion = plant.turning(settings.size, 60.0);
    let threads = Threads::new(1).expect("a machine that fuzzes has threads");
    let demand = motion.demand(7.0, &settings).expect("the size is possible");
    assert!(demand.bytes < 200 << 20, "{demand:?}: {written}");
    let drawn = motion.frame(7.0, &settings, &threads).expect("what has a demand is drawn");
    assert!(drawn.samples <= demand.samples, "{}, {demand:?}: {written}", drawn.samples);
    assert!(drawn.image.pixels.as_flattened().iter().all(|light| (0.0..=1.0).contains(light)), "{written}");
    true
}

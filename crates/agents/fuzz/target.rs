//! What must hold whatever bytes a file of agents is made of.
//!
//! Owns the function that a fuzzer drives, and that `tests/it/corpus.rs` drives over the corpus. It panics if a globe is
//! read otherwise than it was written, or is not drawn within its demand, and returns whether the bytes were accepted.
//!
//! Start at [`globe`].

use agents::Globe;
use species::{Genome, Settings, Threads};

/// A file of agents: refused with its place in a message that fits on a screen, or read, written, read again and drawn.
pub(crate) fn globe(data: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(data) else { return false };
    let globe = match Globe::parse(text) {
        Ok(globe) => globe,
        Err(error) => {
            let error = error.to_string();
            assert!(error.starts_with("line ") && error.len() < 2000, "a message of {} bytes: {error}", error.len());
            return false;
        }
    };
    let written = globe.text();
    // Defaults are written in full, so that a large text may become too large.
    if written.len() <= agents::MOST_BYTES {
        assert_eq!(Globe::parse(&written).as_ref(), Ok(&globe), "read otherwise than it was written: {written}");
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
    let motion = globe.turning(settings.size, 60.0);
    let threads = Threads::new(1).expect("a machine that fuzzes has threads");
    let demand = motion.demand(7.0, &settings).expect("the size is possible");
    let drawn = motion.frame(7.0, &settings, &threads).expect("what has a demand is drawn");
    assert_eq!(drawn.samples, demand.samples, "{written}");
    assert!(drawn.image.pixels.as_flattened().iter().all(|light| (0.0..=1.0).contains(light)), "{written}");
    true
}

//! A clip for tests, encoded on the spot.
//!
//! Owns its size and its pictures. Never spoils it: the tests do.
//!
//! Start at [`encode`].

use std::path::Path;
use timing::Rate;
use video::{Encoder, Form, Quality, Tuning, Yuv420p};

/// Its width and height in pixels.
pub(crate) const SIZE: (u32, u32) = (64, 48);

/// A clip of two grey frames.
pub(crate) fn encode(clip: &Path) {
    let form = Form { size: SIZE, fps: Rate::new(30, 1).unwrap() };
    let mut encoder = Encoder::create(
        clip,
        &form,
        Quality { crf: 30.0, preset: "ultrafast", tuning: Tuning::Film, max_bits_per_second: None },
    )
    .unwrap();
    let grey = Yuv420p::from_planes(SIZE.0, SIZE.1, &[128; 64 * 48 * 3 / 2]).unwrap();
    for _ in 0..2 {
        encoder.push(&grey).unwrap();
    }
    encoder.finish().unwrap();
}

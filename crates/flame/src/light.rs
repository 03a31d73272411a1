//! How much light a moment has, measured on a small picture of few samples.
//!
//! Owns the small picture: its size, its samples and its seed, which are always the same, so that every process of a farm
//! measures the same. Never judges what it measures: `exposure.rs` does.
//!
//! Start at [`light`].

use crate::animate::Motion;
use crate::render::{Arithmetic, Backend, Filter, RenderError, Settings, draw_frame};
use species::{Light, Threads};

/// Pixels of the small picture in its longer direction.
const SIDE: f64 = 96.0;

/// Samples of each of its pixels: 0.3 million in all, 6 ms of a core.
const SAMPLES: f64 = 64.0;

/// The light of `motion` at `frame`.
/// Errors: As [`Renderer::render`](crate::Renderer::render).
pub(crate) fn light(motion: &dyn Motion, frame: f64, threads: &Threads) -> Result<Light, RenderError> {
    let camera = motion.at(frame).camera;
    let longer = f64::from(camera.size[0].max(camera.size[1])).max(1.0);
    let size = camera.size.map(|side| (f64::from(side) * SIDE / longer).ceil().max(1.0) as u32);
    let settings = Settings {
        size: Some(size),
        // Zoom would multiply them.
        spp: Some(SAMPLES / libm::exp2(2.0 * camera.zoom)),
        supersample: Some(1),
        temporal_samples: Some(1),
        filter: Filter::None,
        seed: 1,
        // The same bits as the fastest, but never by a GPU.
        arithmetic: Arithmetic::Avx2,
        ..Settings::default()
    };
    Ok(Light::of(&draw_frame(motion, frame, &settings, &Backend::default(), threads)?.image))
}

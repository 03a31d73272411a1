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

/// The same for a glance at what may never be looked at again.
const GLANCE_SIDE: f64 = 64.0;
const GLANCE_SAMPLES: f64 = 32.0;

/// The light of `motion` at `frame`.
/// Errors: As [`Renderer::render`](crate::Renderer::render).
pub(crate) fn light(motion: &dyn Motion, frame: f64, threads: &Threads) -> Result<Light, RenderError> {
    measured(motion, frame, [SIDE, SAMPLES], threads)
}

/// The same of a picture with a quarter of the samples.
pub(crate) fn glance(motion: &dyn Motion, frame: f64, threads: &Threads) -> Result<Light, RenderError> {
    measured(motion, frame, [GLANCE_SIDE, GLANCE_SAMPLES], threads)
}

fn measured(
    motion: &dyn Motion,
    frame: f64,
    [side, samples]: [f64; 2],
    threads: &Threads,
) -> Result<Light, RenderError> {
    let camera = motion.at(frame).camera;
    let longer = f64::from(camera.size[0].max(camera.size[1])).max(1.0);
    let size = camera.size.map(|length| (f64::from(length) * side / longer).ceil().max(1.0) as u32);
    let settings = Settings {
        size: Some(size),
        // Zoom would multiply them.
        spp: Some(samples / libm::exp2(2.0 * camera.zoom)),
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

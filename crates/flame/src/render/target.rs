//! How many samples a frame takes until its noise is as small as is asked for.
//!
//! Owns the rounds in which such a frame is drawn: after each its noise is known, and the next one draws what is likely to
//! be missing. Never draws: `film.rs` does.
//!
//! Start at [`Target::next`].

use super::RenderError;
use super::view::{MAX_SAMPLES_PER_PIXEL, View, in_range};
use crate::render::histogram::MAX_SAMPLES;

/// Samples per pixel of the first round.
const FIRST: f64 = 16.0;

/// A round has at most so many times the samples of all before it: the noise of few says little of that of many.
const MOST_GROWTH: f64 = 4.0;

/// And at least so many.
const LEAST_GROWTH: f64 = 1.125;

/// The square of the error of a picture is at most so many times what halves tell of it: they do not tell what both have in
/// common, as that few samples are too dark where light bends. Measured: up to 1.17.
const UNTOLD: f64 = 1.2;

/// A picture without noise, such as a black one, is told to have this: 120 decibels.
const LEAST_NOISE: f64 = 1e-12;

/// The noise that is asked for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Target {
    /// Peak signal-to-noise ratio in decibels.
    psnr: f64,
    pixels: f64,
}

impl Target {
    /// Samples of a frame of `view` whose noise is `psnr` decibels below full light.
    /// Errors: [`RenderError::Range`] for a number of decibels that makes no sense.
    pub(super) fn new(psnr: f64, view: &View) -> Result<Target, RenderError> {
        in_range("psnr", psnr, (10.0..=60.0).contains(&psnr), "10 to 60 decibels")?;
        Ok(Target { psnr, pixels: (view.size[0] * view.size[1]) as f64 })
    }

    /// Samples of the first round.
    pub(super) fn first(self) -> u64 {
        (FIRST * self.pixels).min(MAX_SAMPLES) as u64
    }

    /// Most samples. What is noisier then stays as it is.
    pub(super) fn most(self) -> u64 {
        (MAX_SAMPLES_PER_PIXEL * self.pixels).min(MAX_SAMPLES) as u64
    }

    /// Peak signal-to-noise ratio in decibels of a picture whose noise has a mean square of `noise`.
    pub(super) fn psnr(noise: f64) -> f64 {
        -10.0 * libm::log10((UNTOLD * noise).max(LEAST_NOISE))
    }

    /// How many samples are to be added to `drawn` if the noise has a mean square of `noise`; 0 where it is small enough.
    pub(super) fn next(self, drawn: u64, noise: f64) -> u64 {
        let missing = libm::pow(10.0, (self.psnr - Target::psnr(noise)) / 10.0);
        if missing > 1.0 {
            let growth = missing.clamp(LEAST_GROWTH, MOST_GROWTH);
            ((drawn as f64 * (growth - 1.0)) as u64).min(self.most().saturating_sub(drawn))
        } else {
            0
        }
    }
}

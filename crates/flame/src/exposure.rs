//! How the exposure of a transition follows what it shows.
//!
//! Owns the curve that keeps the brightness half way near that of the ends. It is measured on small pictures before the
//! first frame is rendered, from the genomes alone: every process of a farm finds the same. Never changes a frame at an
//! end, nor the speed of one.
//!
//! Start at [`Exposure::measure`], then [`Exposed`].

use crate::animate::Motion;
use crate::genome::Genome;
use crate::light::light;
use crate::render::RenderError;
use species::{Threads, expected};

/// The stretches of a curve: between them lie the moments that are measured.
const STRETCHES: usize = 24;

/// Most pictures of a moment.
const TRIES: usize = 5;

/// A moment is as bright as it should be within this part.
const NEAR: f64 = 0.02;

/// The widest gain, as a logarithm: from one 500th to 500 times.
const MOST: f64 = 6.2;

/// Light below this cannot be told from none.
const DARK: f64 = 1e-4;

/// By what the brightness of a transition is multiplied over its frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Exposure {
    frames: f64,
    /// The logarithms of the gains at the ends of each stretch.
    logs: Vec<f64>,
}

/// A motion with its exposure.
#[derive(Clone, Copy, Debug)]
pub struct Exposed<'a, M> {
    /// The motion.
    pub motion: M,
    /// Its exposure.
    pub exposure: &'a Exposure,
}

impl Exposure {
    /// The exposure of `motion` from frame 0 to `frames`, by which its brightness goes from that of the one end to that
    /// of the other, eased as everything else is.
    ///
    /// # Errors
    /// As [`Renderer::render`](crate::Renderer::render).
    pub fn measure(motion: &dyn Motion, frames: f64, threads: &Threads) -> Result<Exposure, RenderError> {
        let ends = [light(motion, 0.0, threads)?.mean, light(motion, frames, threads)?.mean];
        let mut logs = vec![0.0; STRETCHES + 1];
        for (i, log) in logs.iter_mut().enumerate().take(STRETCHES).skip(1) {
            let part = i as f64 / STRETCHES as f64;
            *log = gain(motion, part * frames, expected(ends, part), threads)?;
        }
        Ok(Exposure { frames, logs })
    }

    /// The gain at `frame`: 1 at both ends and outside, where it does not change either.
    pub fn gain(&self, frame: f64) -> f64 {
        let part = frame / self.frames;
        if part <= 0.0 || part >= 1.0 {
            return 1.0;
        }
        let place = part * STRETCHES as f64;
        let start = (place as usize).min(STRETCHES - 1);
        let (x, [from, to]) = (place - start as f64, [self.logs[start], self.logs[start + 1]]);
        let (square, cube) = (x * x, x * x * x);
        let eased = 3.0 * square - 2.0 * cube;
        let leaving = (cube - 2.0 * square + x) * self.slope(start);
        let arriving = (cube - square) * self.slope(start + 1);
        libm::exp(from + (to - from) * eased + leaving + arriving)
    }

    /// The slope at the start of stretch `i`: flat at the ends and where the curve turns back, so that it never leaves the
    /// range of what was measured (Fritsch & Carlson, 1980).
    fn slope(&self, i: usize) -> f64 {
        if i == 0 || i == STRETCHES {
            return 0.0;
        }
        let (before, after) = (self.logs[i] - self.logs[i - 1], self.logs[i + 1] - self.logs[i]);
        if before * after <= 0.0 { 0.0 } else { 2.0 * before * after / (before + after) }
    }
}

impl<M: Motion> Motion for Exposed<'_, M> {
    fn at(&self, frame: f64) -> Genome {
        let mut genome = self.motion.at(frame);
        genome.tone.brightness *= self.exposure.gain(frame);
        genome
    }
}

/// A motion whose brightness is multiplied.
struct Brighter<'a>(&'a dyn Motion, f64);

impl Motion for Brighter<'_> {
    fn at(&self, frame: f64) -> Genome {
        let mut genome = self.0.at(frame);
        genome.tone.brightness *= self.1;
        genome
    }
}

/// The logarithm of the gain by which `frame` of `motion` gets the mean luma `wanted`, or comes nearest to it: on a light
/// background more light may make a picture darker. 0 where no gain makes light of it.
fn gain(motion: &dyn Motion, frame: f64, wanted: f64, threads: &Threads) -> Result<f64, RenderError> {
    let gamma = motion.at(frame).tone.gamma;
    let mut log = 0.0;
    // The nearest point so far: the gain, and how far the light was off.
    let mut last: Option<(f64, f64)> = None;
    for _ in 0..TRIES {
        let found = light(&Brighter(motion, libm::exp(log)), frame, threads)?.mean;
        if found < DARK || wanted < DARK {
            return Ok(0.0);
        }
        let off = libm::log(found / wanted);
        if let Some((at, was)) = last
            && off.abs() >= was.abs()
        {
            return Ok(at);
        }
        if off.abs() < NEAR {
            return Ok(log);
        }
        // Light goes as the gain to the power of 1 / gamma, until it is white: the slope between two points tells better.
        let slope = last.map_or(1.0 / gamma, |(at, was)| (off - was) / (log - at));
        let slope = if slope.is_finite() { slope.clamp(0.1 / gamma, 4.0 / gamma) } else { 1.0 / gamma };
        last = Some((log, off));
        log = (log - off / slope).clamp(-MOST, MOST);
    }
    Ok(last.map_or(0.0, |(at, _)| at))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_is_even_at_its_ends_and_stays_between_what_was_measured() {
        let mut logs: Vec<f64> = (0..=STRETCHES).map(|i| f64::from(i as u32 * 7 % 5) - 2.0).collect();
        (logs[0], logs[STRETCHES]) = (0.0, 0.0);
        let curve = Exposure { frames: 100.0, logs };
        for frame in [-1.0, 0.0, 100.0, 101.0] {
            assert_eq!(curve.gain(frame), 1.0);
        }
        for (frame, near) in [(1e-4, 0.0), (100.0 - 1e-4, 100.0)] {
            assert!((curve.gain(frame) - curve.gain(near)).abs() / 1e-4 < 1e-4, "it starts and ends without a slope");
        }
        let mut last = 1.0;
        for step in 0..=10_000 {
            let gain = curve.gain(f64::from(step) / 100.0);
            assert!((libm::exp(-2.0)..=libm::exp(2.0)).contains(&gain));
            assert!((gain - last).abs() < 0.1, "it has no jump");
            last = gain;
        }
    }
}

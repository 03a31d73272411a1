//! What rendering will cost, before it is begun.
//!
//! Owns the measurement: some clips' frames with few samples, from which the cost with all of them follows. Never
//! writes a file.
//!
//! Start at [`cpu_seconds`].

use std::time::Duration;

use flame::{FrameCost, RenderError, Renderer, Settings};

use super::plan::{ClipPlan, Look};
use crate::now::Stopwatch;

/// Clips that are measured, at most; the others cost as much as these on average.
const MEASURED: usize = 6;

/// Samples of the two frames that are measured of each.
const FEW: u64 = 500_000;
const MORE: u64 = 4_000_000;

/// Processor time that rendering all frames of `clips` takes, without encoding them.
///
/// # Errors
/// [`RenderError`] if one cannot be rendered.
pub(crate) fn cpu_seconds(clips: &[ClipPlan], look: &Look) -> Result<f64, RenderError> {
    let renderer = Renderer::new(1)?;
    let step = clips.len().div_ceil(MEASURED).max(1);
    let measured: Vec<f64> =
        clips.iter().step_by(step).map(|clip| of_a_frame(clip, look, &renderer)).collect::<Result<_, _>>()?;
    let mean = measured.iter().sum::<f64>() / measured.len().max(1) as f64;
    Ok(mean * clips.iter().map(|clip| f64::from(clip.frames.0)).sum::<f64>())
}

/// Processor seconds of a frame a third into `clip`: what it takes whatever its samples, and what each of them takes.
fn of_a_frame(clip: &ClipPlan, look: &Look, renderer: &Renderer) -> Result<f64, RenderError> {
    let frame = f64::from(clip.frames.0 / 3);
    let settings = look.settings();
    let all = FrameCost::of(&*clip.motion, frame, &settings)?.samples;
    let of_one = FrameCost::of(&*clip.motion, frame, &Settings { spp: Some(1.0), ..settings })?.samples;
    let took = |samples: u64| {
        let spp = samples.min(all) as f64 / of_one as f64;
        let watch = Stopwatch::start();
        renderer.render(&*clip.motion, frame, &Settings { spp: Some(spp), ..settings })?;
        Ok((spp * of_one as f64, watch.cpu()))
    };
    Ok(extrapolated(took(FEW)?, took(MORE)?, all as f64))
}

/// The straight line through two measurements, at `samples`; where they tell nothing, the later one.
fn extrapolated(few: (f64, Duration), more: (f64, Duration), samples: f64) -> f64 {
    let (least, most) = (few.1.as_secs_f64(), more.1.as_secs_f64());
    if more.0 <= few.0 {
        return most;
    }
    most + ((most - least) / (more.0 - few.0)).max(0.0) * (samples - more.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_costs_what_two_smaller_ones_tell() {
        let at = |samples: f64, ms| (samples, Duration::from_millis(ms));
        let seconds = extrapolated(at(1e6, 300), at(3e6, 500), 1e9);
        assert!((seconds - 100.2).abs() < 1e-9, "{seconds}");
        assert!((extrapolated(at(1e6, 300), at(1e6, 310), 1e6) - 0.31).abs() < 1e-9);
    }
}

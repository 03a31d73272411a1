//! An estimate of the processor time of a rendering.
//!
//! Owns the measurement: it renders frames of some clips with few samples and extrapolates to all samples. Never writes a
//! file.
//!
//! Start at [`cpu_seconds`].

use std::time::Duration;

use flame::{FrameCost, RenderError, Renderer, Settings};

use super::plan::{ClipPlan, Look};
use crate::program::now::Stopwatch;

/// The most clips that are measured; the others cost as much as these on average.
const MEASURED: usize = 6;

/// Samples of the two frames of a clip that are measured.
const FEW: u64 = 2_000_000;
const MORE: u64 = 20_000_000;

/// Processor time that rendering all frames of `clips` takes, without encoding them.
/// Errors: [`RenderError`] if one cannot be rendered.
pub(crate) fn cpu_seconds(clips: &[ClipPlan], look: &Look) -> Result<f64, RenderError> {
    let renderer = Renderer::new(1)?;
    let step = clips.len().div_ceil(MEASURED).max(1);
    let measured: Vec<f64> =
        clips.iter().step_by(step).map(|clip| seconds_of_a_frame(clip, look, &renderer)).collect::<Result<_, _>>()?;
    let mean = measured.iter().sum::<f64>() / measured.len().max(1) as f64;
    Ok(mean * clips.iter().map(|clip| f64::from(clip.frames.0)).sum::<f64>())
}

/// Processor seconds of a frame a third into `clip`: a constant part, and a part for each sample.
fn seconds_of_a_frame(clip: &ClipPlan, look: &Look, renderer: &Renderer) -> Result<f64, RenderError> {
    let frame = f64::from(clip.frames.0 / 3);
    let settings = look.settings();
    let all = FrameCost::of(&*clip.motion, frame, &settings)?.samples;
    let of_one = FrameCost::of(&*clip.motion, frame, &Settings { spp: Some(1.0), ..settings })?.samples;
    let measure = |samples: u64| {
        let spp = samples.min(all) as f64 / of_one as f64;
        let watch = Stopwatch::start();
        renderer.render(&*clip.motion, frame, &Settings { spp: Some(spp), ..settings })?;
        Ok((spp * of_one as f64, watch.cpu()))
    };
    Ok(extrapolated(measure(FEW)?, measure(MORE)?, all as f64))
}

/// The straight line through two measurements, at `samples`; the second one if both have the same samples.
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

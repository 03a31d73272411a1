//! An estimate of the processor time of a rendering.
//!
//! Owns the measurement: it renders frames of some clips with few samples, or small ones where pictures have no noise, and
//! extrapolates. Never writes a file.
//!
//! Start at [`cpu_seconds`].

use std::time::Duration;

use species::{RenderError, Settings, Threads};

use super::plan::{ClipPlan, Look};
use crate::program::now::Stopwatch;

/// The most clips that are measured; the others cost as much as these on average.
const MEASURED: usize = 6;

/// Samples of the frames of a clip that are measured.
const FEW: u64 = 4_000_000;
const MORE: u64 = 24_000_000;

/// How many frames' samples are counted: those in the middles of as many equal parts of a clip.
const PLACES: u32 = 8;

/// Decibels of the frames that tell how fast noise falls.
const LEAST_PSNR: f64 = 28.0;
const MORE_PSNR: f64 = 36.0;

/// How much smaller they are than the clip's, in each direction, and pictures without noise that are measured.
const SMALLER: u32 = 4;

/// Most samples per pixel of a frame with a target noise.
const MOST_SPP: f64 = 1e6;

/// What rendering takes.
#[derive(Clone, Copy, Debug)]
pub struct Seconds {
    /// Of processors.
    pub cpu: f64,
    /// Of time, one frame after the other on one thread.
    pub wall: f64,
}

/// Processor time that rendering so many frames of each of `clips` takes, without encoding them.
/// Errors: [`RenderError`] if one cannot be rendered.
pub fn cpu_seconds<'a>(clips: impl IntoIterator<Item = (&'a ClipPlan, u32)>, look: &Look) -> Result<f64, RenderError> {
    Ok(seconds(clips, look)?.cpu)
}

/// What rendering so many frames of each of `clips` takes, without encoding them.
/// Errors: [`RenderError`] if one cannot be rendered.
pub fn seconds<'a>(clips: impl IntoIterator<Item = (&'a ClipPlan, u32)>, look: &Look) -> Result<Seconds, RenderError> {
    let clips: Vec<_> = clips.into_iter().filter(|(_, frames)| *frames > 0).collect();
    let threads = one_thread()?;
    let step = clips.len().div_ceil(MEASURED).max(1);
    let measured = clips.iter().step_by(step).map(|(clip, _)| seconds_of_a_frame(clip, look, &threads));
    let measured: Vec<Seconds> = measured.collect::<Result<_, _>>()?;
    let frames = clips.iter().map(|(_, frames)| f64::from(*frames)).sum::<f64>();
    let each = frames / measured.len().max(1) as f64;
    Ok(Seconds {
        cpu: measured.iter().map(|seconds| seconds.cpu).sum::<f64>() * each,
        wall: measured.iter().map(|seconds| seconds.wall).sum::<f64>() * each,
    })
}

/// Samples of so many frames of `clip`: a frame has the mean of [`PLACES`] on its way; where pictures have noise, of its
/// first and its last, between which samples change evenly. With a target noise, as many as a frame a third into it is
/// likely to take.
/// Errors: [`RenderError`] if it cannot be rendered.
pub fn samples(clip: &ClipPlan, frames: u32, look: &Look) -> Result<f64, RenderError> {
    if look.psnr.is_some() && frames > 0 && clip.motion.is_noisy() {
        let settings = settled(clip, look, &one_thread()?)?;
        let samples = clip.motion.demand(third(clip), &settings)?.samples as f64;
        return Ok(samples * f64::from(frames));
    }
    let settings = Settings { psnr: None, ..look.settings() };
    let of = |frame: f64| Ok::<_, RenderError>(clip.motion.demand(frame, &settings)?.samples as f64);
    if clip.is_dissolve || !clip.motion.is_noisy() {
        // Its ends may show one side only, as those of a dissolve and of a transition of agents do.
        let place = |number: u32| (f64::from(clip.frames.0) * (f64::from(number) + 0.5) / f64::from(PLACES)).floor();
        let sum = (0..PLACES).map(|number| of(place(number))).sum::<Result<f64, _>>()?;
        return Ok(sum / f64::from(PLACES) * f64::from(frames));
    }
    Ok(f64::midpoint(of(0.0)?, of(f64::from(clip.frames.0.saturating_sub(1)))?) * f64::from(frames))
}

fn one_thread() -> Result<Threads, RenderError> {
    Threads::new(1).map_err(|error| RenderError::Refused(error.into()))
}

/// The settings of smaller pictures: they are as noisy with as many samples per pixel.
fn small(settings: Settings) -> Settings {
    Settings { size: settings.size.map(|side| (side / SMALLER).max(1)), ..settings }
}

/// The settings of `look`; where it has a target noise, with the samples per pixel that a frame of `clip` is likely to take
/// instead. Two frames of few samples tell how fast noise falls.
fn settled(clip: &ClipPlan, look: &Look, threads: &Threads) -> Result<Settings, RenderError> {
    let settings = look.settings();
    let Some(target) = settings.psnr else { return Ok(settings) };
    let small = small(settings);
    let measure = |psnr: f64| -> Result<(f64, f64), RenderError> {
        let aimed = Settings { psnr: Some(psnr.min(target)), ..small };
        let measured = clip.motion.frame(third(clip), &aimed, threads)?;
        Ok((measured.samples as f64, measured.psnr.unwrap_or(target)))
    };
    let (few, more) = (measure(LEAST_PSNR)?, measure(MORE_PSNR)?);
    let samples = more.0 * 10.0_f64.powf((target - more.1).max(0.0) / 10.0 / fall(few, more));
    let of_one = Settings { spp: Some(1.0), psnr: None, ..small };
    let of_one = clip.motion.demand(third(clip), &of_one)?.samples as f64;
    Ok(Settings { spp: Some((samples / of_one).clamp(0.01, MOST_SPP)), psnr: None, ..settings })
}

/// By which power of the samples the square of the noise falls, by two measurements of samples and decibels: 1 without a
/// filter, and less with one.
fn fall(few: (f64, f64), more: (f64, f64)) -> f64 {
    let fall = (more.1 - few.1) / 10.0 / (more.0 / few.0).log10();
    if fall.is_finite() { fall.clamp(0.6, 1.0) } else { 1.0 }
}

/// The frame that stands for all of `clip`.
fn third(clip: &ClipPlan) -> f64 {
    f64::from(clip.frames.0 / 3)
}

/// What a frame takes that is a third into `clip`.
fn seconds_of_a_frame(clip: &ClipPlan, look: &Look, threads: &Threads) -> Result<Seconds, RenderError> {
    if clip.motion.is_noisy() {
        return seconds_of_samples(clip, look, threads);
    }
    let (all, small) = (look.settings(), small(look.settings()));
    let watch = Stopwatch::start();
    clip.motion.frame(third(clip), &small, threads)?;
    let pixels = |settings: Settings| f64::from(settings.size[0]) * f64::from(settings.size[1]);
    let times = pixels(all) / pixels(small);
    Ok(Seconds { cpu: watch.cpu().as_secs_f64() * times, wall: watch.wall().as_secs_f64() * times })
}

/// A constant part, a part for each sample, and a part for the filter. How much the filter has to do depends on the cells
/// that are hit, so it would pass for a part for each sample. If a GPU has to compile a clip before, that is not counted.
fn seconds_of_samples(clip: &ClipPlan, look: &Look, threads: &Threads) -> Result<Seconds, RenderError> {
    let frame = third(clip);
    let settings = settled(clip, look, threads)?;
    let samples = |settings: &Settings| Ok::<_, RenderError>(clip.motion.demand(frame, settings)?.samples);
    let all = samples(&settings)?;
    let of_one = samples(&Settings { spp: Some(1.0), ..settings })?;
    let measure = |most: u64, smooths: bool| {
        let settings = Settings { spp: Some(most.min(all) as f64 / of_one as f64), smooths, ..settings };
        let drawn = samples(&settings)?;
        let watch = Stopwatch::start();
        clip.motion.frame(frame, &settings, threads)?;
        Ok::<_, RenderError>((drawn as f64, [watch.cpu(), watch.wall()]))
    };
    // What is done once for all frames: the exposure, and what a GPU compiles.
    measure(1, false)?;
    let (few, more) = (measure(FEW, false)?, measure(MORE, false)?);
    let filtered = measure(MORE, true)?;
    let [cpu, wall] = [0, 1].map(|clock| {
        let filtering = filtered.1[clock].saturating_sub(more.1[clock]);
        extrapolated((few.0, few.1[clock]), (more.0, more.1[clock]), all as f64) + filtering.as_secs_f64()
    });
    Ok(Seconds { cpu, wall })
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
    fn noise_falls_as_two_frames_tell() {
        let is = |few, more, expected: f64| (fall(few, more) - expected).abs() < 1e-9;
        assert!(is((1e6, 30.0), (1e7, 38.0), 0.8));
        assert!(is((1e6, 30.0), (1e6, 30.0), 1.0));
        assert!(is((1e6, 30.0), (1e7, f64::INFINITY), 1.0));
    }

    #[test]
    fn a_frame_costs_what_two_smaller_ones_tell() {
        let at = |samples: f64, ms| (samples, Duration::from_millis(ms));
        let seconds = extrapolated(at(1e6, 300), at(3e6, 500), 1e9);
        assert!((seconds - 100.2).abs() < 1e-9, "{seconds}");
        assert!((extrapolated(at(1e6, 300), at(1e6, 310), 1e6) - 0.31).abs() < 1e-9);
    }
}

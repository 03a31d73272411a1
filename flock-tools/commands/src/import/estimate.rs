//! What an import will cost: processor time and bytes.
//!
//! Owns the measurement: it encodes the first frames of some clips into the system's folder for temporary files, and
//! extrapolates. Never writes into the flock.
//!
//! Start at [`estimate`].

use std::env;
use std::fs;
use std::process;

use operations::program::now::Stopwatch;

use super::importer::{Importer, TemporaryFile};
use super::plan::{ClipPlan, FilePlan};

/// The most clips that are measured; the others cost as much as these on average.
const MEASURED: usize = 4;

/// Frames of the two beginnings of a clip that are measured.
const FEW: u32 = 2;
const MORE: u32 = 26;

/// The cost of an import.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Cost {
    pub(super) cpu_seconds: f64,
    pub(super) bytes: f64,
}

/// The cost of the clips of `plans`; `None` if none of those that were tried can be encoded.
pub(super) fn estimate(importer: &Importer<'_>, plans: &[ClipPlan]) -> Option<Cost> {
    let (encode, copy): (Vec<&FilePlan>, Vec<&FilePlan>) =
        plans.iter().map(ClipPlan::first).partition(|file| file.encode.is_some());
    let copied = copy.iter().filter_map(|file| Some(fs::metadata(&file.source).ok()?.len())).sum::<u64>() as f64;
    if encode.is_empty() {
        return Some(Cost { cpu_seconds: 0.0, bytes: copied });
    }
    let step = encode.len().div_ceil(MEASURED).max(1);
    let lines: Vec<[Line; 2]> = encode.iter().step_by(step).filter_map(|file| measure(importer, file)).collect();
    if lines.is_empty() {
        return None;
    }
    let frames = lengths(&encode, importer);
    let total = |kind: usize| {
        let of_clip = |frames: &f64| lines.iter().map(|line| line[kind].at(*frames)).sum::<f64>() / lines.len() as f64;
        frames.iter().map(of_clip).sum::<f64>()
    };
    Some(Cost { cpu_seconds: total(0), bytes: total(1) + copied })
}

/// The frames of all clips; of those that do not tell it the mean of the others.
fn lengths(files: &[&FilePlan], importer: &Importer<'_>) -> Vec<f64> {
    let fps = importer.settings.form.fps;
    let told: Vec<Option<f64>> = files.iter().map(|file| file.frames(fps).map(|frames| frames as f64)).collect();
    let known: Vec<f64> = told.iter().copied().flatten().collect();
    let mean = known.iter().sum::<f64>() / known.len().max(1) as f64;
    told.into_iter().map(|frames| frames.unwrap_or(mean)).collect()
}

/// The processor time and the bytes of a clip by its frames, measured on its beginning.
fn measure(importer: &Importer<'_>, file: &FilePlan) -> Option<[Line; 2]> {
    let [few, more] = [FEW, MORE].map(|frames| beginning(importer, file, frames));
    let ((few, few_cost), (more, more_cost)) = (few?, more?);
    let line = |a: f64, b: f64| Line::through((few, a), (more, b));
    Some([line(few_cost.cpu_seconds, more_cost.cpu_seconds), line(few_cost.bytes, more_cost.bytes)])
}

/// Encodes the first `most` frames of a clip. Returns how many they are, and their cost.
fn beginning(importer: &Importer<'_>, file: &FilePlan, most: u32) -> Option<(f64, Cost)> {
    let new = TemporaryFile(env::temp_dir().join(format!("dreams-import-{}.mp4", process::id())));
    let watch = Stopwatch::start();
    let frames = importer.encode(file, file.encode.as_ref()?, &new.0, most).ok()?;
    let cost = Cost { cpu_seconds: watch.cpu().as_secs_f64(), bytes: fs::metadata(&new.0).ok()?.len() as f64 };
    Some((f64::from(frames.0), cost))
}

/// What clips cost by their length: a constant part, and a part for each frame.
#[derive(Clone, Copy, Debug)]
struct Line {
    constant: f64,
    of_frame: f64,
}

impl Line {
    /// The line through two measurements; where both are of the same length, each frame costs its part of the second.
    fn through(few: (f64, f64), more: (f64, f64)) -> Self {
        if more.0 <= few.0 {
            return Self { constant: 0.0, of_frame: more.1 / more.0.max(1.0) };
        }
        let of_frame = ((more.1 - few.1) / (more.0 - few.0)).max(0.0);
        Self { constant: (few.1 - of_frame * few.0).max(0.0), of_frame }
    }

    fn at(self, frames: f64) -> f64 {
        self.constant + self.of_frame * frames
    }
}

#[cfg(test)]
mod tests {
    use super::Line;

    #[test]
    fn a_clip_costs_what_two_of_its_beginnings_tell() {
        assert!((Line::through((2.0, 1.2), (26.0, 6.0)).at(100.0) - 20.8).abs() < 1e-9);
        assert!((Line::through((6.0, 1.2), (6.0, 1.5)).at(12.0) - 3.0).abs() < 1e-9);
        assert!(Line::through((2.0, 5.0), (26.0, 1.0)).at(1e9) <= 5.0);
    }
}

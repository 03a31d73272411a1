//! What suggested transitions cost: to render, and to keep.
//!
//! Owns the estimate: processor time by a measurement on a few frames where there are genomes, bytes by the clips that
//! are there. Never renders a clip.

use std::fs;
use std::path::Path;

use flock::{Clip, Flock, Manifest, SheepId, Suggestion, Transition};
use video::Form;

use crate::places;
use crate::render::estimate;
use crate::render::order::{Order, Wanted};
use crate::render::plan::{ClipPlan, Look, Shows};

/// Clips that are looked at for their size, at most.
const LOOKED_AT: usize = 256;

/// What a clip costs.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub(super) struct Cost {
    pub(super) frames: u32,
    /// How long it is lit.
    pub(super) seconds: f64,
    /// Processor time to render it; `null` where a genome is missing, and for what is there already.
    pub(super) cpu_hours: Option<f64>,
    /// Its size, or what it will be if it is like the clips that are there; `null` where there are none.
    pub(super) bytes: Option<f64>,
}

/// What rendering the transitions `new` to the flock in `folder` costs.
pub(super) fn of_rendering(new: &[Suggestion], flock: &Flock, folder: &Path) -> Vec<Cost> {
    let per_frame = bytes_a_frame(flock.manifest(), folder);
    let hours = cpu_hours(new, flock.manifest(), folder);
    let cost = |(new, cpu_hours): (&Suggestion, Option<f64>)| Cost {
        cpu_hours,
        bytes: per_frame.map(|bytes| (bytes * f64::from(new.frames.0)).round()),
        ..plain(new, flock)
    };
    new.iter().zip(hours).map(cost).collect()
}

/// What keeping the transitions `old` of the flock in `folder` costs.
pub(super) fn of_keeping(old: &[Suggestion], flock: &Flock, folder: &Path) -> Vec<Cost> {
    let cost = |old: &Suggestion| {
        let transitions = &flock.manifest().transitions;
        let own = transitions.iter().find(|own| own.from == old.from && own.to == old.to);
        let bytes = own.and_then(|own| fs::metadata(own.clip.path.inside(folder)).ok()).map(|file| file.len() as f64);
        Cost { bytes, ..plain(old, flock) }
    };
    old.iter().map(cost).collect()
}

fn plain(suggestion: &Suggestion, flock: &Flock) -> Cost {
    let fps = flock.manifest().fps;
    let frames = suggestion.frames.0;
    let seconds = f64::from(frames) * f64::from(fps.den()) / f64::from(fps.num());
    Cost { frames, seconds, cpu_hours: None, bytes: None }
}

/// What a frame of the clips in `folder` takes in the mean.
fn bytes_a_frame(manifest: &Manifest, folder: &Path) -> Option<f64> {
    let step = manifest.clips().count().div_ceil(LOOKED_AT).max(1);
    let (mut bytes, mut frames) = (0.0, 0.0);
    for clip in manifest.clips().step_by(step) {
        if let Ok(file) = fs::metadata(clip.path.inside(folder)) {
            bytes += file.len() as f64;
            frames += f64::from(clip.frames.0);
        }
    }
    (frames > 0.0).then(|| bytes / frames)
}

/// Processor hours to render each of `new`, by the genomes' own quality; a measurement on a few frames tells what their
/// samples cost. A genome that cannot be rendered is `flock render`'s to refuse.
fn cpu_hours(new: &[Suggestion], manifest: &Manifest, folder: &Path) -> Vec<Option<f64>> {
    if new.is_empty() {
        return Vec::new();
    }
    let look = Look::of_genomes(Form { size: manifest.size, fps: manifest.fps });
    let ends: Vec<SheepId> = new.iter().flat_map(|new| [new.from.clone(), new.to.clone()]).collect();
    let transition = |new: &Suggestion| Transition {
        from: new.from.clone(),
        to: new.to.clone(),
        clip: Clip { path: places::of_transition(&new.from, &new.to, places::CLIP), frames: new.frames, hash: None },
        weight: new.weight,
    };
    let with = Manifest { transitions: new.iter().map(transition).collect(), ..manifest.clone() };
    let order = Order::new(folder, &with, &Wanted { sheep: &ends, again: true }, &look);
    let clips = order.map(|order| order.clips).unwrap_or_default();
    let plans: Vec<ClipPlan> = clips.into_iter().filter(|clip| matches!(clip.shows, Shows::Transition(..))).collect();
    let Ok(seconds) = estimate::cpu_seconds(&plans, &look) else { return vec![None; new.len()] };
    let samples =
        |plan: &ClipPlan| plan.demand(&look).map_or(0.0, |demand| demand.samples as f64) * f64::from(plan.frames.0);
    let all: f64 = plans.iter().map(samples).sum();
    let of = |new: &Suggestion| {
        let own = |plan: &&ClipPlan| plan.shows == Shows::Transition(new.from.clone(), new.to.clone());
        plans.iter().find(own).map(|plan| seconds / 3600.0 * samples(plan) / all)
    };
    new.iter().map(of).collect()
}

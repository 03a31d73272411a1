//! The cost of suggested transitions: to render them, or to keep them.
//!
//! Owns the estimate: processor time by a measurement on a few frames if there are genomes, bytes by the clips that are
//! there. Never renders a clip.

use std::fs;
use std::path::Path;

use flame::Backend;
use flock::{Clip, Flock, Manifest, SheepId, Suggestion, Transition};
use video::Form;

use crate::flock_folder::paths;
use crate::render::estimate;
use crate::render::plan::{ClipPlan, ClipRole, Look};
use crate::render::selection::{Request, Scope, Selection};

/// The most clips whose sizes are read.
const MOST_SIZES: usize = 256;

/// The cost of a clip.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct Cost {
    /// Its length in frames.
    pub frames: u32,
    /// Its length.
    pub seconds: f64,
    /// Samples to render; `null` if a genome is missing, and for a clip that is there.
    pub samples: Option<f64>,
    /// Processor time to render it, measured on a few frames; `null` as above, and if nothing is measured.
    pub cpu_hours: Option<f64>,
    /// Its size, estimated from the clips that are there; `null` if there are none.
    pub bytes: Option<f64>,
}

/// The plans of transitions that might be rendered.
struct RenderPlans {
    look: Look,
    plans: Vec<ClipPlan>,
}

/// The cost of rendering the transitions `new` to the flock in `folder`, with processor time measured on a few frames.
pub fn of_rendering(new: &[Suggestion], flock: &Flock, folder: &Path) -> Vec<Cost> {
    let plans = RenderPlans::new(new, flock.manifest(), folder);
    let mut costs = plans.costs(new, flock, folder);
    let second = plans.seconds_a_sample();
    for cost in &mut costs {
        cost.cpu_hours = cost.samples.zip(second).map(|(samples, seconds)| samples * seconds / 3600.0);
    }
    costs
}

/// The same without the measurement: equal for equal flocks.
pub fn without_measurement(new: &[Suggestion], flock: &Flock, folder: &Path) -> Vec<Cost> {
    RenderPlans::new(new, flock.manifest(), folder).costs(new, flock, folder)
}

/// The cost of keeping the transitions `old` of the flock in `folder`.
pub fn of_keeping(old: &[Suggestion], flock: &Flock, folder: &Path) -> Vec<Cost> {
    let cost = |old: &Suggestion| {
        let transitions = &flock.manifest().transitions;
        let own = transitions.iter().find(|own| own.from == old.from && own.to == old.to);
        let bytes = own.and_then(|own| fs::metadata(own.clip.path.inside(folder)).ok()).map(|file| file.len() as f64);
        Cost { bytes, ..plain(old, flock) }
    };
    old.iter().map(cost).collect()
}

/// The cost of a suggested transition, by its length alone.
pub fn plain(suggestion: &Suggestion, flock: &Flock) -> Cost {
    let fps = flock.manifest().fps;
    let frames = suggestion.frames.0;
    let seconds = f64::from(frames) * f64::from(fps.den()) / f64::from(fps.num());
    Cost { frames, seconds, samples: None, cpu_hours: None, bytes: None }
}

/// The mean size of a frame of the clips in `folder`, in bytes.
fn bytes_a_frame(manifest: &Manifest, folder: &Path) -> Option<f64> {
    let step = manifest.clips().count().div_ceil(MOST_SIZES).max(1);
    let (mut bytes, mut frames) = (0.0, 0.0);
    for clip in manifest.clips().step_by(step) {
        if let Ok(file) = fs::metadata(clip.path.inside(folder)) {
            bytes += file.len() as f64;
            frames += f64::from(clip.frames.0);
        }
    }
    (frames > 0.0).then(|| bytes / frames)
}

impl RenderPlans {
    /// With the quality that the genomes have. `dreams render` refuses genomes that cannot be rendered.
    fn new(new: &[Suggestion], manifest: &Manifest, folder: &Path) -> Self {
        let look = Look::of_genomes(Form { size: manifest.size, fps: manifest.fps });
        let ends: Vec<SheepId> = new.iter().flat_map(|new| [new.from.clone(), new.to.clone()]).collect();
        if ends.is_empty() {
            return Self { look, plans: Vec::new() };
        }
        let transition = |new: &Suggestion| Transition {
            from: new.from.clone(),
            to: new.to.clone(),
            clip: Clip { path: paths::of_transition(&new.from, &new.to, paths::CLIP), frames: new.frames, hash: None },
            weight: new.weight,
        };
        let with = Manifest { transitions: new.iter().map(transition).collect(), ..manifest.clone() };
        let selection =
            Selection::new(folder, &with, &Request { sheep: &ends, scope: Scope::All }, &look, &Backend::default());
        let clips = selection.map(|selection| selection.clips).unwrap_or_default();
        let plans = clips.into_iter().filter(|clip| matches!(clip.role, ClipRole::Transition(..))).collect();
        Self { look, plans }
    }

    /// The cost of each of `new`, without processor time.
    fn costs(&self, new: &[Suggestion], flock: &Flock, folder: &Path) -> Vec<Cost> {
        let per_frame = bytes_a_frame(flock.manifest(), folder);
        let cost = |new: &Suggestion| {
            let own = |plan: &&ClipPlan| plan.role == ClipRole::Transition(new.from.clone(), new.to.clone());
            Cost {
                samples: self.plans.iter().find(own).and_then(|plan| self.samples(plan)),
                bytes: per_frame.map(|bytes| (bytes * f64::from(new.frames.0)).round()),
                ..plain(new, flock)
            }
        };
        new.iter().map(cost).collect()
    }

    /// The samples of all frames of `plan`, if it can be rendered.
    fn samples(&self, plan: &ClipPlan) -> Option<f64> {
        plan.demand(&self.look).ok().map(|demand| demand.samples as f64 * f64::from(plan.frames.0))
    }

    /// Processor seconds that a sample takes in the mean, measured.
    fn seconds_a_sample(&self) -> Option<f64> {
        let samples: f64 = self.plans.iter().map(|plan| self.samples(plan)).sum::<Option<f64>>()?;
        let seconds = estimate::cpu_seconds(self.plans.iter().map(|plan| (plan, plan.frames.0)), &self.look).ok()?;
        (samples > 0.0).then(|| seconds / samples)
    }
}

//! What a clip costs to render on this machine, without rendering any of it.
//!
//! Owns the estimate: the samples of its frames, times what a sample took when the strips of its sheep were drawn. Sheep
//! whose strips come from clips, or are not made yet, count as their species does in the mean. `dreams render --dry-run`
//! measures, and takes longer. Never renders.
//!
//! Start at [`Media::cost_s`].

use std::collections::HashMap;

use flock::{Manifest, Sheep, SheepId};
use operations::render::machine;
use operations::render::plan::{ClipPlan, Look};
use timing::FrameCount;
use video::Form;

use super::sources::Pair;
use super::{Media, rendering};

/// Processor seconds of a sample in the mean of the demo flock, by the ending of the genome's file, on one core of a server
/// of 2024. A species that is not here costs as the first.
const USUAL: [(&str, f64); 4] = [("flam3", 1.5e-7), ("expr", 2.5e-7), ("agents", 1.2e-7), ("plant", 1.2e-7)];

impl Media {
    /// Seconds that the transition from one sheep to another takes on all cores of this machine; `None` if a genome is missing
    /// or cannot be rendered.
    pub(crate) fn cost_s(
        &self,
        manifest: &Manifest,
        from: &SheepId,
        to: &SheepId,
        frames: FrameCount,
        is_draft: bool,
    ) -> Option<f64> {
        let key = self.pair_key(manifest, &Pair { from, to, frames })?;
        let source = self.sources.find(&key).ok()?;
        let super::sources::Source::Pair(pair) = &*source else { return None };
        let look = rendering::look(pair.form, is_draft);
        let plan = pair.plan(pair.form.size, &look).ok()?;
        self.cost_of_plan(manifest, &plan, &look)
    }

    /// The same of a clip that is planned.
    pub(super) fn cost_of_plan(&self, manifest: &Manifest, plan: &ClipPlan, look: &Look) -> Option<f64> {
        let samples = plan.demand(look).ok()?.samples as f64 * f64::from(plan.frames.0);
        let sheep: HashMap<&SheepId, &Sheep> = manifest.sheep.iter().map(|sheep| (&sheep.id, sheep)).collect();
        let ends = plan.role.sheep();
        let each = ends.map(|id| self.sample_s(look.form, sheep.get(id).copied()));
        let cpu_s = samples * each.iter().sum::<f64>() / each.len() as f64;
        Some(cpu_s / machine::cores().get() as f64)
    }

    /// Processor seconds of a sample of `sheep`.
    fn sample_s(&self, form: Form, sheep: Option<&Sheep>) -> f64 {
        let genome = sheep.and_then(|sheep| sheep.genome.as_ref());
        let path = genome.map(|genome| genome.inside(&self.folder));
        let clip = sheep.and_then(|sheep| sheep.clip.as_ref());
        let key = self.strip_key(form, clip, path.as_deref());
        let measured = key.and_then(|key| self.strip_look(&key)?.sample_s);
        let ending = path.as_ref().and_then(|path| path.extension()?.to_str()).unwrap_or_default();
        let usual = USUAL.iter().find(|(own, _)| *own == ending).unwrap_or(&USUAL[0]).1;
        measured.unwrap_or(usual)
    }
}

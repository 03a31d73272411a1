//! What pruning would keep and drop, as `dreams prune` proposes it, before anything is written.
//!
//! Owns the form of the answer. The flock crate finds the parts; the edit is the document's. Never writes.
//!
//! Start at [`Pruning::of`].

use flock::{Bridge, Flock, Measure, Part, Parts, SheepId};
use operations::render::selection::usual_frames;

use super::figures::Figures;

/// The most other parts that are told one by one.
const MOST_PARTS: usize = 60;

/// A flock before and after pruning.
#[derive(Debug, serde::Serialize)]
pub(crate) struct Pruning {
    /// The sheep that go, in the order of the parts.
    pub(crate) drop: Vec<SheepId>,
    pub(crate) was: Figures,
    pub(crate) figures: Figures,
    /// The first sheep of every other part that has as many sheep as the one that is kept.
    pub(crate) ties: Vec<SheepId>,
    /// The other parts, the largest first.
    pub(crate) parts: Vec<LostPart>,
    /// The fewest transitions that would bring all of them in instead, and their frames.
    pub(crate) fewest: usize,
    pub(crate) frames: u64,
}

/// A part that is not kept.
#[derive(Debug, serde::Serialize)]
pub(crate) struct LostPart {
    pub(crate) sheep: Vec<SheepId>,
    /// The transitions that would bring it in: the way in, the way out, or both.
    pub(crate) links: Vec<NewLink>,
}

/// A transition that the flock lacks.
#[derive(Debug, serde::Serialize)]
pub(crate) struct NewLink {
    pub(crate) from: SheepId,
    pub(crate) to: SheepId,
    pub(crate) frames: u32,
    /// Whether both sheep have genomes.
    pub(crate) can_be_rendered: bool,
}

impl Pruning {
    /// What is proposed for `flock`; the part with the sheep `with` is kept, or the one that is played. `after` is the flock
    /// without the sheep that it is given. `None` if the part has no cycle.
    /// Errors: Those of `after`.
    pub(crate) fn of<E>(
        flock: &Flock,
        with: Option<&SheepId>,
        by: Measure,
        after: impl FnOnce(&[SheepId]) -> Result<Flock, E>,
    ) -> Result<Option<Self>, E> {
        let Some(parts) = Parts::of(flock, with) else { return Ok(None) };
        let drop: Vec<SheepId> = parts.others.iter().flat_map(|part| part.sheep.iter().cloned()).collect();
        let after = after(&drop)?;
        let frames = usual_frames(flock.manifest());
        let link = |bridge: &Bridge| {
            let Bridge { from, to, can_be_rendered } = bridge.clone();
            NewLink { from, to, frames, can_be_rendered }
        };
        let lost = |part: &Part| {
            let links = [&part.entry, &part.exit].into_iter().flatten().map(link).collect();
            LostPart { sheep: part.sheep.clone(), links }
        };
        Ok(Some(Self {
            was: Figures::of_flock(flock, by),
            figures: Figures::of_flock(&after, by),
            parts: parts.others.iter().take(MOST_PARTS).map(lost).collect(),
            ties: parts.ties,
            fewest: parts.fewest,
            frames: parts.fewest as u64 * u64::from(frames),
            drop,
        }))
    }
}

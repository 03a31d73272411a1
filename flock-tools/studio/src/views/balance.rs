//! Balances and suggestions for the page: what would change, and by how much, before anything is written.
//!
//! Owns the form of the answers. The flock crate finds the weights and the transitions. Never writes.
//!
//! Start at [`Proposal::of`].

use std::path::Path;

use flock::{Balance, Flock, SheepId, Suggestion, Suggestions, Terms};
use operations::render::cost;

use super::figures::SheepFigures;

/// Transitions that are suggested at once, of either kind.
pub(crate) const SUGGESTED: usize = 6;

/// The weights of a balance beside those that are written.
#[derive(Debug, serde::Serialize)]
pub(crate) struct Proposal {
    /// Whether some weights reach the wants exactly.
    pub(crate) reachable: bool,
    /// The worst ratio with these weights, and with those that are written.
    pub(crate) worst_ratio: Option<f64>,
    pub(crate) worst_ratio_was: Option<f64>,
    /// The transitions whose weight would change.
    pub(crate) weights: Vec<NewWeight>,
    pub(crate) sheep: Vec<NewShare>,
    /// Sheep that are wanted more than all that they lead to; empty if the wants can be reached.
    pub(crate) bottleneck: Vec<SheepId>,
}

/// A weight that would change.
#[derive(Debug, serde::Serialize)]
pub(crate) struct NewWeight {
    pub(crate) from: SheepId,
    pub(crate) to: SheepId,
    pub(crate) was: f64,
    pub(crate) value: f64,
}

/// The share of a sheep with the new weights, and the one that it has.
#[derive(Debug, serde::Serialize)]
pub(crate) struct NewShare {
    pub(crate) id: SheepId,
    pub(crate) share: f64,
    pub(crate) wanted: f64,
    pub(crate) was: f64,
}

/// Transitions that would help.
#[derive(Debug, serde::Serialize)]
pub(crate) struct Advice {
    /// Each is the best one after those before it.
    pub(crate) add: Vec<Advised>,
    pub(crate) remove: Vec<Advised>,
}

/// A transition to add or to remove.
#[derive(Debug, serde::Serialize)]
pub(crate) struct Advised {
    pub(crate) from: SheepId,
    pub(crate) to: SheepId,
    /// That of the balance after this and those before it.
    pub(crate) worst_ratio: Option<f64>,
    pub(crate) frames: u32,
    /// Samples to render it; `null` if a genome is missing, and for one that is there.
    pub(crate) samples: Option<f64>,
    /// Processor time to render it, in seconds; `null` if nothing is known of it.
    pub(crate) cost_s: Option<f64>,
}

impl Proposal {
    /// The balance of `flock` on `terms`; `now` are the figures of its sheep, in the order of their ids. `None` if it has no
    /// cycle.
    pub(crate) fn of(flock: &Flock, terms: Terms, now: &[SheepFigures], worst_ratio_was: Option<f64>) -> Option<Self> {
        let balance = Balance::of(flock, terms)?;
        let whole = flock.whole();
        let exits = whole.sheep().flat_map(|sheep| whole.exits(sheep));
        let changed = exits.zip(&balance.weights).filter_map(|(exit, new)| {
            let was = flock.manifest().transitions[whole.transition_in_manifest(exit)].weight;
            let (from, to, value) = (new.from.clone(), new.to.clone(), new.weight);
            (was.to_bits() != value.to_bits()).then_some(NewWeight { from, to, was, value })
        });
        let weights = changed.collect();
        let sheep = balance.sheep.iter().zip(now).map(|(sheep, now)| {
            let (share, wanted) = match terms.by {
                flock::Measure::Visits => (sheep.visits, sheep.want),
                flock::Measure::Time => (sheep.time, sheep.time_want),
            };
            NewShare { id: sheep.id.clone(), share, wanted, was: now.share }
        });
        let bottleneck = balance.bottleneck.iter().flat_map(|found| found.sheep.iter().cloned());
        Some(Self {
            reachable: balance.reachable,
            worst_ratio: balance.worst(),
            worst_ratio_was,
            weights,
            sheep: sheep.collect(),
            bottleneck: bottleneck.collect(),
        })
    }
}

impl Advice {
    /// What would help the `flock` in `folder` most. `None` if it has no cycle.
    pub(crate) fn of(folder: &Path, flock: &Flock, terms: Terms) -> Option<Self> {
        let Suggestions { add, remove } = Suggestions::of(flock, terms, SUGGESTED)?;
        let costs = cost::without_measurement(&add, flock, folder);
        let advised = |own: &Suggestion, samples: Option<f64>| Advised {
            from: own.from.clone(),
            to: own.to.clone(),
            worst_ratio: own.worst(terms.by),
            frames: own.frames.0,
            samples,
            cost_s: None,
        };
        Some(Self {
            add: add.iter().zip(costs).map(|(own, cost)| advised(own, cost.samples)).collect(),
            remove: remove.iter().map(|own| advised(own, None)).collect(),
        })
    }
}

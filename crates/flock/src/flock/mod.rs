//! A flock made ready to be walked.
//!
//! Owns the choice of the part that is played, its shares and its hash.
//!
//! Start at [`Flock::new`].

mod faults;
mod flock_shares;
mod parts;

use std::sync::{Arc, OnceLock};

use crate::graph::{Exit, Graph, SheepIx, Structure};
use crate::manifest::{Clip, Manifest, Sheep, SheepId, Transition};
use crate::shares::Shares;
use faults::faults;
pub use faults::{Fault, FaultKind, forced_repeats};
pub(crate) use flock_shares::time_want;
pub use flock_shares::{FlockShares, Measure, SheepShare, TransitionShare};
pub use parts::{Bridge, Part, Parts};

/// The context of [`Flock::hash`]: it changes with the rules of the walk.
const HASH_CONTEXT: &str = "dreams flock walk 1";

/// A manifest, the part of its graph that is played, and the share of each sheep in it.
///
/// The walk lives in the largest class with a cycle and takes no exit that leaves it. A flock without any cycle is
/// played as the loop of one sheep.
#[derive(Clone, Debug)]
pub struct Flock {
    manifest: Arc<Manifest>,
    /// Transitions that the manifest does not have: its graphs count them behind those that it has.
    added: Vec<Transition>,
    graph: Graph,
    /// The whole graph, if a part of it is not played.
    whole: Option<Graph>,
    /// Computed on demand: a unit does not need them, and a large flock may have two for each sheep.
    faults: OnceLock<Vec<Fault>>,
    /// Computed on demand. `None` only if there is nothing to show.
    shares: OnceLock<Option<Shares>>,
    hash: [u8; 32],
}

impl Flock {
    /// Builds the graph of `manifest`, without its faults.
    pub fn new(manifest: impl Into<Arc<Manifest>>) -> Self {
        let manifest = manifest.into();
        let whole = Graph::new(&manifest);
        Self::of(manifest, Vec::new(), whole)
    }

    /// The flock with one more transition, which is not in its manifest. As it is if there is such a transition, or if one
    /// of its sheep is not there.
    #[must_use]
    pub(crate) fn with_transition(&self, transition: Transition) -> Self {
        let whole = self.whole();
        let Some((from, to)) = whole.find(&transition.from).zip(whole.find(&transition.to)) else {
            return self.clone();
        };
        let written = self.manifest.transitions.len() + self.added.len();
        let whole = whole.with_exit(from, to, transition.weight, written as u32);
        let added = self.added.iter().cloned().chain([transition]).collect();
        Self::of(Arc::clone(&self.manifest), added, whole)
    }

    /// The flock without the transition `exit` of its whole graph, which stays in its manifest.
    #[must_use]
    pub(crate) fn without_transition(&self, exit: Exit) -> Self {
        Self::of(Arc::clone(&self.manifest), self.added.clone(), self.whole().without_exit(exit))
    }

    /// The flock of `manifest` and the transitions `added` to it, whose graph is `whole`.
    fn of(manifest: Arc<Manifest>, added: Vec<Transition>, whole: Graph) -> Self {
        let structure = Structure::of(&whole);
        let played = if let Some(class) = structure.playable().first() {
            let plays_all = class.len() == whole.len();
            (!plays_all).then(|| whole.restricted(|sheep| class.binary_search(&sheep).is_ok()))
        } else {
            let has_loop = |sheep: &SheepIx| manifest.sheep[whole.sheep_in_manifest(*sheep)].clip.is_some();
            let still = whole.sheep().find(has_loop);
            Some(whole.restricted(|sheep| Some(sheep) == still))
        };
        let (graph, whole) = match played {
            Some(played) => (played, Some(whole)),
            None => (whole, None),
        };
        let hash = hash(&graph);
        Self { manifest, added, graph, whole, faults: OnceLock::new(), shares: OnceLock::new(), hash }
    }

    /// As written.
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// The whole graph of the manifest, played or not.
    pub fn whole(&self) -> &Graph {
        self.whole.as_ref().unwrap_or(&self.graph)
    }

    /// Every fault that the manifest alone betrays: names first, then the graph.
    pub fn faults(&self) -> &[Fault] {
        self.faults.get_or_init(|| faults(&self.manifest, self.whole(), &Structure::of(self.whole())))
    }

    /// The part that is played.
    pub fn graph(&self) -> &Graph {
        &self.graph
    }

    /// Whether there is a cycle to walk. If not, only one loop can be shown.
    pub fn is_walkable(&self) -> bool {
        self.graph.exit_count() > 0
    }

    /// The share of `sheep`: its fraction of all visits in the long run.
    pub fn share(&self, sheep: SheepIx) -> f64 {
        self.shares().map_or(0.0, |shares| shares.visits(sheep))
    }

    /// The shares of the part that is played. `None` if the flock has neither a cycle nor a loop to show.
    pub fn shares(&self) -> Option<&Shares> {
        self.shares.get_or_init(|| Shares::of(&self.graph).ok()).as_ref()
    }

    /// How long `clip` is lit, in seconds.
    pub fn seconds(&self, clip: &Clip) -> f64 {
        f64::from(clip.frames.0) * f64::from(self.manifest.fps.den()) / f64::from(self.manifest.fps.num())
    }

    /// How long a visit of `sheep` lights its loop, in seconds; 0 if it has none.
    pub fn visit_seconds(&self, sheep: SheepIx) -> f64 {
        self.loop_of(sheep).map_or(0.0, |own| f64::from(self.sheep(sheep).repeat) * self.seconds(own))
    }

    /// The hash of the walk's input: ids, transitions and weights of the part that is played. Flocks with equal hashes
    /// have equal walks.
    pub fn hash(&self) -> [u8; 32] {
        self.hash
    }

    /// The sheep as written.
    pub fn sheep(&self, sheep: SheepIx) -> &Sheep {
        &self.manifest.sheep[self.graph.sheep_in_manifest(sheep)]
    }

    /// The transition as written.
    pub fn transition(&self, exit: Exit) -> &Transition {
        self.written(self.graph.transition_in_manifest(exit))
    }

    /// The transitions of the manifest, then those that it does not have.
    pub(crate) fn transitions(&self) -> impl Iterator<Item = &Transition> {
        self.manifest.transitions.iter().chain(&self.added)
    }

    /// The transition at this place of the manifest, or behind it.
    pub(crate) fn written(&self, at: usize) -> &Transition {
        let transitions = &self.manifest.transitions;
        transitions.get(at).unwrap_or_else(|| &self.added[at - transitions.len()])
    }

    /// The id of `sheep`.
    pub fn id(&self, sheep: SheepIx) -> &SheepId {
        self.graph.id(sheep)
    }

    /// The loop of `sheep`, if it has one.
    pub(crate) fn loop_of(&self, sheep: SheepIx) -> Option<&Clip> {
        self.sheep(sheep).clip.as_ref()
    }
}

fn hash(graph: &Graph) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new_derive_key(HASH_CONTEXT);
    hasher.update(&(graph.len() as u64).to_le_bytes());
    for sheep in graph.sheep() {
        hasher.update(graph.id(sheep).as_str().as_bytes()).update(b"\n");
        hasher.update(&(graph.exits(sheep).len() as u64).to_le_bytes());
        for exit in graph.exits(sheep) {
            hasher.update(&graph.target(exit).0.to_le_bytes());
            hasher.update(&graph.weight(exit).to_bits().to_le_bytes());
        }
    }
    *hasher.finalize().as_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::tests::manifest;

    #[test]
    fn the_walk_sees_only_the_largest_part_that_closes_on_itself() {
        let arcs = [(0, 1, 1.0), (1, 0, 1.0), (1, 2, 5.0), (2, 3, 1.0), (3, 3, 1.0)];
        let flock = Flock::new(manifest(4, &arcs));
        let ids: Vec<_> = flock.graph().sheep().map(|sheep| flock.id(sheep).as_str()).collect();
        assert_eq!(ids, ["s0", "s1"]);
        assert!(flock.graph().sheep().all(|sheep| (flock.share(sheep) - 0.5).abs() < 1e-15));
    }

    #[test]
    fn a_flock_without_a_cycle_is_one_loop() {
        let mut bare = manifest(3, &[(0, 1, 1.0), (1, 2, 1.0)]);
        bare.sheep[0].clip = None;
        let flock = Flock::new(bare);
        assert!(!flock.is_walkable());
        assert_eq!(flock.graph().len(), 1);
        assert_eq!(flock.id(SheepIx(0)).as_str(), "s1");
    }

    #[test]
    fn the_fingerprint_is_of_the_meaning() {
        let arcs = [(0, 1, 1.0), (1, 0, 1.0), (1, 1, 1.0)];
        let hash = |manifest| Flock::new(manifest).hash();
        let mut other = manifest(2, &arcs);
        other.name = "renamed".into();
        other.sheep[0].repeat = 3;
        other.transitions.reverse();
        assert_eq!(hash(other.clone()), hash(manifest(2, &arcs)));
        other.transitions[0].weight = 2.0;
        assert_ne!(hash(other), hash(manifest(2, &arcs)));
    }
}

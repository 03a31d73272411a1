//! The graph of sheep and transitions, in compressed form.
//!
//! Owns ordinals: sheep are counted in the order of their ids, exits in the order of (from, to), so that the walk does not
//! depend on the manifest's order. Clips and wants stay in the manifest, at the index that [`Graph::sheep_in_manifest`] and
//! [`Graph::transition_in_manifest`] return. Connected components are in `structure.rs`.

mod structure;

use std::collections::HashMap;
use std::ops::Range;

use crate::manifest::{Manifest, SheepId};
pub use structure::Structure;
pub(crate) use structure::classes;

/// A sheep's ordinal in its [`Graph`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SheepIx(pub(crate) u32);

/// A transition's ordinal in its [`Graph`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Exit(pub(crate) u32);

impl SheepIx {
    /// The ordinal as an index into tables of sheep.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

impl Exit {
    /// The ordinal as an index into tables of exits.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// The factor for weights whose sum is infinite: with it up to 2^32 transitions of a sheep have a finite sum. Other
/// weights are not scaled, because the smallest would become 0.
const SCALE: f64 = 1.0 / (1u64 << 33) as f64;

/// The probabilities of exits with these weights, each finite and above 0.
fn chances(weights: &[f64]) -> impl Iterator<Item = f64> {
    let sum: f64 = weights.iter().sum();
    let scale = if sum.is_finite() { 1.0 } else { SCALE };
    let total: f64 = weights.iter().map(|weight| weight * scale).sum();
    weights.iter().map(move |weight| weight * scale / total)
}

/// Sheep and their exits in compressed rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Graph {
    ids: Vec<SheepId>,
    sheep_written: Vec<u32>,
    /// Where each sheep's exits start, and the end: one longer than `ids`.
    first: Vec<u32>,
    target: Vec<SheepIx>,
    weight: Vec<f64>,
    chance: Vec<f64>,
    exit_written: Vec<u32>,
}

/// An exit before it has its row.
struct Arc {
    from: u32,
    to: u32,
    weight: f64,
    written: u32,
}

impl Graph {
    /// The graph of `manifest`. Of duplicate sheep or transitions the first counts; a transition of an unknown sheep is
    /// left out. `faults` reports both.
    pub fn new(manifest: &Manifest) -> Self {
        let mut order: Vec<u32> = (0..manifest.sheep.len() as u32).collect();
        order.sort_by_key(|&at| &manifest.sheep[at as usize].id);
        order.dedup_by_key(|at| &manifest.sheep[*at as usize].id);
        let ids: Vec<SheepId> = order.iter().map(|&at| manifest.sheep[at as usize].id.clone()).collect();
        let ordinal: HashMap<&SheepId, u32> = ids.iter().zip(0..).collect();
        let mut arcs: Vec<Arc> = Vec::with_capacity(manifest.transitions.len());
        // Transitions from one sheep are mostly adjacent: it is looked up once for all of them.
        let mut last: Option<(&SheepId, Option<u32>)> = None;
        for (written, transition) in (0..).zip(&manifest.transitions) {
            let from = match last {
                Some((id, from)) if *id == transition.from => from,
                _ => ordinal.get(&transition.from).copied(),
            };
            last = Some((&transition.from, from));
            if let (Some(from), Some(&to)) = (from, ordinal.get(&transition.to)) {
                arcs.push(Arc { from, to, weight: transition.weight, written });
            }
        }
        arcs.sort_by_key(|arc| u64::from(arc.from) << 32 | u64::from(arc.to));
        arcs.dedup_by_key(|arc| (arc.from, arc.to));
        Self::from_arcs(ids, order, &arcs)
    }

    /// The graph of the sheep for which `keep` holds and the transitions among them. Probabilities are normalised to these.
    #[must_use]
    pub fn restricted(&self, keep: impl Fn(SheepIx) -> bool) -> Self {
        let kept: Vec<SheepIx> = self.sheep().filter(|&sheep| keep(sheep)).collect();
        let mut ordinal = vec![None; self.len()];
        for (at, sheep) in (0..).zip(&kept) {
            ordinal[sheep.index()] = Some(at);
        }
        let mut arcs = Vec::new();
        for &sheep in &kept {
            for exit in self.exits(sheep) {
                if let (Some(from), Some(to)) = (ordinal[sheep.index()], ordinal[self.target(exit).index()]) {
                    arcs.push(Arc { from, to, weight: self.weight(exit), written: self.exit_written[exit.index()] });
                }
            }
        }
        let ids = kept.iter().map(|&sheep| self.id(sheep).clone()).collect();
        let written = kept.iter().map(|sheep| self.sheep_written[sheep.index()]).collect();
        Self::from_arcs(ids, written, &arcs)
    }

    /// The same sheep with one more transition, the manifest's at `written`. The same graph if there is one between the two.
    #[must_use]
    pub(crate) fn with_exit(&self, from: SheepIx, to: SheepIx, weight: f64, written: u32) -> Self {
        let (mut new, row) = (self.clone(), self.row(from));
        let Err(at) = self.target[row.clone()].binary_search(&to) else { return new };
        new.target.insert(row.start + at, to);
        new.weight.insert(row.start + at, weight);
        new.chance.insert(row.start + at, 0.0);
        new.exit_written.insert(row.start + at, written);
        new.first[from.index() + 1..].iter_mut().for_each(|first| *first += 1);
        new.count_chances(from);
        new
    }

    /// The same sheep without the transition `exit`.
    #[must_use]
    pub(crate) fn without_exit(&self, exit: Exit) -> Self {
        let mut new = self.clone();
        let from = SheepIx(self.first.partition_point(|&first| first <= exit.0) as u32 - 1);
        new.target.remove(exit.index());
        new.weight.remove(exit.index());
        new.chance.remove(exit.index());
        new.exit_written.remove(exit.index());
        new.first[from.index() + 1..].iter_mut().for_each(|first| *first -= 1);
        new.count_chances(from);
        new
    }

    /// Computes the probabilities of the exits of `sheep`.
    fn count_chances(&mut self, sheep: SheepIx) {
        let row = self.row(sheep);
        for (at, chance) in row.clone().zip(chances(&self.weight[row])) {
            self.chance[at] = chance;
        }
    }

    /// The same sheep and transitions with other weights, by the ordinals of exits; each finite and above 0.
    #[must_use]
    pub(crate) fn reweighted(&self, weights: &[f64]) -> Self {
        let mut chance = Vec::with_capacity(weights.len());
        self.sheep().for_each(|sheep| chance.extend(chances(&weights[self.row(sheep)])));
        Self {
            ids: self.ids.clone(),
            sheep_written: self.sheep_written.clone(),
            first: self.first.clone(),
            target: self.target.clone(),
            weight: weights.to_vec(),
            chance,
            exit_written: self.exit_written.clone(),
        }
    }

    fn from_arcs(ids: Vec<SheepId>, sheep_written: Vec<u32>, arcs: &[Arc]) -> Self {
        let mut first = vec![0; ids.len() + 1];
        for arc in arcs {
            first[arc.from as usize + 1] += 1;
        }
        for at in 1..first.len() {
            first[at] += first[at - 1];
        }
        let rows = arcs.chunk_by(|one, next| one.from == next.from);
        let weights = |row: &[Arc]| -> Vec<f64> { row.iter().map(|arc| arc.weight).collect() };
        let mut chance = Vec::with_capacity(arcs.len());
        rows.for_each(|row| chance.extend(chances(&weights(row))));
        Self {
            ids,
            sheep_written,
            first,
            target: arcs.iter().map(|arc| SheepIx(arc.to)).collect(),
            weight: weights(arcs),
            chance,
            exit_written: arcs.iter().map(|arc| arc.written).collect(),
        }
    }

    /// How many sheep it has.
    pub fn len(&self) -> usize {
        self.ids.len()
    }

    /// Whether it has no sheep.
    pub fn is_empty(&self) -> bool {
        self.ids.is_empty()
    }

    /// How many transitions it has.
    pub fn exit_count(&self) -> usize {
        self.target.len()
    }

    /// All sheep, in the order of their ids.
    pub fn sheep(&self) -> impl DoubleEndedIterator<Item = SheepIx> + use<> {
        (0..self.len() as u32).map(SheepIx)
    }

    /// The transitions from `sheep`, in the order of their targets.
    pub fn exits(&self, sheep: SheepIx) -> impl ExactSizeIterator<Item = Exit> + Clone + use<> {
        let Range { start, end } = self.row(sheep);
        (start as u32..end as u32).map(Exit)
    }

    /// The range of the exits of `sheep` in tables of exits.
    pub(crate) fn row(&self, sheep: SheepIx) -> Range<usize> {
        self.first[sheep.index()] as usize..self.first[sheep.index() + 1] as usize
    }

    /// The start of each sheep's exits in tables of exits, and the end.
    pub(crate) fn rows(&self) -> &[u32] {
        &self.first
    }

    /// Where `exit` leads.
    pub fn target(&self, exit: Exit) -> SheepIx {
        self.target[exit.index()]
    }

    /// The weight of `exit` as written.
    pub fn weight(&self, exit: Exit) -> f64 {
        self.weight[exit.index()]
    }

    /// The weights of the transitions from `sheep` as written, in the order of their targets.
    pub(crate) fn weights(&self, sheep: SheepIx) -> &[f64] {
        &self.weight[self.row(sheep)]
    }

    /// `p(exit)`: its weight divided by the weights of all exits of the same sheep.
    pub fn chance(&self, exit: Exit) -> f64 {
        self.chance[exit.index()]
    }

    /// The id of `sheep`.
    pub fn id(&self, sheep: SheepIx) -> &SheepId {
        &self.ids[sheep.index()]
    }

    /// The sheep called `id`.
    pub fn find(&self, id: &SheepId) -> Option<SheepIx> {
        self.ids.binary_search(id).ok().map(|at| SheepIx(at as u32))
    }

    /// The transition between two sheep.
    pub fn between(&self, from: SheepIx, to: SheepIx) -> Option<Exit> {
        let row = self.row(from);
        let at = self.target[row.clone()].binary_search(&to).ok()?;
        Some(Exit((row.start + at) as u32))
    }

    /// The index of `sheep` among the manifest's sheep.
    pub fn sheep_in_manifest(&self, sheep: SheepIx) -> usize {
        self.sheep_written[sheep.index()] as usize
    }

    /// The index of `exit` among the manifest's transitions.
    pub fn transition_in_manifest(&self, exit: Exit) -> usize {
        self.exit_written[exit.index()] as usize
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::manifest::{Clip, ClipPath, Sheep, Transition};
    use timing::{FrameCount, Rate};

    /// A flock of `n` sheep `s0`, `s1`, ... each with a loop, and weighted transitions. A step takes 50 s.
    pub(crate) fn manifest(n: usize, arcs: &[(usize, usize, f64)]) -> Manifest {
        let id = |at: usize| SheepId::new(&format!("s{at}")).unwrap();
        let clip = |path: String| Clip { path: ClipPath::new(&path).unwrap(), frames: FrameCount(750), hash: None };
        Manifest {
            name: "test".into(),
            size: (64, 64),
            fps: Rate::new(30, 1).unwrap(),
            sheep: (0..n)
                .map(|at| Sheep {
                    id: id(at),
                    clip: Some(clip(format!("loops/{at}"))),
                    genome: None,
                    want: 1.0,
                    repeat: 1,
                })
                .collect(),
            transitions: arcs
                .iter()
                .map(|&(from, to, weight)| Transition {
                    from: id(from),
                    to: id(to),
                    clip: clip(format!("transitions/{from}={to}")),
                    weight,
                })
                .collect(),
        }
    }

    #[test]
    fn weights_whose_sum_is_beyond_all_numbers_are_chances_too() {
        let graph = Graph::new(&manifest(2, &[(0, 0, f64::MAX), (0, 1, f64::MAX), (1, 0, f64::MIN_POSITIVE)]));
        assert_eq!([0, 1, 2].map(|exit| graph.chance(Exit(exit)).to_bits()), [0.5, 0.5, 1.0].map(f64::to_bits));
    }

    #[test]
    fn the_smallest_weights_are_chances_too() {
        let least = f64::from_bits(1);
        let graph = Graph::new(&manifest(2, &[(0, 0, least), (0, 1, least), (1, 0, least)]));
        for graph in [graph.reweighted(&[least; 3]), graph] {
            assert_eq!([0, 1, 2].map(|exit| graph.chance(Exit(exit)).to_bits()), [0.5, 0.5, 1.0].map(f64::to_bits));
        }
    }

    #[test]
    fn a_transition_more_or_less_gives_the_graph_that_the_manifest_would() {
        let arcs = [(0, 1, 1.0), (1, 2, 3.0), (1, 0, 1.0), (2, 0, 1.0)];
        let graph = Graph::new(&manifest(4, &arcs));
        for (from, to) in [(0, 0), (0, 3), (1, 1), (3, 0), (2, 3)] {
            let more = graph.with_exit(SheepIx(from), SheepIx(to), 0.7, 4);
            let all = [&arcs[..], &[(from as usize, to as usize, 0.7)]].concat();
            assert_eq!(more, Graph::new(&manifest(4, &all)));
            let exit = more.between(SheepIx(from), SheepIx(to)).unwrap();
            assert_eq!(more.without_exit(exit), graph);
        }
        assert_eq!(graph.with_exit(SheepIx(1), SheepIx(0), 0.7, 4), graph);
    }

    #[test]
    fn the_order_of_the_manifest_means_nothing() {
        let mut turned = manifest(3, &[(0, 1, 1.0), (1, 2, 3.0), (1, 0, 1.0), (2, 0, 1.0)]);
        let graph = Graph::new(&turned);
        turned.sheep.reverse();
        turned.transitions.reverse();
        let other = Graph::new(&turned);
        for sheep in graph.sheep() {
            assert_eq!(graph.id(sheep), other.id(sheep));
            let row = |g: &Graph| g.exits(sheep).map(|e| (g.target(e), g.chance(e))).collect::<Vec<_>>();
            assert_eq!(row(&graph), row(&other));
        }
        let chance = graph.chance(graph.between(SheepIx(1), SheepIx(2)).unwrap());
        assert!((chance - 0.75).abs() < 1e-15, "{chance}");
    }
}

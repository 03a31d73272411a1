//! The numeric form of a flock for the solvers of the balance.
//!
//! Owns the compact form of the part that is played; `circulation.rs` solves it.

use crate::graph::Graph;

/// A strongly connected class, sheep and transitions by their ordinals in the graph it came from.
#[derive(Clone, Debug)]
pub(super) struct Network {
    /// Where each sheep's exits start, and the end: one longer than there are sheep.
    pub(super) first: Vec<u32>,
    /// Where each transition starts.
    pub(super) from: Vec<u32>,
    /// Where each transition ends.
    pub(super) to: Vec<u32>,
    /// The logarithm of each transition's part of all weights as written.
    pub(super) prior: Vec<f64>,
    /// The share that each sheep should get; they sum to 1, and none is 0.
    pub(super) want: Vec<f64>,
}

/// No want counts for less than this part of the largest: a visit in millions of years.
const MIN_WANT: f64 = 1e-12;
/// Lower bound of a weight relative to the largest, as a logarithm (1e-15), so that prices stay finite.
const MIN_PRIOR: f64 = -34.5;

impl Network {
    /// The network of `graph`, whose sheep are wanted as often as `wants` say, relative to each other.
    pub(super) fn new(graph: &Graph, wants: &[f64]) -> Self {
        let (mut first, mut from, mut to, mut prior) = (vec![0], Vec::new(), Vec::new(), Vec::new());
        for sheep in graph.sheep() {
            for exit in graph.exits(sheep) {
                from.push(sheep.index() as u32);
                to.push(graph.target(exit).index() as u32);
                prior.push(graph.weight(exit).ln());
            }
            first.push(from.len() as u32);
        }
        let mut network = Self { first, from, to, prior, want: parts(wants) };
        network.normalise();
        network
    }

    /// How many sheep it has.
    pub(super) fn len(&self) -> usize {
        self.want.len()
    }

    /// How many transitions it has.
    pub(super) fn arcs(&self) -> usize {
        self.to.len()
    }

    /// The exits of `sheep`, as indices into the tables of transitions.
    pub(super) fn exits(&self, sheep: usize) -> std::ops::Range<usize> {
        self.first[sheep] as usize..self.first[sheep + 1] as usize
    }

    /// Both ends of a transition.
    pub(super) fn ends(&self, arc: usize) -> (usize, usize) {
        (self.from[arc] as usize, self.to[arc] as usize)
    }

    /// The network without the transitions for which `keep` is false.
    pub(super) fn restricted(&self, keep: &[bool]) -> Self {
        let kept: Vec<(u32, u32, f64)> = (0..self.arcs())
            .filter(|&arc| keep[arc])
            .map(|arc| (self.from[arc], self.to[arc], self.prior[arc]))
            .collect();
        self.with_arcs(&kept)
    }

    /// The same sheep with other transitions, sorted by where they start: from, to, prior.
    pub(super) fn with_arcs(&self, arcs: &[(u32, u32, f64)]) -> Self {
        let mut first = vec![0; self.first.len()];
        for &(from, ..) in arcs {
            first[from as usize + 1] += 1;
        }
        for at in 1..first.len() {
            first[at] += first[at - 1];
        }
        let mut network = Self {
            first,
            from: arcs.iter().map(|arc| arc.0).collect(),
            to: arcs.iter().map(|arc| arc.1).collect(),
            prior: arcs.iter().map(|arc| arc.2).collect(),
            want: self.want.clone(),
        };
        network.normalise();
        network
    }

    /// Makes the parts of the weights sum to 1. In logarithms, because weights may differ by hundreds of decades.
    fn normalise(&mut self) {
        let most = self.prior.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        for prior in &mut self.prior {
            *prior = prior.max(most + MIN_PRIOR);
        }
        let total = most + self.prior.iter().map(|prior| (prior - most).exp()).sum::<f64>().ln();
        for prior in &mut self.prior {
            *prior -= total;
        }
    }
}

/// The positive `figures` as parts of their sum, which may be infinite.
pub(super) fn parts(figures: &[f64]) -> Vec<f64> {
    let most = figures.iter().copied().fold(0.0, f64::max);
    let parts: Vec<f64> = figures.iter().map(|figure| (figure / most).max(MIN_WANT)).collect();
    let total: f64 = parts.iter().sum();
    parts.into_iter().map(|part| part / total).collect()
}

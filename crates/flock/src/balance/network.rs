//! The numeric form of a flock for the solvers of the balance.
//!
//! Owns the compact form of the part that is played; `circulation.rs` solves it.

use super::wants::{Wants, parts};
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
    /// The part of all visits that each sheep should get; they sum to 1, and none is 0.
    pub(super) want: Vec<f64>,
    /// The share that each sheep should get in the measure of the balance; they sum to 1, but for sheep of which nothing is
    /// wanted: those have 0, may be visited as often as the others need, and their `want` is only a start.
    pub(super) share: Vec<f64>,
}

/// How much the visits of a sheep of which nothing is wanted count, relative to the others.
const FREE: f64 = 1e-3;
/// Lower bound of a weight relative to the largest, as a logarithm (1e-15), so that prices stay finite.
const MIN_PRIOR: f64 = -34.5;

impl Network {
    /// The network of `graph`, whose sheep are wanted as `wants` say.
    pub(super) fn new(graph: &Graph, wants: &Wants) -> Self {
        let arcs = graph.exit_count();
        let [mut from, mut to] = [Vec::with_capacity(arcs), Vec::with_capacity(arcs)];
        let (mut first, mut prior) = (vec![0], Vec::with_capacity(arcs));
        for sheep in graph.sheep() {
            for exit in graph.exits(sheep) {
                from.push(sheep.index() as u32);
                to.push(graph.target(exit).index() as u32);
                prior.push(graph.weight(exit).ln());
            }
            first.push(from.len() as u32);
        }
        let mut network = Self { first, from, to, prior, want: parts(&wants.visits), share: wants.shares.clone() };
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

    /// Whether `sheep` may be visited as often as the others need.
    pub(super) fn is_free(&self, sheep: usize) -> bool {
        self.share[sheep] == 0.0
    }

    /// The part of `want` that is of sheep of which something is wanted.
    pub(super) fn wanted(&self) -> f64 {
        (0..self.len()).filter(|&sheep| !self.is_free(sheep)).map(|sheep| self.want[sheep]).sum()
    }

    /// What `flow` is to be multiplied by so that sheep of which something is wanted have as many visits as they should.
    pub(super) fn scale_of(&self, flow: &[f64]) -> f64 {
        if !(0..self.len()).any(|sheep| self.is_free(sheep)) {
            return 1.0;
        }
        let of = |sheep: usize| flow[self.exits(sheep)].iter().sum::<f64>();
        let visits: f64 = (0..self.len()).filter(|&sheep| !self.is_free(sheep)).map(of).sum();
        if visits > 0.0 { self.wanted() / visits } else { 1.0 }
    }

    /// How much the visits of `sheep` count, relative to the others.
    pub(super) fn importance(&self, sheep: usize) -> f64 {
        if self.is_free(sheep) { FREE } else { 1.0 }
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
            share: self.share.clone(),
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

//! The transition probabilities of a graph, by target.
//!
//! Owns the Markov chain for which shares are solved: for each sheep its incoming probabilities, and the sum of its
//! outgoing ones. Self-loops are left out: the outgoing sum contains the same information, without a subtraction.

use crate::graph::{Graph, SheepIx};

/// The probabilities among `n` sheep, without self-loops.
#[derive(Clone, Debug)]
pub(super) struct Chain {
    /// The start of each sheep's incoming probabilities, and the end.
    first: Vec<u32>,
    /// From which sheep it comes.
    from: Vec<u32>,
    /// The probability of that transition.
    chance: Vec<f64>,
    /// The sum of each sheep's outgoing probabilities.
    leaving: Vec<f64>,
}

impl Chain {
    /// The chances of `graph`.
    pub(super) fn of(graph: &Graph) -> Self {
        let of_sheep =
            |from: SheepIx| graph.exits(from).map(move |exit| (from.0, graph.target(exit).0, graph.chance(exit)));
        Self::new(graph.len(), || graph.sheep().flat_map(of_sheep))
    }

    /// A chain of `n` sheep from `(from, to, chance)`, which is iterated twice; self-loops are left out.
    pub(super) fn new<I: Iterator<Item = (u32, u32, f64)>>(n: usize, list: impl Fn() -> I) -> Self {
        let arcs = || list().filter(|&(from, to, _)| from != to);
        let (mut first, mut leaving) = (vec![0u32; n + 2], vec![0.0; n]);
        for (from, to, chance) in arcs() {
            first[to as usize + 2] += 1;
            leaving[from as usize] += chance;
        }
        for at in 2..first.len() {
            first[at] += first[at - 1];
        }
        let count = first[n + 1] as usize;
        let (mut sources, mut chances) = (vec![0; count], vec![0.0; count]);
        for (from, to, chance) in arcs() {
            let next = &mut first[to as usize + 1];
            sources[*next as usize] = from;
            chances[*next as usize] = chance;
            *next += 1;
        }
        first.pop();
        Self { first, from: sources, chance: chances, leaving }
    }

    /// How many sheep there are.
    pub(super) fn len(&self) -> usize {
        self.leaving.len()
    }

    /// How many chances there are.
    pub(super) fn arc_count(&self) -> usize {
        self.from.len()
    }

    /// The incoming probabilities of `sheep`, with their sources.
    pub(super) fn arriving(&self, sheep: usize) -> impl Iterator<Item = (usize, f64)> {
        let row = self.first[sheep] as usize..self.first[sheep + 1] as usize;
        self.from[row.clone()].iter().map(|&from| from as usize).zip(self.chance[row].iter().copied())
    }

    /// Every probability as (from, to, chance), in the order of targets.
    pub(super) fn arcs(&self) -> impl Iterator<Item = (usize, usize, f64)> {
        (0..self.len()).flat_map(|to| self.arriving(to).map(move |(from, chance)| (from, to, chance)))
    }

    /// The probability that `sheep` is left for another one.
    pub(super) fn leaving(&self, sheep: usize) -> f64 {
        self.leaving[sheep]
    }
}

/// Makes `shares` sum to 1.
pub(super) fn normalise(shares: &mut [f64]) {
    let total: f64 = shares.iter().sum();
    for share in shares {
        *share /= total;
    }
}

/// Scales all `shares` down if the newest one is too large.
pub(super) fn keep_in_range(shares: &mut [f64], newest: usize) {
    // Far below the largest number, to leave room for the next ones.
    const LARGE: f64 = 1e200;
    if shares[newest] > LARGE {
        for share in shares {
            *share /= LARGE;
        }
    }
}

//! How often each sheep is visited, and each transition taken, in the long run.
//!
//! Owns the stationary distribution of the chances of one strongly connected class. Never subtracts: each share is
//! right to the last bits however small it is. Never knows wants or clips: `flock_shares.rs` does.
//!
//! Start at [`Shares::of`].

use crate::graph::{Exit, Graph, SheepIx};
use crate::structure::Structure;

/// Up to so many sheep the elimination is dense and exact: 18 MB, a fraction of a second.
const DENSE: usize = 1500;
/// Sweeps stop when a whole sweep moves the shares by less than this in total.
const STILL: f64 = 1e-13;
/// Most sweeps: a flock of communities with few bridges may stop short of [`STILL`].
const MOST_SWEEPS: usize = 3000;
/// How far a sweep goes towards its answer; below 1 so that a ring swept backwards settles too.
const RELAX: f64 = 0.95;

/// The long-run fractions of a walk on one strongly connected class, by the ordinals of its graph.
///
/// A step is one transition and the visit that it leads to. In the long run the walk's visits are the stationary
/// distribution of the chances `p`, whatever steers it: its credits keep `|taken - p * visits|` bounded for ever.
#[derive(Clone, Debug, PartialEq)]
pub struct Shares {
    visits: Vec<f64>,
    taken: Vec<f64>,
}

/// Why a graph has no shares.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SharesError {
    /// Where a walk ends up depends on where it begins.
    #[error("the graph falls into {found} strongly connected classes, shares are those of one")]
    Classes {
        /// How many there are.
        found: usize,
    },
}

impl Shares {
    /// The shares of the walk on `graph`. A single sheep without exits has all visits.
    ///
    /// # Errors
    /// [`SharesError::Classes`] unless every sheep of `graph` can be come to from every other; an empty graph has no
    /// class at all.
    ///
    /// # Source
    /// Grassmann, Taksar & Heyman (1985) up to 1,500 sheep; above, relaxed Gauss-Seidel sweeps.
    pub fn of(graph: &Graph) -> Result<Self, SharesError> {
        let found = Structure::of(graph).class_count();
        if found != 1 {
            return Err(SharesError::Classes { found });
        }
        let mut visits = if graph.len() <= DENSE { eliminated(graph) } else { swept(graph) };
        normalise(&mut visits);
        let of_exits = |sheep: SheepIx| graph.exits(sheep).map(move |exit| (sheep, exit));
        let taken = graph.sheep().flat_map(of_exits).map(|(sheep, exit)| visits[sheep.index()] * graph.chance(exit));
        Ok(Self { taken: taken.collect(), visits })
    }

    /// The fraction of visits that `sheep` gets; all of them sum to 1.
    pub fn visits(&self, sheep: SheepIx) -> f64 {
        self.visits[sheep.index()]
    }

    /// The fraction of steps that take `exit`; all of them sum to 1.
    pub fn taken(&self, exit: Exit) -> f64 {
        self.taken[exit.index()]
    }

    /// How evenly the visits are spread: the entropy of their distribution, in bits; the most that `n` sheep can have
    /// is `log2 n`.
    pub fn entropy_bits(&self) -> f64 {
        -self.visits.iter().filter(|&&share| share > 0.0).map(|share| share * share.log2()).sum::<f64>()
    }
}

fn normalise(visits: &mut [f64]) {
    let total: f64 = visits.iter().sum();
    for share in visits {
        *share /= total;
    }
}

/// Censors the sheep out of the chain one by one, then puts them back.
fn eliminated(graph: &Graph) -> Vec<f64> {
    let n = graph.len();
    let mut flow = vec![0.0; n * n];
    for from in graph.sheep() {
        for exit in graph.exits(from) {
            flow[from.index() * n + graph.target(exit).index()] += graph.chance(exit);
        }
    }
    for gone in (1..n).rev() {
        let (rest, row) = flow.split_at_mut(gone * n);
        let row = &row[..gone];
        let out: f64 = row.iter().sum();
        for from in rest.chunks_exact_mut(n) {
            from[gone] /= out;
            let into = from[gone];
            if into > 0.0 {
                for (to, &chance) in from.iter_mut().zip(row) {
                    *to += into * chance;
                }
            }
        }
    }
    let mut visits = vec![1.0; n];
    for at in 1..n {
        visits[at] = (0..at).map(|from| visits[from] * flow[from * n + at]).sum();
    }
    visits
}

/// Lets every sheep take what the others bring it, again and again.
fn swept(graph: &Graph) -> Vec<f64> {
    let n = graph.len();
    let mut first = vec![0usize; n + 1];
    let mut stays = vec![0.0; n];
    for from in graph.sheep() {
        for exit in graph.exits(from) {
            first[graph.target(exit).index() + 1] += 1;
        }
    }
    for at in 1..=n {
        first[at] += first[at - 1];
    }
    let mut next = first.clone();
    let mut brings = vec![(0u32, 0.0); graph.exit_count()];
    for from in graph.sheep() {
        for exit in graph.exits(from) {
            let to = graph.target(exit);
            if to == from {
                stays[to.index()] = graph.chance(exit);
            }
            brings[next[to.index()]] = (from.0, if to == from { 0.0 } else { graph.chance(exit) });
            next[to.index()] += 1;
        }
    }
    let mut visits = vec![1.0 / n as f64; n];
    for _ in 0..MOST_SWEEPS {
        let mut moved = 0.0;
        for at in 0..n {
            let brought: f64 =
                brings[first[at]..first[at + 1]].iter().map(|&(from, p)| visits[from as usize] * p).sum();
            let change = RELAX * (brought / (1.0 - stays[at]) - visits[at]);
            visits[at] += change;
            moved += change.abs();
        }
        normalise(&mut visits);
        if moved < STILL {
            break;
        }
    }
    visits
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::tests::manifest;
    use proptest::prelude::*;

    /// How far `visits` is from what one step makes of it, in total.
    fn unrest(graph: &Graph, visits: &[f64]) -> f64 {
        let mut after = vec![0.0; graph.len()];
        for from in graph.sheep() {
            for exit in graph.exits(from) {
                after[graph.target(exit).index()] += visits[from.index()] * graph.chance(exit);
            }
        }
        after.iter().zip(visits).map(|(a, b)| (a - b).abs()).sum()
    }

    #[test]
    fn the_weighted_pair_is_known_by_hand() {
        let graph = Graph::new(&manifest(2, &[(0, 0, 3.0), (0, 1, 1.0), (1, 0, 1.0)]));
        assert_eq!(Shares::of(&graph).unwrap().visits, [0.8, 0.2]);
    }

    #[test]
    fn a_share_of_a_millionth_is_right_to_the_last_bits() {
        // Two pairs held together by chances of 1e-12: exact by symmetry.
        let e = 1e-12;
        let arcs = [(0, 1, 1.0), (1, 0, 1.0), (1, 2, e), (2, 3, 1.0), (3, 2, 1.0), (3, 0, 2.0 * e), (2, 2, 1.0)];
        let graph = Graph::new(&manifest(4, &arcs));
        let visits = Shares::of(&graph).unwrap().visits;
        let flows = (visits[1] * e / (1.0 + e)) / (visits[3] * 2.0 * e / (1.0 + 2.0 * e));
        assert!((flows - 1.0).abs() < 1e-14, "{flows}");
    }

    proptest! {
        #[test]
        fn both_ways_agree(
            ring in 2usize..30,
            more in prop::collection::vec((0usize..30, 0usize..30, 0.1f64..5.0), 0..60),
        ) {
            let mut arcs: Vec<_> = (0..ring).map(|at| (at, (at + 1) % ring, 1.0)).collect();
            arcs.extend(more.into_iter().map(|(a, b, w)| (a % ring, b % ring, w)));
            let graph = Graph::new(&manifest(ring, &arcs));
            let exact = Shares::of(&graph).unwrap().visits;
            prop_assert!(unrest(&graph, &exact) < 1e-14);
            let mut rough = swept(&graph);
            normalise(&mut rough);
            for (a, b) in exact.iter().zip(&rough) {
                prop_assert!((a - b).abs() < 1e-9, "{a} {b}");
            }
        }
    }
}

//! The credits of all exits.
//!
//! Owns the counts of transitions taken and the rule for all steering: an exit whose credit is at or below
//! [`-THETA`](THETA) may not be taken. `mod.rs` chooses among the allowed exits.

use crate::graph::{Exit, Graph, SheepIx};

/// How far an exit's count may exceed its expectation. A constant of the flock format.
///
/// From it follows, for all time and any choice: `|taken - p * visits| <= (1 + THETA) * max(1, exits - 1)`.
pub(crate) const THETA: f64 = 4.0;

/// How often each exit was taken, by the graph's ordinals.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Ledger {
    taken: Vec<u64>,
}

impl Ledger {
    /// Nothing taken yet, on `graph`.
    pub(crate) fn new(graph: &Graph) -> Self {
        Self { taken: vec![0; graph.exit_count()] }
    }

    /// Counts as they were; one for each exit of the graph.
    pub(crate) fn with(taken: Vec<u64>) -> Self {
        Self { taken }
    }

    /// Counts by exit.
    pub(crate) fn counts(&self) -> &[u64] {
        &self.taken
    }

    /// How often `exit` was taken.
    pub(crate) fn taken(&self, exit: Exit) -> u64 {
        self.taken[exit.index()]
    }

    /// How often `sheep` was left, by any exit.
    pub(crate) fn left(&self, graph: &Graph, sheep: SheepIx) -> u64 {
        self.taken[graph.row(sheep)].iter().sum()
    }

    /// The expected count of `exit` after `visits` visits of its sheep, minus its actual count. The credits of a
    /// sheep's exits sum to 1 during a visit and to 0 after it.
    pub(crate) fn credit(&self, graph: &Graph, exit: Exit, visits: u64) -> f64 {
        // Computed from counts each time, so that no rounding error accumulates.
        graph.chance(exit) * visits as f64 - self.taken(exit) as f64
    }

    /// The exits of `sheep` with their credits at its present visit.
    pub(crate) fn credits<'a>(
        &'a self,
        graph: &'a Graph,
        sheep: SheepIx,
    ) -> impl Iterator<Item = (Exit, f64)> + use<'a> {
        let visits = self.left(graph, sheep) + 1;
        graph.exits(sheep).map(move |exit| (exit, self.credit(graph, exit, visits)))
    }

    /// The exits of `sheep` that may be taken from its present visit, with their credits. Never empty unless the
    /// sheep has no exit, since the credits sum to 1.
    pub(crate) fn allowed<'a>(
        &'a self,
        graph: &'a Graph,
        sheep: SheepIx,
    ) -> impl Iterator<Item = (Exit, f64)> + use<'a> {
        self.credits(graph, sheep).filter(|&(_, credit)| credit > -THETA)
    }

    /// Counts that `exit` was taken.
    pub(crate) fn take(&mut self, exit: Exit) {
        self.taken[exit.index()] += 1;
    }

    /// Whether no exit of `sheep` exceeds its expectation by more than a walk allows: then the bound holds for ever.
    /// Counts from another flock may violate this.
    pub(crate) fn is_sound(&self, graph: &Graph, sheep: SheepIx) -> bool {
        let visits = self.left(graph, sheep);
        // The lower bound follows, since the credits sum to 0.
        graph.exits(sheep).all(|exit| self.credit(graph, exit, visits) >= -(1.0 + THETA))
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::graph::tests::manifest;
    use proptest::prelude::*;

    /// The largest deviation of an exit's count for a sheep with `exits`.
    fn bound(exits: usize) -> f64 {
        (1.0 + THETA) * exits.saturating_sub(1).max(1) as f64
    }

    /// Whether the counts of the exits of `sheep`, which is not being visited, are within the bound.
    pub(in crate::walk) fn keeps_the_bound(ledger: &Ledger, graph: &Graph, sheep: SheepIx) -> bool {
        let (visits, bound) = (ledger.left(graph, sheep), bound(graph.exits(sheep).len()));
        let is_near = |exit| ledger.credit(graph, exit, visits).abs() <= bound;
        ledger.is_sound(graph, sheep) && graph.exits(sheep).all(is_near)
    }

    /// How an adversary picks among what is allowed.
    #[derive(Clone, Copy, Debug)]
    enum Adversary {
        /// Always the first, the last, the most overdue, or the most advanced exit.
        First,
        Last,
        MostOwed,
        LeastOwed,
        /// By a hash of the step.
        Scattered,
        /// One favourite for a thousand visits, then the next.
        Moody,
    }

    fn pick(adversary: Adversary, step: usize, allowed: &[(Exit, f64)]) -> Exit {
        let by_credit = |a: &&(Exit, f64), b: &&(Exit, f64)| a.1.total_cmp(&b.1);
        let at = |index: usize| &allowed[index % allowed.len()];
        match adversary {
            Adversary::First => at(0).0,
            Adversary::Last => at(allowed.len() - 1).0,
            Adversary::MostOwed => allowed.iter().max_by(by_credit).unwrap().0,
            Adversary::LeastOwed => allowed.iter().min_by(by_credit).unwrap().0,
            Adversary::Scattered => at(step.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 33).0,
            Adversary::Moody => at(step / 1000).0,
        }
    }

    proptest! {
        #[test]
        fn no_steering_breaks_the_credit_bound(
            ring in 1usize..12,
            more in prop::collection::vec((0usize..12, 0usize..12, 0.001f64..50.0), 0..80),
            adversary in prop_oneof![
                Just(Adversary::First), Just(Adversary::Last), Just(Adversary::MostOwed),
                Just(Adversary::LeastOwed), Just(Adversary::Scattered), Just(Adversary::Moody),
            ],
        ) {
            let mut arcs: Vec<_> = (0..ring).map(|at| (at, (at + 1) % ring, 1.0)).collect();
            arcs.extend(more.into_iter().map(|(a, b, w)| (a % ring, b % ring, w)));
            let graph = Graph::new(&manifest(ring, &arcs));
            let mut ledger = Ledger::new(&graph);
            let mut place = SheepIx(0);
            for step in 0..4000 {
                let allowed: Vec<_> = ledger.allowed(&graph, place).collect();
                prop_assert!(!allowed.is_empty());
                let exit = pick(adversary, step, &allowed);
                ledger.take(exit);
                prop_assert!(keeps_the_bound(&ledger, &graph, place), "step {step} from {place:?}");
                place = graph.target(exit);
            }
        }
    }

    #[test]
    fn counts_that_no_walk_comes_to_by_itself_are_not_sound_even_within_the_bound() {
        let graph = Graph::new(&manifest(3, &[(0, 0, 1.0), (0, 1, 1.0), (0, 2, 1.0), (1, 0, 1.0), (2, 0, 1.0)]));
        let is_sound = |taken: [u64; 3]| Ledger::with([&taken[..], &[0; 2]].concat()).is_sound(&graph, SheepIx(0));
        // 10 ahead: it is shut out for 18 visits. Meanwhile the second can get 5 ahead, and the third more than 10 behind.
        assert!(!is_sound([20, 10, 0]) && is_sound([15, 15, 0]) && is_sound([10, 10, 10]));
    }

    #[test]
    fn the_bound_is_nearly_reached_by_the_worst_adversary() {
        // Eight equal exits, one shunned for ever: it is taken only when nothing else is allowed.
        let arcs: Vec<_> = (0..8).map(|to| (0, to, 1.0)).chain((1..8).map(|from| (from, 0, 1.0))).collect();
        let graph = Graph::new(&manifest(8, &arcs));
        let (mut ledger, mut most) = (Ledger::new(&graph), 0.0f64);
        for _ in 0..10_000 {
            let exit = ledger.allowed(&graph, SheepIx(0)).next().unwrap().0;
            ledger.take(exit);
            let visits = ledger.left(&graph, SheepIx(0));
            let shunned = graph.exits(SheepIx(0)).last().unwrap();
            most = most.max(ledger.credit(&graph, shunned, visits));
        }
        assert!(most > 25.0 && most <= bound(8), "{most}");
    }
}

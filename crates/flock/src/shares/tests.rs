//! What is claimed of shares, on flocks whose shares are known because they were made from them.
//!
//! Owns those flocks: cycles of known flow laid over each other, so that as much comes in to each sheep as leaves it, and
//! the claims on every method and on the proof. Never solves for a truth: `exact.rs` does, on small flocks.

use proptest::prelude::*;
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::chain::Chain;
use super::{Shares, SharesError, dense, parts, proof, reduce, solve, sweep};
use crate::graph::tests::manifest;
use crate::graph::{Graph, SheepIx};

/// Transitions and the flow over each: cycles laid over each other, so that as much comes in to each sheep as leaves it.
struct Flows {
    n: usize,
    arcs: Vec<(u32, u32, f64)>,
}

impl Flows {
    fn new(n: usize) -> Self {
        Self { n, arcs: Vec::new() }
    }

    fn cycle(&mut self, sheep: &[usize], flow: f64) {
        let next = sheep.iter().cycle().skip(1);
        self.arcs.extend(sheep.iter().zip(next).map(|(&from, &to)| (from as u32, to as u32, flow)));
    }

    /// `count` sheep from `first` on, each led to from all the others by cycles in an order by chance.
    fn community(&mut self, random: &mut ChaCha12Rng, first: usize, count: usize, flow: impl Fn(f64) -> f64) {
        for _ in 0..4 {
            let mut order: Vec<usize> = (first..first + count).collect();
            for at in (1..count).rev() {
                order.swap(at, (random.next_u64() % (at as u64 + 1)) as usize);
            }
            self.cycle(&order, flow(unit(random)));
            for three in order.chunks_exact(3) {
                self.cycle(three, flow(unit(random)));
            }
        }
    }

    /// The shares that they were made from.
    fn shares(&self) -> Vec<f64> {
        let mut shares = vec![0.0; self.n];
        for &(from, _, flow) in &self.arcs {
            shares[from as usize] += flow;
        }
        let total: f64 = shares.iter().sum();
        shares.into_iter().map(|share| share / total).collect()
    }

    /// The chances that keep them.
    fn chain(&self) -> Chain {
        let mut leaving = vec![0.0; self.n];
        for &(from, _, flow) in &self.arcs {
            leaving[from as usize] += flow;
        }
        let mut arcs: Vec<_> =
            self.arcs.iter().map(|&(from, to, flow)| (from, to, flow / leaving[from as usize])).collect();
        arcs.sort_by_key(|&(from, to, _)| (from, to));
        arcs.dedup_by(|next, kept| {
            (next.0, next.1) == (kept.0, kept.1) && {
                kept.2 += next.2;
                true
            }
        });
        Chain::new(self.n, || arcs.iter().copied())
    }
}

fn unit(random: &mut ChaCha12Rng) -> f64 {
    (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

/// By what part of itself a share differs, at most.
fn worst(found: &[f64], truth: &[f64]) -> f64 {
    found.iter().zip(truth).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max)
}

/// `count` communities of `size` sheep in a ring, held together by flows of `bridge` one way and a little more the other.
fn split(count: usize, size: usize, bridge: f64) -> Flows {
    let mut random = ChaCha12Rng::seed_from_u64(count as u64);
    let mut flows = Flows::new(count * size);
    for at in 0..count {
        // Communities differ tenfold in what they have, their sheep threefold.
        let all = 10f64.powf(unit(&mut random));
        flows.community(&mut random, at * size, size, |by| all * (1.0 + 2.0 * by));
    }
    let gates: Vec<usize> = (0..count).map(|at| at * size).collect();
    flows.cycle(&gates, bridge);
    for pair in gates.windows(2) {
        flows.cycle(&[pair[0] + 1, pair[1] + 1], bridge / 3.0);
    }
    flows
}

fn solved_is_right(name: &str, flows: &Flows) {
    let solved = solve::solve(&flows.chain());
    let off = worst(&solved.visits, &flows.shares());
    assert!(solved.off_by < 1e-8, "{name}: proved to within {}", solved.off_by);
    assert!(off <= solved.off_by, "{name}: off by {off}, proved to within {}", solved.off_by);
}

#[test]
fn the_weighted_pair_is_known_by_hand() {
    let graph = Graph::new(&manifest(2, &[(0, 0, 3.0), (0, 1, 1.0), (1, 0, 1.0)]));
    assert_eq!(Shares::of(&graph).unwrap().visits, [0.8, 0.2]);
}

#[test]
fn what_is_no_one_class_has_no_shares() {
    let of = |n, arcs: &[_]| Shares::of(&Graph::new(&manifest(n, arcs)));
    assert_eq!(of(2, &[(0, 1, 1.0)]), Err(SharesError::Classes { found: 2 }));
    assert_eq!(of(0, &[]), Err(SharesError::Classes { found: 0 }));
    assert_eq!(of(1, &[]).map(|shares| (shares.visits(SheepIx(0)), shares.off_by() < 1e-15)), Ok((1.0, true)));
}

#[test]
fn a_share_of_a_millionth_is_right_to_the_last_bits() {
    // Two pairs held together by chances of 1e-12: exact by symmetry.
    let e = 1e-12;
    let arcs = [(0, 1, 1.0), (1, 0, 1.0), (1, 2, e), (2, 3, 1.0), (3, 2, 1.0), (3, 0, 2.0 * e), (2, 2, 1.0)];
    let shares = Shares::of(&Graph::new(&manifest(4, &arcs))).unwrap();
    let visits = &shares.visits;
    let flows = (visits[1] * e / (1.0 + e)) / (visits[3] * 2.0 * e / (1.0 + 2.0 * e));
    assert!((flows - 1.0).abs() < 1e-14, "{flows}");
    assert!(shares.off_by() < 1e-13, "{}", shares.off_by());
}

#[test]
fn flocks_that_nearly_fall_apart_are_solved_and_proved() {
    for (count, size, bridge) in [(2, 2500, 1e-2), (10, 500, 1e-3), (10, 500, 1e-9), (100, 50, 1e-6), (1000, 7, 1e-4)] {
        solved_is_right(&format!("{count} communities of {size}"), &split(count, size, bridge));
    }
}

#[test]
fn a_beat_and_weights_over_nine_orders_of_magnitude_are_solved_and_proved() {
    let mut random = ChaCha12Rng::seed_from_u64(9);
    let mut wide = Flows::new(3000);
    wide.community(&mut random, 0, 3000, |by| 10f64.powf(-9.0 * by));
    solved_is_right("wide", &wide);
    // Every cycle has a length that 3 divides: a walk on it never comes to rest.
    let mut beat = Flows::new(3000);
    for _ in 0..3 {
        let third = |random: &mut ChaCha12Rng, at: usize| 3 * (random.next_u64() % 1000) as usize + at;
        let ring: Vec<usize> = (0..3000).collect();
        beat.cycle(&ring, 1.0);
        for _ in 0..3000 {
            let three = [0, 1, 2].map(|at| third(&mut random, at));
            beat.cycle(&three, unit(&mut random) + 0.1);
        }
    }
    solved_is_right("beat", &beat);
}

#[test]
fn a_long_chain_is_solved_and_proved() {
    // 30,000 sheep in a row, each led to from its neighbours; the shares wander over many orders of magnitude.
    let (mut random, mut flow) = (ChaCha12Rng::seed_from_u64(4), 1.0);
    let mut chain = Flows::new(30_000);
    for at in 1..30_000 {
        flow *= (0.2 * (unit(&mut random) - 0.5)).exp();
        chain.cycle(&[at - 1, at], flow);
    }
    solved_is_right("chain", &chain);
}

#[test]
fn a_small_residual_is_no_proof() {
    // Two communities whose shares of the whole are wrong by half: only the bridge knows.
    let flows = split(2, 50, 1e-9);
    let (chain, mut wrong) = (flows.chain(), flows.shares());
    assert!(proof::off_by(&chain, &wrong) < 1e-5);
    for share in &mut wrong[..50] {
        *share *= 1.5;
    }
    let brought = |to: usize| chain.arriving(to).map(|(from, chance)| wrong[from] * chance).sum::<f64>();
    let residual: f64 = (0..100).map(|to| (brought(to) - wrong[to]).abs()).sum();
    assert!(residual < 1e-9, "{residual}");
    assert!(proof::off_by(&chain, &wrong) >= 0.5);
}

#[test]
fn what_numbers_cannot_tell_is_not_called_proved() {
    // Each of 2,000 sheep is left upwards a million times as readly as downwards: the lowest has 1e-12000 of all.
    let arcs = (1..2000usize).flat_map(|at| [(at - 1, at, 1.0), (at, at - 1, 1e-6)]);
    let shares = Shares::of(&Graph::new(&manifest(2000, &arcs.collect::<Vec<_>>()))).unwrap();
    assert!(shares.visits.iter().all(|share| share.is_finite()));
    assert!(shares.off_by().is_infinite());
    // A chance so small that it is 0.
    let pair = Graph::new(&manifest(2, &[(0, 0, 1e300), (0, 1, 1e-300), (1, 0, 1.0)]));
    let shares = Shares::of(&pair).unwrap();
    assert!(shares.visits.iter().all(|share| share.is_finite()) && shares.off_by().is_infinite());
}

proptest! {
    #[test]
    fn every_method_finds_the_same_and_the_proof_holds(
        n in 2usize..40,
        more in prop::collection::vec((0usize..40, 0usize..40, 0.1f64..5.0), 0..90),
        off in prop::collection::vec(-1e-3f64..1e-3, 40),
    ) {
        let mut flows = Flows::new(n);
        flows.cycle(&(0..n).collect::<Vec<_>>(), 1.0);
        for (a, b, flow) in more {
            // A way there and back along the ring.
            let (a, b) = (a % n, b % n);
            let back: Vec<usize> = if a <= b { (b..n).chain(0..=a).collect() } else { (b..=a).collect() };
            flows.cycle(&back, flow);
        }
        let (chain, truth) = (flows.chain(), flows.shares());
        let reduction = reduce::Reduction::of(&chain, reduce::Limits { ways: 9, work: usize::MAX });
        let mut swept = vec![1.0 / n as f64; n];
        sweep::settle(&chain, &mut swept);
        let mut parted = vec![1.0 / n as f64; n];
        parts::settle(&chain, &mut parted);
        sweep::settle(&chain, &mut parted);
        let ways = [dense::eliminated(&chain), reduction.put_back(&dense::eliminated(&reduction.core)), swept, parted];
        for mut found in ways {
            super::chain::normalise(&mut found);
            let bound = proof::off_by(&chain, &found);
            prop_assert!(worst(&found, &truth) <= bound.min(1e-9), "{} {bound}", worst(&found, &truth));
        }
        let wrong: Vec<f64> = truth.iter().zip(off).map(|(share, off)| share * (1.0 + off)).collect();
        let sum: f64 = wrong.iter().sum();
        let wrong: Vec<f64> = wrong.iter().map(|share| share / sum).collect();
        prop_assert!(worst(&wrong, &truth) <= proof::off_by(&chain, &wrong));
    }
}

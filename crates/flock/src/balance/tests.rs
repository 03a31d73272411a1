//! Balances that are known by hand, and what holds for every balance.
//!
//! Owns the claims on what a balance is. Never looks into the search: its parts have their own tests.
use super::{Balance, Terms};
use crate::flock::Flock;
use crate::graph::tests::manifest;
use crate::manifest::Manifest;
use crate::names::SheepId;

const FAIREST: Terms = Terms { fairness: f64::INFINITY, floor: 0.0, afresh: false };

fn wanted(n: usize, arcs: &[(usize, usize, f64)], wants: &[f64]) -> Manifest {
    let mut manifest = manifest(n, arcs);
    for (sheep, want) in manifest.sheep.iter_mut().zip(wants) {
        sheep.want = *want;
    }
    manifest
}

fn ids(sheep: &[&SheepId]) -> Vec<String> {
    sheep.iter().map(ToString::to_string).collect()
}

#[test]
fn a_pair_gets_its_wants_in_the_most_varied_way() {
    // Of all ways to visit `s0` three times in four the most varied takes every exit as often as its end is wanted.
    let arcs = [(0, 0, 1.0), (0, 1, 1.0), (1, 0, 1.0), (1, 1, 1.0)];
    let flock = Flock::new(wanted(2, &arcs, &[3.0, 1.0]));
    let balance = Balance::of(&flock, FAIREST).unwrap();
    assert!(balance.reachable && balance.deficiency == 0.0 && balance.bottleneck.is_none());
    for (weight, expected) in balance.weights.iter().zip([1.5, 0.5, 1.5, 0.5]) {
        assert!((weight.weight - expected).abs() < 1e-6, "{weight:?}");
    }
    assert!(balance.worst_ratio.unwrap() < 1.0 + 1e-6);
}

#[test]
fn the_leaves_of_a_star_get_stuck_at_its_hub() {
    // Every second visit is the hub's, whatever the weights.
    let star = [(0, 1, 1.0), (0, 2, 1.0), (0, 3, 1.0), (1, 0, 1.0), (2, 0, 1.0), (3, 0, 1.0)];
    let flock = Flock::new(wanted(4, &star, &[1.0, 1.0, 1.0, 3.0]));
    let balance = Balance::of(&flock, FAIREST).unwrap();
    assert!(!balance.reachable);
    assert!((balance.deficiency - 4.0 / 6.0).abs() < 1e-12, "{}", balance.deficiency);
    let stuck = balance.bottleneck.as_ref().unwrap();
    assert_eq!(
        (ids(&stuck.sheep), ids(&stuck.followers)),
        (vec!["s1".into(), "s2".into(), "s3".into()], vec!["s0".into()])
    );
    // The proportionally fairest: the other half in proportion to the wants.
    for (sheep, expected) in balance.sheep.iter().zip([0.5, 0.1, 0.1, 0.3]) {
        assert!((sheep.visits - expected).abs() < 1e-4 * expected, "{sheep:?}");
    }
}

#[test]
fn sheep_that_are_not_played_are_part_of_the_deficiency_and_its_proof() {
    let flock = Flock::new(manifest(4, &[(0, 1, 1.0), (1, 0, 1.0), (1, 2, 7.0), (2, 3, 1.0)]));
    let balance = Balance::of(&flock, Terms::default()).unwrap();
    assert!((balance.deficiency - 0.5).abs() < 1e-12);
    let stuck = balance.bottleneck.as_ref().unwrap();
    assert_eq!((ids(&stuck.sheep), ids(&stuck.followers)), (vec!["s2".into(), "s3".into()], vec![]));
    assert_eq!((balance.worst_ratio, balance.weights[2].weight), (None, 7.0));
}

#[test]
fn a_flock_without_a_cycle_has_no_balance() {
    assert!(Balance::of(&Flock::new(manifest(2, &[(0, 1, 1.0)])), Terms::default()).is_none());
}

#[test]
fn the_floor_is_held_by_the_weights_as_they_are_written() {
    // A ring with chords that the wants would silence.
    let ring = (0..9).map(|at| (at, (at + 1) % 9, 1.0));
    let arcs: Vec<_> = ring.chain((0..9).map(|at| (at, (at + 4) % 9, 1e-6))).collect();
    let flock = Flock::new(manifest(9, &arcs));
    for floor in [0.5, 12.0, 500.0, 20_000.0] {
        for fairness in [0.3, 3.0, f64::INFINITY] {
            let balance = Balance::of(&flock, Terms { fairness, floor, afresh: false }).unwrap();
            let least = balance.weights.iter().map(|weight| weight.visits).fold(1.0, f64::min) * 630_000.0;
            assert!(least >= floor && balance.least_plays >= floor, "{least} of {floor} at {fairness}");
        }
    }
}

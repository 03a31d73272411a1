//! Balances that are known by hand, and what holds for every balance.
//!
//! Owns the claims on what a balance is. Never looks into the search: its parts have their own tests.
use super::{Balance, Suggestions, Terms};
use crate::flock::{Flock, Measure};
use crate::graph::tests::manifest;
use crate::manifest::{Manifest, SheepId};

const FAIREST: Terms = Terms { fairness: f64::INFINITY, floor: 0.0, afresh: false, by: Measure::Visits };

fn wanted(n: usize, arcs: &[(usize, usize, f64)], wants: &[f64]) -> Manifest {
    let mut manifest = manifest(n, arcs);
    for (sheep, want) in manifest.sheep.iter_mut().zip(wants) {
        sheep.want = *want;
    }
    manifest
}

fn ids(sheep: &[SheepId]) -> Vec<String> {
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
            let balance = Balance::of(&flock, Terms { fairness, floor, ..Terms::default() }).unwrap();
            let least = balance.weights.iter().map(|weight| weight.visits).fold(1.0, f64::min) * 630_000.0;
            assert!(least >= floor && balance.least_plays >= floor, "{least} of {floor} at {fairness}");
        }
    }
}

/// The transitions that are suggested, as `s0>s1`, and the worst ratio after each.
fn told(suggestions: &[super::Suggestion]) -> Vec<(String, Option<f64>)> {
    suggestions.iter().map(|one| (format!("{}>{}", one.from, one.to), one.worst_ratio)).collect()
}

#[test]
fn the_way_past_a_hub_is_suggested() {
    // A leaf that is wanted as much as the hub, another one hardly.
    let star = [(0, 1, 1.0), (0, 2, 1.0), (1, 0, 1.0), (2, 0, 1.0)];
    let flock = Flock::new(wanted(3, &star, &[1.0, 1.0, 1.0]));
    let before = Balance::of(&flock, Terms::default()).unwrap().worst_ratio.unwrap();
    let suggestions = Suggestions::of(&flock, Terms::default(), 1).unwrap();
    let (way, worst) = told(&suggestions.add).remove(0);
    assert!(["s1>s2", "s2>s1"].contains(&way.as_str()), "{way}");
    assert!(worst.unwrap() < 0.9 * before, "{worst:?} {before}");
    assert!(suggestions.remove.is_empty(), "every transition is needed: {suggestions:?}");
}

#[test]
fn parts_that_are_not_played_are_joined_first_by_as_few_transitions_as_can_be() {
    // A pair that is played; a way out of it and a way into it, whose ends are joined by one; and a part by itself.
    let arcs = [(0, 1, 1.0), (1, 0, 1.0), (1, 2, 1.0), (2, 3, 1.0), (4, 5, 1.0), (5, 0, 1.0), (6, 6, 1.0)];
    let flock = Flock::new(manifest(7, &arcs));
    let suggestions = Suggestions::of(&flock, Terms::default(), 4).unwrap();
    let add = told(&suggestions.add);
    assert_eq!(add[0], ("s3>s4".to_owned(), None));
    assert!(add[1].0.ends_with(">s6") && add[1].1.is_none(), "{add:?}");
    assert!(add[2].0.starts_with("s6>") && add[2].1.is_some(), "{add:?}");
}

#[test]
fn what_is_perfect_gets_no_advice() {
    let ring: Vec<_> = (0..5).map(|at| (at, (at + 1) % 5, 1.0)).collect();
    let suggestions = Suggestions::of(&Flock::new(manifest(5, &ring)), Terms::default(), 3).unwrap();
    assert_eq!((suggestions.add.len(), suggestions.remove.len()), (0, 0));
}

const FAIREST_TIMES: Terms = Terms { by: Measure::Time, ..FAIREST };

#[test]
fn by_time_a_loop_that_is_shown_twice_needs_half_of_the_visits() {
    let arcs = [(0, 0, 1.0), (0, 1, 1.0), (1, 0, 1.0), (1, 1, 1.0)];
    let mut pair = manifest(2, &arcs);
    pair.sheep[0].repeat = 2;
    let flock = Flock::new(pair);
    let balance = Balance::of(&flock, FAIREST_TIMES).unwrap();
    assert!(balance.reachable && balance.worst_time_ratio.unwrap() < 1.0 + 1e-6, "{balance:?}");
    assert!((balance.worst_ratio.unwrap() - 1.5).abs() < 1e-5, "{balance:?}");
    for (sheep, visits) in balance.sheep.iter().zip([1.0 / 3.0, 2.0 / 3.0]) {
        assert!((sheep.visits - visits).abs() < 1e-6 && (sheep.time - 0.5).abs() < 1e-6, "{sheep:?}");
        assert!((sheep.wanted_visits - visits).abs() < 1e-12, "{sheep:?}");
    }
}

#[test]
fn by_time_a_hub_without_a_loop_is_in_nobodys_way() {
    // Every second visit is the hub's: by visits that is far too many, by time it does not matter.
    let star = [(0, 1, 5.0), (0, 2, 1.0), (0, 3, 1.0), (1, 0, 1.0), (2, 0, 1.0), (3, 0, 1.0)];
    let mut manifest = wanted(4, &star, &[1.0, 1.0, 2.0, 3.0]);
    manifest.sheep[0].clip = None;
    let flock = Flock::new(manifest);
    assert!(!Balance::of(&flock, FAIREST).unwrap().reachable);
    let balance = Balance::of(&flock, FAIREST_TIMES).unwrap();
    assert!(balance.reachable && balance.deficiency == 0.0, "{balance:?}");
    for (sheep, time) in balance.sheep.iter().zip([0.0, 1.0 / 6.0, 2.0 / 6.0, 3.0 / 6.0]) {
        assert!((sheep.time - time).abs() < 1e-6 && (sheep.time_want - time).abs() < 1e-12, "{sheep:?}");
    }
    let usual = Balance::of(&flock, Terms { by: Measure::Time, ..Terms::default() }).unwrap();
    let before = crate::flock::FlockShares::of(&flock).unwrap().worst_time_ratio.unwrap();
    assert!(usual.worst().unwrap() < 1.8 && before > 4.0, "{:?} {before}", usual.worst());
}

#[test]
fn by_time_wants_out_of_reach_are_proved_in_visits() {
    // The first has its loop shown four times at every visit: the second, to which it alone leads, is visited as often.
    let mut ring = manifest(3, &[(0, 1, 1.0), (1, 2, 1.0), (1, 0, 1.0), (2, 0, 1.0), (2, 1, 1.0)]);
    ring.sheep[1].repeat = 4;
    let flock = Flock::new(ring);
    let balance = Balance::of(&flock, FAIREST_TIMES).unwrap();
    let stuck = balance.bottleneck.as_ref().unwrap();
    assert_eq!((ids(&stuck.sheep), ids(&stuck.followers)), (vec!["s0".into()], vec!["s1".into()]));
    // Of nine visits the first and the last should have four each, the second one.
    assert!((balance.deficiency - 3.0 / 9.0).abs() < 1e-12, "{}", balance.deficiency);
}

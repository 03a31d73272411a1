//! The claims of the walk on a short run: two and a half weeks of 50-second steps; those of its shares on some more.
//! `make soak` walks the year, and 16 years for each of 100 flocks.

#[path = "../../examples/agreement/claims.rs"]
mod agreement;
#[path = "../../examples/year/claims.rs"]
mod claims;

use agreement::Errors;
use claims::Weights;
use flock::Flock;

const STEPS: usize = 30_000;
const RESTARTS: usize = 200;

#[test]
fn the_steered_walk_is_even_spaced_and_never_the_same() {
    for (seed, weights) in [(11, Weights::Equal), (12, Weights::Mixed)] {
        let flock = claims::flock(seed, weights);
        let figures = claims::figures(&flock, &claims::steered(&flock, seed, STEPS, 0));
        assert_eq!(claims::broken(&figures), Vec::<String>::new(), "flock {seed}");
    }
}

#[test]
fn a_memoryless_walk_on_the_same_flock_is_neither_even_nor_spaced() {
    let flock = claims::flock(11, Weights::Equal);
    let steered = claims::figures(&flock, &claims::steered(&flock, 11, STEPS, 0));
    let figures = claims::figures(&flock, &claims::memoryless(&flock, 11, STEPS));
    assert!(claims::broken(&figures).len() >= 2, "{:?}", claims::broken(&figures));
    assert!(figures.most_off > 4.0 * steered.most_off, "{} {}", figures.most_off, steered.most_off);
    assert!(claims::earliest(&figures) < 0.08, "{}", claims::earliest(&figures));
}

#[test]
fn restarts_leave_the_walk_as_it_is() {
    let flock = claims::flock(13, Weights::Mixed);
    assert_eq!(claims::steered(&flock, 13, STEPS, RESTARTS), claims::steered(&flock, 13, STEPS, 0));
}

#[test]
fn shares_agree_with_walks_that_do_not_know_them() {
    const STEPS: u64 = 500_000;
    let mut errors = Errors::default();
    for seed in 0..agreement::FLOCKS {
        let flock = agreement::flock(seed);
        let tally = agreement::memoryless(&flock, seed, STEPS);
        errors.add(&flock, &tally, &agreement::memoryless_bounds(&flock, STEPS));
    }
    assert_eq!(errors.broken(agreement::MEMORYLESS), Vec::<String>::new());
}

#[test]
fn shares_agree_with_the_units_own_walk_to_a_few_visits() {
    const STEPS: u64 = 1_000_000;
    let (mut errors, mut drifting) = (Errors::default(), Errors::default());
    // The tenth nearly falls apart: two of its sheep have but a few visits in so many steps.
    for seed in (0..agreement::FLOCKS).step_by(9).chain([10]) {
        let flock = agreement::flock(seed);
        let tally = agreement::steered(&flock, seed, STEPS);
        let bounds = agreement::steered_bounds(&flock, &tally);
        errors.add(&flock, &tally, &bounds);
        // Shares of slightly other weights are not those of this walk: the bounds are narrow enough to tell.
        let mut other = flock.manifest().clone();
        other.transitions.iter_mut().step_by(5).for_each(|transition| transition.weight *= 1.1);
        drifting.add(&Flock::new(other), &tally, &bounds);
    }
    assert_eq!(errors.broken(agreement::STEERED), Vec::<String>::new());
    assert!(drifting.outside >= 10 && drifting.worst() > 3.0, "{drifting:?}");
}

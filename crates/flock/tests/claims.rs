//! The claims of the walk on a short run: two and a half weeks of 50-second steps. `make soak` walks the year.

#[path = "../examples/year/claims.rs"]
mod claims;

use claims::Weights;

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

//! What the rules make of a pool whose voters have a hidden taste: the product's own rules, in 16 worlds.

use std::sync::LazyLock;

use crate::simulation::{Outcome, Rules, Trial};

const WORLDS: u64 = 16;

fn run(rules: Rules, showings: u64) -> Outcome {
    Trial { rules, showings }.run(WORLDS)
}

/// Ours with many votes, which two claims look at.
static OURS: LazyLock<Outcome> = LazyLock::new(|| run(Rules::Ours, 30));

#[test]
fn simulated_voters_with_a_hidden_taste_get_what_they_like() {
    for (ours, [ten, twenty], showings) in [(&*OURS, [0.85, 0.93], 30), (&run(Rules::Ours, 10), [0.78, 0.87], 10)] {
        let theirs = run(Rules::Electric, showings);
        let [after_ten, after_twenty, after_forty] = ours.percentiles;
        assert!(after_ten >= ten && after_twenty >= twenty, "{showings} showings: {ours:?}");
        // Electric Sheep's rule beside it, in the same worlds.
        let is_more = [0, 1].iter().all(|at| ours.percentiles[*at] > theirs.percentiles[*at]);
        assert!(is_more && ours.worst > theirs.worst, "{showings} showings: {ours:?}, Electric Sheep's {theirs:?}");
        assert!(after_forty > after_twenty, "{ours:?}");
    }
    assert!(OURS.worst >= 0.85, "{:?}", *OURS);
}

#[test]
fn voters_without_a_taste_change_nothing() {
    let chance = run(Rules::Chance, 30);
    assert!((0.42..=0.58).contains(&chance.percentiles[1]), "{chance:?}");
}

#[test]
fn the_pool_stays_wide_while_it_improves() {
    assert!(OURS.diversity >= 0.6 && OURS.families >= 8.0, "{:?}", *OURS);
}

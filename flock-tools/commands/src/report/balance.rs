//! The shares of a flock with balanced weights, for comparison with those as written.
//!
//! Owns this part of the page's document. The flock crate finds the weights, and the bottleneck if no weights reach the
//! wants.
//!
//! Start at [`BalancedShares::of`].

use flock::{Balance, Flock, FlockShares, SheepId, SheepShare, Terms};

use crate::balance::write::with_weights;

/// The shares with the weights that `dreams balance` finds with its default terms, but for the measure.
#[derive(Debug, serde::Serialize)]
pub(super) struct BalancedShares {
    /// The worst of share/want and want/share; `None` if a sheep is never shown.
    pub(super) worst_ratio: Option<f64>,
    /// Of every sheep: its share, its mean return in minutes, its minutes a day.
    sheep: Vec<(f64, Option<f64>, f64)>,
    /// Of every transition, in the page's order: the fraction of all steps that take it.
    transitions: Vec<f64>,
    bottleneck: Option<BottleneckFacts>,
}

/// Why no weights reach the wants: the sheep of one set are wanted more than all sheep that they lead to.
#[derive(Debug, serde::Serialize)]
pub(super) struct BottleneckFacts {
    /// The number of those of the sheep that are shown, and the part of all visits that is wanted of them.
    sheep: usize,
    want: f64,
    /// The number of sheep that they lead to, and the part that is wanted of these.
    followers: usize,
    followers_want: f64,
}

impl BalancedShares {
    /// The balance of `flock`. `None` if it has no cycle to walk.
    pub(super) fn of(flock: &Flock, terms: Terms) -> Option<Self> {
        let balance = Balance::of(flock, terms)?;
        let balanced = with_weights(flock, &balance);
        let shares = FlockShares::of(&balanced)?;
        let share = |one: &SheepShare| one.share_and_want(terms.by).0;
        let sheep = shares.sheep.iter().map(|one| (share(one), one.return_minutes, one.minutes_a_day));
        Some(Self {
            worst_ratio: shares.worst(terms.by),
            sheep: sheep.collect(),
            transitions: shares.transitions.iter().map(|one| one.visits).collect(),
            bottleneck: bottleneck(&balance),
        })
    }
}

/// The bottleneck that `balance` names.
pub(super) fn bottleneck(balance: &Balance) -> Option<BottleneckFacts> {
    let bottleneck = balance.bottleneck.as_ref()?;
    let place = |id: &SheepId| balance.sheep.binary_search_by(|sheep| sheep.id.cmp(id)).ok();
    let places = |ids: &[SheepId]| ids.iter().filter_map(place).collect::<Vec<usize>>();
    let want = |places: &[usize]| places.iter().map(|&at| balance.sheep[at].wanted_visits).sum::<f64>();
    let (mut sheep, followers) = (places(&bottleneck.sheep), places(&bottleneck.followers));
    sheep.retain(|&at| balance.sheep[at].visits > 0.0);
    Some(BottleneckFacts {
        sheep: sheep.len(),
        want: want(&sheep),
        followers: followers.len(),
        followers_want: want(&followers),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use flock::Manifest;
    use std::path::Path;

    fn flock(transitions: &[(&str, &str, f64)]) -> Flock {
        let mut text = "format = 1\nname = \"x\"\nsize = [64, 64]\nfps = [30, 1]\n".to_owned();
        for id in ["a", "b", "c"] {
            text = format!("{text}[[sheep]]\nid = \"{id}\"\nframes = 300\nclip = \"{id}.mp4\"\n");
        }
        for (from, to, weight) in transitions {
            let clip = format!("frames = 300\nclip = \"{from}{to}.mp4\"\nweight = {weight:?}");
            text = format!("{text}[[transition]]\nfrom = \"{from}\"\nto = \"{to}\"\n{clip}\n");
        }
        Flock::new(Manifest::parse(&text, Path::new("flock.toml")).unwrap())
    }

    #[test]
    fn a_flock_that_can_be_balanced_comes_nearer_to_its_wants_and_nothing_is_stuck() {
        let all =
            [("a", "b", 9.0), ("b", "c", 1.0), ("c", "a", 1.0), ("a", "c", 1.0), ("b", "a", 9.0), ("c", "b", 1.0)];
        let flock = flock(&all);
        let written = FlockShares::of(&flock).unwrap().worst_ratio.unwrap();
        let balanced = BalancedShares::of(&flock, Terms::default()).unwrap();
        assert!(balanced.worst_ratio.unwrap() < 1.0 + 0.7 * (written - 1.0), "{written} {balanced:?}");
        assert!(balanced.bottleneck.is_none(), "{balanced:?}");
        assert!((balanced.transitions.iter().sum::<f64>() - 1.0).abs() < 1e-9);
    }

    #[test]
    fn what_is_stuck_is_wanted_more_than_all_that_it_leads_to() {
        // All sheep lead to `a` alone, or `a` leads to them.
        let flock = flock(&[("a", "b", 1.0), ("a", "c", 1.0), ("b", "a", 1.0), ("c", "a", 1.0)]);
        let bottleneck = BalancedShares::of(&flock, Terms::default()).unwrap().bottleneck.unwrap();
        assert!(bottleneck.want > bottleneck.followers_want + 0.3, "{bottleneck:?}");
        assert_eq!((bottleneck.sheep, bottleneck.followers), (2, 1));
    }
}

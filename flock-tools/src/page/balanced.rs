//! What a flock would show with balanced weights, beside what it shows as written.
//!
//! Owns the comparison's form. The weights and the proof where wants cannot be reached are the flock crate's.
//!
//! Start at [`SheepBalance::of`].

use flock::{Balance, Flock, FlockShares, SheepId, Terms};

use crate::balance::write::written;

/// The flock under the weights that `flock balance` finds with its default terms.
#[derive(Debug, serde::Serialize)]
pub(super) struct SheepBalance {
    /// The worst of visits/want and want/visits; `None` if a sheep is never shown.
    pub(super) worst_ratio: Option<f64>,
    /// Of every sheep: its fraction of all visits, its mean return in minutes, how long it is lit a day in minutes.
    sheep: Vec<(f64, Option<f64>, f64)>,
    /// Of every transition, in the page's order: the fraction of all steps that take it.
    transitions: Vec<f64>,
    stuck: Option<Stuck>,
}

/// Why no weights reach the wants: the sheep of one set are wanted more than all sheep that they lead to.
#[derive(Debug, serde::Serialize)]
struct Stuck {
    /// The sheep, by their places on the page, and what they are wanted together.
    sheep: Vec<usize>,
    want: f64,
    /// How many they lead to, and what those are wanted together.
    followers: usize,
    followers_want: f64,
}

impl SheepBalance {
    /// The balance of `flock`. `None` if it has no cycle to walk.
    pub(super) fn of(flock: &Flock) -> Option<Self> {
        let balance = Balance::of(flock, Terms::default())?;
        let balanced = written(flock, &balance);
        let shares = FlockShares::of(&balanced)?;
        let sheep = shares.sheep.iter().map(|one| (one.visits, one.return_minutes, one.minutes_a_day));
        Some(Self {
            worst_ratio: shares.worst_ratio,
            sheep: sheep.collect(),
            transitions: shares.transitions.iter().map(|one| one.visits).collect(),
            stuck: stuck(&balance),
        })
    }
}

fn stuck(balance: &Balance<'_>) -> Option<Stuck> {
    let bottleneck = balance.bottleneck.as_ref()?;
    let place = |id: &&SheepId| balance.sheep.binary_search_by(|sheep| sheep.id.cmp(id)).ok();
    let places = |ids: &[&SheepId]| ids.iter().filter_map(place).collect::<Vec<usize>>();
    let want = |places: &[usize]| places.iter().map(|&at| balance.sheep[at].want).sum::<f64>();
    let (sheep, followers) = (places(&bottleneck.sheep), places(&bottleneck.followers));
    Some(Stuck { want: want(&sheep), followers: followers.len(), followers_want: want(&followers), sheep })
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
        let balanced = SheepBalance::of(&flock).unwrap();
        assert!(balanced.worst_ratio.unwrap() < 1.0 + 0.7 * (written - 1.0), "{written} {balanced:?}");
        assert!(balanced.stuck.is_none(), "{balanced:?}");
        assert!((balanced.transitions.iter().sum::<f64>() - 1.0).abs() < 1e-9);
    }

    #[test]
    fn what_is_stuck_is_wanted_more_than_all_that_it_leads_to() {
        // Everyone leads to `a` alone, or comes from it.
        let flock = flock(&[("a", "b", 1.0), ("a", "c", 1.0), ("b", "a", 1.0), ("c", "a", 1.0)]);
        let stuck = SheepBalance::of(&flock).unwrap().stuck.unwrap();
        assert!(stuck.want > stuck.followers_want + 0.3, "{stuck:?}");
        assert_eq!((stuck.sheep, stuck.followers), (vec![1, 2], 1));
    }
}

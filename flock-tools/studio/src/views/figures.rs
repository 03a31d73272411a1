//! The figures of a flock as the page shows them: shares against wants, how often transitions are taken, what is shown.
//!
//! Owns their form, and the comparison of a flock with what it would be after some edits. The flock crate computes. Never
//! edits.
//!
//! Start at [`Figures::of`], or at [`WhatIf::of`].

use std::collections::BTreeSet;

use flock::{Flock, FlockShares, Manifest, Measure, SheepId, SheepShare, TransitionShare};

/// The figures of a whole flock.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub(crate) struct Figures {
    /// How many sheep, transitions, and sheep that the walk shows.
    pub(crate) sheep: usize,
    pub(crate) transitions: usize,
    pub(crate) shown: usize,
    /// The worst of share/want and want/share; `null` while a sheep is never shown.
    pub(crate) worst_ratio: Option<f64>,
    /// The entropy of the visits.
    pub(crate) entropy_bits: f64,
    /// The mean time from the start of a visit to the start of the next.
    pub(crate) step_minutes: f64,
}

/// The figures of one sheep.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub(crate) struct SheepFigures {
    pub(crate) id: SheepId,
    /// Its part of all visits, or of the time; 0 if it is not shown.
    pub(crate) share: f64,
    /// The part that is wanted.
    pub(crate) wanted: f64,
    /// share/wanted; `null` where nothing is wanted.
    pub(crate) ratio: Option<f64>,
}

/// How often a transition is taken: its part of all steps.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub(crate) struct TransitionFigures {
    pub(crate) from: SheepId,
    pub(crate) to: SheepId,
    pub(crate) visits: f64,
}

/// What a flock would be after some edits.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub(crate) struct WhatIf {
    pub(crate) figures: Figures,
    pub(crate) sheep: Vec<SheepFigures>,
    pub(crate) transitions: Vec<TransitionFigures>,
    /// Frames of the clips that the flock would have more.
    pub(crate) frames: u64,
    /// Processor time to render them, in seconds; `null` if nothing is known of it.
    pub(crate) cost_s: Option<f64>,
    pub(crate) no_longer_shown: Vec<SheepId>,
}

impl Figures {
    /// Those of `flock`, whose shares are `shares`; `by` is what wants are compared with.
    pub(crate) fn of(flock: &Flock, shares: Option<&FlockShares<'_>>, by: Measure) -> Self {
        let manifest = flock.manifest();
        let counted = Self {
            sheep: manifest.sheep.len(),
            transitions: manifest.transitions.len(),
            shown: if flock.is_walkable() { flock.graph().len() } else { 0 },
            ..Self::default()
        };
        let Some(shares) = shares.filter(|_| flock.is_walkable()) else { return counted };
        Self {
            worst_ratio: shares.worst(by),
            entropy_bits: shares.entropy_bits,
            step_minutes: shares.step_minutes,
            ..counted
        }
    }

    /// The same, with the shares computed.
    pub(crate) fn of_flock(flock: &Flock, by: Measure) -> Self {
        Self::of(flock, FlockShares::of(flock).as_ref(), by)
    }
}

impl WhatIf {
    /// The flock `after` the edits of the flock `before`, without the cost.
    pub(crate) fn of(before: &Flock, after: &Flock, by: Measure) -> Self {
        let shares = FlockShares::of(after);
        let (sheep, transitions) = shares
            .as_ref()
            .map_or_else(Default::default, |shares| (sheep_figures(shares, by), transition_figures(shares)));
        Self {
            figures: Figures::of(after, shares.as_ref(), by),
            sheep,
            transitions,
            frames: new_frames(before.manifest(), after.manifest()),
            cost_s: None,
            no_longer_shown: no_longer_shown(before, after),
        }
    }
}

/// The figures of every sheep, in the order of their ids.
pub(crate) fn sheep_figures(shares: &FlockShares<'_>, by: Measure) -> Vec<SheepFigures> {
    let of = |sheep: &SheepShare<'_>| {
        let (share, wanted) = sheep.share_and_want(by);
        SheepFigures { id: sheep.id.clone(), share, wanted, ratio: (wanted > 0.0).then(|| share / wanted) }
    };
    shares.sheep.iter().map(of).collect()
}

/// How often every transition is taken, in the order of (from, to).
fn transition_figures(shares: &FlockShares<'_>) -> Vec<TransitionFigures> {
    let of = |own: &TransitionShare<'_>| TransitionFigures {
        from: own.from.clone(),
        to: own.to.clone(),
        visits: own.visits,
    };
    shares.transitions.iter().map(of).collect()
}

/// The sheep that the walk shows.
pub(crate) fn shown(flock: &Flock) -> BTreeSet<&SheepId> {
    flock.graph().sheep().filter(|_| flock.is_walkable()).map(|sheep| flock.id(sheep)).collect()
}

/// The sheep that the walk shows `before` and not `after`, although the flock still has them.
pub(crate) fn no_longer_shown(before: &Flock, after: &Flock) -> Vec<SheepId> {
    let there: BTreeSet<&SheepId> = after.manifest().sheep.iter().map(|sheep| &sheep.id).collect();
    let (before, after) = (shown(before), shown(after));
    before.difference(&after).filter(|id| there.contains(**id)).map(|id| (*id).clone()).collect()
}

/// Frames of the clips that `after` names and `before` does not.
fn new_frames(before: &Manifest, after: &Manifest) -> u64 {
    let known: BTreeSet<_> = before.clips().map(|clip| clip.path.as_str()).collect();
    let new = after.clips().filter(|clip| !known.contains(clip.path.as_str()));
    new.map(|clip| u64::from(clip.frames.0)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fmt::Write;
    use std::path::Path;

    /// Sheep a, b, c, each linked to the next, and the transitions `more`.
    fn flock(more: &str) -> Flock {
        let mut text = "format = 1\nname = \"x\"\nsize = [64, 64]\nfps = [30, 1]\n".to_owned();
        for id in ["a", "b", "c"] {
            write!(text, "[[sheep]]\nid = \"{id}\"\nframes = 60\nclip = \"{id}.mp4\"\n").unwrap();
        }
        let pairs = format!("ab bc ca {more}");
        for pair in pairs.split_whitespace() {
            let (from, to) = pair.split_at(1);
            write!(text, "[[transition]]\nfrom = \"{from}\"\nto = \"{to}\"\nframes = 90\nclip = \"{from}{to}.mp4\"\n")
                .unwrap();
        }
        Flock::new(Manifest::parse(&text, Path::new("flock.toml")).unwrap())
    }

    #[test]
    fn a_what_if_tells_the_shares_and_the_frames_that_a_link_would_bring() {
        let told = WhatIf::of(&flock(""), &flock("ba"), Measure::Visits);
        assert_eq!((told.frames, told.figures.transitions, told.figures.shown), (90, 4, 3));
        // From b one step in two goes back to a: a and b are visited twice as often as c.
        let shares: Vec<f64> = told.sheep.iter().map(|sheep| sheep.share).collect();
        assert!(shares.iter().zip([0.4, 0.4, 0.2]).all(|(is, wanted)| (is - wanted).abs() < 1e-12), "{shares:?}");
        assert!((told.figures.worst_ratio.unwrap() - 5.0 / 3.0).abs() < 1e-12);
        assert!((told.transitions.iter().map(|own| own.visits).sum::<f64>() - 1.0).abs() < 1e-12);
        assert_eq!(told.no_longer_shown, []);
    }

    #[test]
    fn a_what_if_names_the_sheep_that_would_leave_the_walk_and_not_those_that_leave_the_flock() {
        let mut smaller = flock("ba").manifest().clone();
        smaller.transitions.retain(|own| own.from.as_str() != "c");
        let told = WhatIf::of(&flock("ba"), &Flock::new(smaller.clone()), Measure::Visits);
        assert_eq!(told.no_longer_shown, [SheepId::new("c").unwrap()]);
        smaller.sheep.retain(|sheep| sheep.id.as_str() != "c");
        smaller.transitions.retain(|own| own.to.as_str() != "c");
        assert_eq!(WhatIf::of(&flock("ba"), &Flock::new(smaller), Measure::Visits).no_longer_shown, []);
    }

    #[test]
    fn a_flock_without_a_cycle_shows_nothing_and_has_no_worst_ratio() {
        let mut open = flock("").manifest().clone();
        open.transitions.retain(|own| own.from.as_str() != "c");
        let figures = Figures::of_flock(&Flock::new(open), Measure::Visits);
        assert_eq!((figures.sheep, figures.shown, figures.worst_ratio), (3, 0, None));
    }
}

//! Long-run figures of each sheep in a walk, compared with the artist's wants.
//!
//! Owns the figures of `dreams share`: visits, screen time, wants, return times, the worst ratio. The shares are
//! computed in `shares/`.
//!
//! Start at [`FlockShares::of`].

use std::fmt;

use super::Flock;
use crate::manifest::{Sheep, SheepId};

/// Seconds in a minute.
const MINUTE_S: f64 = 60.0;
/// Minutes in a day.
const DAY_MINUTES: f64 = 1440.0;

/// The measure in which sheep get what they are wanted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Measure {
    /// How often a sheep is visited.
    #[default]
    Visits,
    /// How long a sheep's loop is shown, repeats included. A sheep without a loop has no time, and its want means nothing.
    Time,
}

/// The long-run figures of a flock: the answer of `dreams share`.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct FlockShares<'f> {
    /// Every sheep of the manifest, in the order of their ids.
    pub sheep: Vec<SheepShare<'f>>,
    /// Every transition of the manifest, in the order of (from, to).
    pub transitions: Vec<TransitionShare<'f>>,
    /// The worst of visits/want and want/visits; `None` if a sheep is never visited.
    pub worst_ratio: Option<f64>,
    /// The worst of `time/time_want` and `time_want/time` of all sheep with a loop; `None` if one of them is never shown.
    pub worst_time_ratio: Option<f64>,
    /// The entropy of the visits, in bits: that of `2^entropy` equally frequent sheep.
    pub entropy_bits: f64,
    /// The mean time from one visit's start to the next one's, any sheep's, in minutes.
    pub step_minutes: f64,
    /// The proved bound on the relative error of any sheep's visits; `None` if nothing could be proved. Above
    /// [`Shares::PROVED`](crate::shares::Shares::PROVED) the figures are only an estimate.
    pub off_by: Option<f64>,
}

/// One sheep's part of a walk.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct SheepShare<'f> {
    /// Which.
    pub id: &'f SheepId,
    /// The fraction of all visits; 0 if it is not played. Those of all sheep sum to 1.
    pub visits: f64,
    /// The fraction of the time in which loops are lit that its own loop is; repeats count. 0 without a loop. Those of
    /// all sheep sum to 1, unless no sheep that is played has a loop.
    pub time: f64,
    /// The fraction of visits that the artist wishes. Those of all sheep sum to 1.
    pub want: f64,
    /// The same of `time`: the part of the wants of all sheep with a loop. 0 without a loop.
    pub time_want: f64,
    /// The mean time from the start of one visit to the start of its next, in minutes; `None` if it never comes back.
    pub return_minutes: Option<f64>,
    /// How long its loop is lit in a day of playing, in minutes.
    pub minutes_a_day: f64,
}

/// One transition's part of a walk.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct TransitionShare<'f> {
    /// Where it starts.
    pub from: &'f SheepId,
    /// Where it ends.
    pub to: &'f SheepId,
    /// The fraction of all steps that take it; 0 if it is not played. Those of all transitions sum to 1.
    pub visits: f64,
}

impl<'f> FlockShares<'f> {
    /// Computes the figures of `flock`. `None` if it has neither a cycle nor a loop.
    pub fn of(flock: &'f Flock) -> Option<Self> {
        let (graph, shares) = (flock.graph(), flock.shares()?);
        let of_sheep = |sheep| shares.visits(sheep) * flock.visit_seconds(sheep);
        let loops_s: f64 = graph.sheep().map(of_sheep).sum();
        let exits = graph.sheep().flat_map(|sheep| graph.exits(sheep));
        let transitions_s: f64 =
            exits.map(|exit| shares.taken(exit) * flock.seconds(&flock.transition(exit).clip)).sum();
        let step_s = loops_s + transitions_s;
        let wants = parts(&written(flock, |at| flock.manifest().sheep[at].want));
        let time_wants = parts(&written(flock, |at| time_want(&flock.manifest().sheep[at])));
        let sheep: Vec<SheepShare<'f>> = (flock.whole().sheep().zip(wants.into_iter().zip(time_wants)))
            .map(|(sheep, (want, time_want))| {
                let id = flock.whole().id(sheep);
                let played = graph.find(id);
                let visits = played.map_or(0.0, |sheep| shares.visits(sheep));
                let lit_s = played.map_or(0.0, of_sheep);
                let time = if lit_s > 0.0 { lit_s / loops_s } else { 0.0 };
                let return_minutes = Some(step_s / visits / MINUTE_S).filter(|minutes| minutes.is_finite());
                let minutes_a_day = if lit_s > 0.0 { DAY_MINUTES * (lit_s / step_s) } else { 0.0 };
                SheepShare { id, visits, time, want, time_want, return_minutes, minutes_a_day }
            })
            .collect();
        let worst = |measure| sheep.iter().map(|sheep: &SheepShare| sheep.off(measure)).fold(1.0, f64::max);
        let [visits, time] =
            [Measure::Visits, Measure::Time].map(worst).map(|worst| Some(worst).filter(|w| w.is_finite()));
        Some(Self {
            worst_ratio: visits,
            worst_time_ratio: time,
            entropy_bits: shares.entropy_bits(),
            step_minutes: step_s / MINUTE_S,
            off_by: Some(shares.off_by()).filter(|part| part.is_finite()),
            transitions: transitions(flock),
            sheep,
        })
    }

    /// The worst ratio in `measure`.
    pub fn worst(&self, measure: Measure) -> Option<f64> {
        measure.of(self.worst_ratio, self.worst_time_ratio)
    }
}

impl SheepShare<'_> {
    /// Its share and its want in `measure`.
    pub fn share_and_want(&self, measure: Measure) -> (f64, f64) {
        measure.of((self.visits, self.want), (self.time, self.time_want))
    }

    /// How far its share is from its want: the larger of share/want and want/share, at least 1, infinite if it is never
    /// shown; 1 if it has no time to want.
    pub fn off(&self, measure: Measure) -> f64 {
        let (share, want) = self.share_and_want(measure);
        measure.off(share, want)
    }
}

impl fmt::Display for Measure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Visits => "visits",
            Self::Time => "time",
        })
    }
}

impl Measure {
    /// `visits` or `time`: the figure that is of this measure.
    pub(crate) fn of<T>(self, visits: T, time: T) -> T {
        match self {
            Self::Visits => visits,
            Self::Time => time,
        }
    }

    /// How far `share` is from `want`, as [`SheepShare::off`].
    pub(crate) fn off(self, share: f64, want: f64) -> f64 {
        if self == Self::Time && want == 0.0 { 1.0 } else { (share / want).max(want / share) }
    }
}

/// What is wanted of the time of `sheep`, relative to the others; 0 without a loop.
pub(crate) fn time_want(sheep: &Sheep) -> f64 {
    if sheep.clip.is_some() { sheep.want } else { 0.0 }
}

/// A figure of every sheep, in the order of their ids.
fn written(flock: &Flock, figure: impl Fn(usize) -> f64) -> Vec<f64> {
    let whole = flock.whole();
    whole.sheep().map(|sheep| figure(whole.sheep_in_manifest(sheep))).collect()
}

/// The `figures`, 0 or more, as parts of their sum, which may be infinite.
fn parts(figures: &[f64]) -> Vec<f64> {
    let most = figures.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let total: f64 = figures.iter().map(|figure| figure / most).sum();
    figures.iter().map(|figure| if *figure > 0.0 { figure / most / total } else { 0.0 }).collect()
}

fn transitions(flock: &Flock) -> Vec<TransitionShare<'_>> {
    let (whole, graph) = (flock.whole(), flock.graph());
    // If all is played, both graphs are the same.
    let is_played_in_part = graph.len() < whole.len();
    let in_part = whole.sheep().filter(|_| is_played_in_part);
    let played: Vec<_> = in_part.map(|sheep| graph.find(whole.id(sheep))).collect();
    let mut all = Vec::with_capacity(whole.exit_count());
    for from in whole.sheep() {
        for exit in whole.exits(from) {
            let to = whole.target(exit);
            let own = if is_played_in_part {
                played[from.index()].zip(played[to.index()]).and_then(|(from, to)| graph.between(from, to))
            } else {
                Some(exit)
            };
            let visits = own.zip(flock.shares()).map_or(0.0, |(exit, shares)| shares.taken(exit));
            all.push(TransitionShare { from: whole.id(from), to: whole.id(to), visits });
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::tests::manifest;

    #[test]
    fn visits_time_and_returns_of_a_pair_are_known_by_hand() {
        // Three of four steps from `s0` stay: it has 4/5 of the visits. Its loop is lit twice, the other's once.
        let mut pair = manifest(2, &[(0, 0, 3.0), (0, 1, 1.0), (1, 0, 1.0)]);
        pair.sheep[0].repeat = 2;
        pair.sheep[1].want = 3.0;
        let flock = Flock::new(pair);
        let told = FlockShares::of(&flock).unwrap();
        let [a, b] = &told.sheep[..] else { panic!("two sheep") };
        assert_eq!((a.visits, a.want, b.visits, b.want), (0.8, 0.25, 0.2, 0.75));
        // Every clip is 25 s: a step lights 0.8 * 50 + 0.2 * 25 s of loops and 25 s of a transition.
        assert!((told.step_minutes - 70.0 / 60.0).abs() < 1e-12);
        assert!((a.time - 40.0 / 45.0).abs() < 1e-12 && (b.time - 5.0 / 45.0).abs() < 1e-12);
        assert!((b.return_minutes.unwrap() - 350.0 / 60.0).abs() < 1e-12);
        assert!((a.minutes_a_day - 1440.0 * 40.0 / 70.0).abs() < 1e-9);
        assert_eq!(told.worst_ratio, Some(0.75 / 0.2));
        assert!((told.worst_time_ratio.unwrap() - 0.75 * 45.0 / 5.0).abs() < 1e-12);
        let taken: Vec<_> = told.transitions.iter().map(|t| (t.from.as_str(), t.to.as_str(), t.visits)).collect();
        assert_eq!(taken, [("s0", "s0", 0.8 * 0.75), ("s0", "s1", 0.8 * 0.25), ("s1", "s0", 0.2)]);
    }

    #[test]
    fn what_is_not_played_has_no_share_and_never_returns() {
        let flock = Flock::new(manifest(3, &[(0, 1, 1.0), (1, 0, 1.0), (1, 2, 1.0)]));
        let told = FlockShares::of(&flock).unwrap();
        assert_eq!((told.sheep[2].visits, told.sheep[2].time, told.sheep[2].return_minutes), (0.0, 0.0, None));
        assert_eq!((told.worst_ratio, told.worst_time_ratio, told.transitions[2].visits), (None, None, 0.0));
        assert!((told.entropy_bits - 1.0).abs() < 1e-15);
    }

    #[test]
    fn a_keyframe_without_a_loop_has_visits_and_no_time() {
        let mut ring = manifest(2, &[(0, 1, 1.0), (1, 0, 1.0)]);
        ring.sheep[0].clip = None;
        let flock = Flock::new(ring.clone());
        let told = FlockShares::of(&flock).unwrap();
        assert_eq!((told.sheep[0].visits, told.sheep[0].time, told.sheep[1].time), (0.5, 0.0, 1.0));
        // All the time that is wanted is the other's.
        assert_eq!((told.sheep[0].time_want, told.sheep[1].time_want, told.worst_time_ratio), (0.0, 1.0, Some(1.0)));
        ring.sheep[1].clip = None;
        let bare = Flock::new(ring);
        assert!(FlockShares::of(&bare).unwrap().sheep.iter().all(|sheep| sheep.time == 0.0));
    }

    #[test]
    fn one_loop_without_transitions_has_everything() {
        let flock = Flock::new(manifest(1, &[]));
        let told = FlockShares::of(&flock).unwrap();
        assert_eq!((told.sheep[0].visits, told.sheep[0].time, told.worst_ratio), (1.0, 1.0, Some(1.0)));
        let mut nothing = manifest(1, &[]);
        nothing.sheep[0].clip = None;
        assert_eq!(FlockShares::of(&Flock::new(nothing)), None);
    }

    #[test]
    fn wants_may_be_as_large_and_as_small_as_numbers_get() {
        let mut pair = manifest(2, &[(0, 1, 1.0), (1, 0, 1.0)]);
        (pair.sheep[0].want, pair.sheep[1].want) = (1.7e308, 1.7e308);
        assert_eq!(FlockShares::of(&Flock::new(pair)).unwrap().worst_ratio, Some(1.0));
    }
}

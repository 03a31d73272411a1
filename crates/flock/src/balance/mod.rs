//! Weights that give every sheep its wanted share, or as near as the transitions allow.
//!
//! Owns the result of `dreams balance`: whether the wants can be reached, the bottleneck if not, the weights, and the
//! resulting shares. The tools write the manifest.
//!
//! Start at [`Balance::of`]; fairness and floor are defined in `terms.rs`, the method is in `circulation.rs`, the proof
//! in `reach.rs`. Improvements are found by [`Suggestions`].

mod bypass;
mod circulation;
mod exact;
mod join;
mod network;
mod reach;
mod sketch;
mod solve;
mod suggest;
mod system;
mod terms;
#[cfg(test)]
mod tests;
mod wants;
mod weights;

use crate::flock::{Flock, Measure};
use crate::graph::{Exit, Graph, SheepIx};
use crate::manifest::SheepId;

use circulation::Circulation;
use network::Network;
use reach::Reach;
pub use suggest::{Suggestion, Suggestions};
use terms::Solution;
pub use terms::Terms;
use wants::{Wants, visit_frames};
use weights::{RoundedWeights, may_be_ours};

/// Seconds in a year.
const YEAR_S: f64 = 365.25 * 86_400.0;
/// A year counts no more steps than this, of 50 s: clips that are shorter do not thin out the floor.
const MAX_STEPS_A_YEAR: f64 = 630_000.0;

/// Where the wants alone count, weights that give every visit to this part of it are good as they stand.
const STANDS: f64 = 5e-7;

/// Up to this worst ratio the result of a search does not depend on its start. Far above, rounding decides.
const TAME: f64 = 100.0;

/// The nearest shares, and the weights that give them: the answer of `dreams balance`. It has its own ids, so that the flock
/// may go before the weights are written: there may not be enough memory for both.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Balance {
    /// The measure in which the wants are to be reached.
    pub by: Measure,
    /// Whether some weights reach the wants exactly.
    pub reachable: bool,
    /// The share of the wanted visits that no weights can give; exactly 0 if the wants can be reached.
    pub deficiency: f64,
    /// The worst of visits/want and want/visits with these weights; `None` if a sheep is never visited.
    pub worst_ratio: Option<f64>,
    /// The worst of `time/time_want` and `time_want/time` of all sheep with a loop; `None` if one of them is never shown.
    pub worst_time_ratio: Option<f64>,
    /// Every transition of the manifest, in the order of (from, to).
    pub weights: Vec<Weight>,
    /// Every sheep of the manifest, in the order of their ids.
    pub sheep: Vec<SheepBalance>,
    /// The proof, where the wants can't be reached.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub bottleneck: Option<Bottleneck>,
    /// How often the transition that is taken least is taken in a year, of those that are played.
    pub least_plays: f64,
    /// How many steps a year counts.
    pub steps_a_year: f64,
}

/// A transition's weight, and what becomes of it.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Weight {
    /// Where it starts.
    pub from: SheepId,
    /// Where it ends.
    pub to: SheepId,
    /// The weight to write: those of a sheep's transitions are 1 in the mean. As it stands if it is not played, or if all
    /// are good as they stand.
    pub weight: f64,
    /// The fraction of all steps that take it; 0 if it is not played.
    pub visits: f64,
}

/// The figures of a sheep.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct SheepBalance {
    /// Which.
    pub id: SheepId,
    /// The fraction of visits that it gets with the weights as written; 0 if it is not played.
    pub visits: f64,
    /// The fraction of visits that the artist wishes. Those of all sheep sum to 1.
    pub want: f64,
    /// The fraction of the time in which loops are shown that its own loop is; repeats count. 0 without a loop.
    pub time: f64,
    /// The same as the artist wishes it: the part of the wants of all sheep with a loop. 0 without a loop.
    pub time_want: f64,
    /// The fraction of visits that the want amounts to in the measure of the balance; 0 if any number is fine.
    pub wanted_visits: f64,
}

/// Sheep that are wanted more than all sheep that they lead to. Every visit of the former is followed by one of the
/// latter, so no weights can meet their wants; the difference of the wanted visits is the deficiency.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Bottleneck {
    /// The sheep, in the order of their ids; those that are not played belong to them.
    #[serde(rename = "bottleneck")]
    pub sheep: Vec<SheepId>,
    /// Every sheep that they lead to within the part that is played, in the order of their ids.
    pub followers: Vec<SheepId>,
}

impl Balance {
    /// The balance of `flock`. `None` if it has no cycle to walk.
    ///
    /// Only the part that is played can be balanced; the wants of the rest are part of the deficiency. Weights from a
    /// balance of equal weights are kept, and with infinite fairness any weights that are already optimal: balancing
    /// twice changes nothing.
    pub fn of(flock: &Flock, terms: Terms) -> Option<Self> {
        let (sheep, played, answer) = visits(flock, terms, None)?;
        let PartBalance { network, steps_a_year, found, written } = answer;
        let reach = found.reach.unwrap_or_else(|| Reach::of(&network, &found.flow));
        let deficiency = deficiency(&sheep, &played, &reach);
        Some(Self {
            reachable: deficiency == 0.0,
            deficiency,
            by: terms.by,
            worst_ratio: worst(&sheep, Measure::Visits),
            worst_time_ratio: worst(&sheep, Measure::Time),
            weights: weights(flock, &written),
            bottleneck: (deficiency > 0.0).then(|| bottleneck(flock, &network, &reach)),
            least_plays: steps_a_year * exits(flock).map(|exit| written.shares.taken(exit)).fold(1.0, f64::min),
            steps_a_year,
            sheep,
        })
    }

    /// The worst ratio in the measure of the balance.
    pub fn worst(&self) -> Option<f64> {
        self.by.of(self.worst_ratio, self.worst_time_ratio)
    }

    /// The worst ratios of visits and of time that [`Balance::of`] tells, found sooner from `near`: a circulation with the
    /// same sheep, for the same terms.
    fn worst_ratios_near(flock: &Flock, terms: Terms, near: &Circulation) -> [Option<f64>; 2] {
        let told = |near| visits(flock, terms, near).map(|(sheep, ..)| sheep);
        // How often a sheep is visited of which nothing is wanted depends on where the search starts.
        let is_free = |sheep: SheepIx| terms.by == Measure::Time && flock.sheep(sheep).clip.is_none();
        if flock.graph().sheep().any(is_free) {
            let sheep = told(None);
            return [Measure::Visits, Measure::Time].map(|measure| worst(sheep.as_deref()?, measure));
        }
        let is_tame = |sheep: &Vec<SheepBalance>| worst(sheep, terms.by).is_some_and(|worst| worst <= TAME);
        // By time the visits may depend on the start: nothing is wanted of some sheep, and so of their visits.
        let near = Some(near).filter(|_| terms.by == Measure::Visits);
        let sheep = near.and_then(|near| told(Some(near))).filter(is_tame).or_else(|| told(None));
        [Measure::Visits, Measure::Time].map(|measure| worst(sheep.as_deref()?, measure))
    }
}

/// The figures of every sheep, those that are played, and the result for these. `None` if there is no cycle.
fn visits(
    flock: &Flock,
    terms: Terms,
    near: Option<&Circulation>,
) -> Option<(Vec<SheepBalance>, Vec<usize>, PartBalance)> {
    if !flock.is_walkable() {
        return None;
    }
    let (graph, whole) = (flock.graph(), flock.whole());
    let [by_visits, by_time] = [Measure::Visits, Measure::Time].map(|measure| Wants::of(flock, whole, measure));
    let wants = if terms.by == Measure::Time { &by_time } else { &by_visits };
    let played: Vec<usize> =
        graph.sheep().filter_map(|sheep| whole.find(graph.id(sheep))).map(SheepIx::index).collect();
    let answer = PartBalance::of(flock, &wants.only(&played), terms, near)?;
    let unplayed = |(at, ordinal): (usize, SheepIx)| SheepBalance {
        id: whole.id(ordinal).clone(),
        visits: 0.0,
        want: by_visits.shares[at],
        time: 0.0,
        time_want: by_time.shares[at],
        wanted_visits: wants.wanted_visits(at),
    };
    let mut sheep: Vec<SheepBalance> = whole.sheep().enumerate().map(unplayed).collect();
    let lit = |at: SheepIx| answer.written.shares.visits(at) * visit_frames(flock.sheep(at));
    let all: f64 = graph.sheep().map(lit).sum();
    for (ordinal, &at) in graph.sheep().zip(&played) {
        sheep[at].visits = answer.written.shares.visits(ordinal);
        sheep[at].time = if all > 0.0 { lit(ordinal) / all } else { 0.0 };
    }
    Some((sheep, played, answer))
}

/// The worst ratio of all in `measure`; `None` if a sheep is never shown.
fn worst(sheep: &[SheepBalance], measure: Measure) -> Option<f64> {
    let worst = sheep.iter().map(|sheep| sheep.off(measure)).fold(1.0, f64::max);
    worst.is_finite().then_some(worst)
}

/// The result, by ordinals.
struct PartBalance {
    network: Network,
    steps_a_year: f64,
    found: Solution,
    written: RoundedWeights,
}

impl PartBalance {
    /// The result for the part of `flock` that is played, with these `wants`; `near` as in [`Terms::find`].
    fn of(flock: &Flock, wants: &Wants, terms: Terms, near: Option<&Circulation>) -> Option<Self> {
        let graph = flock.graph();
        if terms.afresh || may_be_ours(graph) {
            let equal = graph.reweighted(&vec![1.0; graph.exit_count()]);
            let afresh = Self::counted_from(&equal, flock, wants, terms, near.filter(|_| terms.afresh))?;
            if afresh.written.stands(graph) {
                return Some(Self { written: RoundedWeights::standing(graph, flock.shares()?), ..afresh });
            }
            if terms.afresh {
                return Some(afresh);
            }
        }
        let mut answer = Self::counted_from(graph, flock, wants, terms, near)?;
        if terms.fairness.is_infinite() {
            let shares = flock.shares()?;
            let near = |(sheep, visits): (SheepIx, &f64)| (shares.visits(sheep) / visits - 1.0).abs() <= STANDS;
            if shares.off_by().is_finite()
                && graph.sheep().zip(&answer.found.visits).all(near)
                && exits(flock).all(|exit| shares.taken(exit) >= answer.found.least)
            {
                answer.written = RoundedWeights::standing(graph, shares);
            }
        }
        Some(answer)
    }

    /// The answer when nearness counts from the weights of `graph`.
    fn counted_from(
        graph: &Graph,
        flock: &Flock,
        wants: &Wants,
        terms: Terms,
        near: Option<&Circulation>,
    ) -> Option<Self> {
        let network = Network::new(graph, wants);
        let steps_a_year = steps_a_year(graph, flock, &network);
        let found = terms.find(&network, steps_a_year, near);
        let written = RoundedWeights::new(graph, &found.flow, &found.visits, found.tolerance, found.least)?;
        Some(Self { network, steps_a_year, found, written })
    }
}

impl SheepBalance {
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

/// How many steps a year has by the flock's own clips if sheep get what they want and leave by the chances of `graph`;
/// at most [`MAX_STEPS_A_YEAR`].
fn steps_a_year(graph: &Graph, flock: &Flock, network: &Network) -> f64 {
    let step_s = |sheep: SheepIx| {
        let on = |exit: Exit| graph.chance(exit) * flock.seconds(&flock.transition(exit).clip);
        flock.visit_seconds(sheep) + graph.exits(sheep).map(on).sum::<f64>()
    };
    let mean_s: f64 = graph.sheep().map(|sheep| network.want[sheep.index()] * step_s(sheep)).sum();
    (YEAR_S / mean_s).min(MAX_STEPS_A_YEAR)
}

/// The share of the wants that cannot be met: those of sheep that are not played, and the deficiency among the others.
fn deficiency(sheep: &[SheepBalance], played: &[usize], reach: &Reach) -> f64 {
    if played.len() == sheep.len() {
        return reach.deficiency;
    }
    let wanted: f64 = played.iter().map(|&at| sheep[at].wanted_visits).sum();
    1.0 - wanted * (1.0 - reach.deficiency)
}

fn bottleneck(flock: &Flock, network: &Network, reach: &Reach) -> Bottleneck {
    let (graph, whole) = (flock.graph(), flock.whole());
    let mut followers: Vec<usize> =
        reach.bottleneck.iter().flat_map(|&sheep| network.exits(sheep)).map(|arc| network.to[arc] as usize).collect();
    followers.sort_unstable();
    followers.dedup();
    let id = |at: usize| graph.id(SheepIx(at as u32)).clone();
    let unplayed = whole.sheep().map(|sheep| whole.id(sheep)).filter(|id| graph.find(id).is_none()).cloned();
    let mut sheep: Vec<SheepId> = reach.bottleneck.iter().map(|&at| id(at)).chain(unplayed).collect();
    sheep.sort();
    Bottleneck { sheep, followers: followers.into_iter().map(id).collect() }
}

fn exits(flock: &Flock) -> impl Iterator<Item = Exit> {
    flock.graph().sheep().flat_map(|sheep| flock.graph().exits(sheep))
}

fn weights(flock: &Flock, written: &RoundedWeights) -> Vec<Weight> {
    let (graph, whole) = (flock.graph(), flock.whole());
    let played: Vec<Option<SheepIx>> = whole.sheep().map(|sheep| graph.find(whole.id(sheep))).collect();
    let mut weights = Vec::with_capacity(whole.exit_count());
    for from in whole.sheep() {
        for exit in whole.exits(from) {
            let to = whole.target(exit);
            let own = played[from.index()].zip(played[to.index()]).and_then(|(from, to)| graph.between(from, to));
            let (weight, visits) = match own {
                Some(own) => (written.weights[own.index()], written.shares.taken(own)),
                None => (whole.weight(exit), 0.0),
            };
            weights.push(Weight { from: whole.id(from).clone(), to: whole.id(to).clone(), weight, visits });
        }
    }
    weights
}

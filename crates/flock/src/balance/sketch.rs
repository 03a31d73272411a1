//! An approximate balance, to estimate the effect of adding or removing a transition.
//!
//! Owns the search near a known balance: it selects promising changes and evaluates them from the old prices, only as
//! exactly as a comparison needs.
//!
//! Start at [`Sketch::of`].

use super::circulation::Circulation;
use super::network::Network;
use super::solve::settle;
use super::steps_a_year;
use super::system::System;
use super::terms::Terms;
use super::wants::Wants;
use crate::flock::Flock;
use crate::graph::classes;

/// The highest fairness for estimates: above, prices depend on fewer and fewer sheep.
const HIGHEST: f64 = 30.0;
/// The linear system is solved to this part when reliefs are told.
const FRACTION: f64 = 1e-3;
/// Rows and columns are right to this part of a throughput when changes are compared, ...
const ROUGH: f64 = 1e-2;
/// ... and to this when the best of them is where the next search begins.
const SURE: f64 = 1e-8;
/// The exponent of ratios in the badness: the worst ones dominate, equal ones still add up.
const POWER: i32 = 8;
/// Changes that are tried, by price and by relief: these first, and if none of them makes the balance better, more. Of 600
/// changes that were the best of 32 in flocks whose wants can nearly be reached, 586 were promised by relief, and 404 of
/// these were among the first six; where one sheep is wanted by far too much, prices tell more.
pub(super) const TRIES: [[usize; 2]; 2] = [[3, 5], [16, 16]];
/// Tries times transitions: what a round may take.
const EFFORT: usize = 2_000_000;
/// Up to this many sheep all pairs are considered; above, those among this many most promising ones on each side.
const PAIRS: usize = 96;

/// A transition more or less, by the ordinals of what is played.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Change {
    /// One more.
    Add {
        /// Where it starts.
        from: usize,
        /// Where it ends.
        to: usize,
    },
    /// One less.
    Remove {
        /// Where it starts.
        from: usize,
        /// Where it ends.
        to: usize,
    },
}

/// What a change promises, in two measures.
type Promise = ([f64; 2], Change);

/// A flock's balance, and what first flows along new transitions are worth.
#[derive(Clone)]
pub(super) struct Sketch {
    network: Network,
    state: Circulation,
    /// By how much the badness falls with a first flow out of each sheep, then into each.
    relief: Vec<f64>,
}

impl Sketch {
    /// The balance of what `flock` plays, on `terms`.
    pub(super) fn of(flock: &Flock, terms: Terms) -> Self {
        let graph = flock.graph();
        let equal = terms.afresh.then(|| graph.reweighted(&vec![1.0; graph.exit_count()]));
        let graph = equal.as_ref().unwrap_or(graph);
        let network = Network::new(graph, &Wants::of(flock, graph, terms.by));
        let terms = Terms { fairness: terms.fairness.min(HIGHEST), ..terms };
        let state = terms.outline(&network, steps_a_year(graph, flock, &network));
        Self::around(network, state)
    }

    /// The balance `state` of `network`.
    fn around(network: Network, state: Circulation) -> Self {
        let (relief, _) = System::new(&network, &state).solve(&slope(&network, &state), FRACTION);
        Self { network, state, relief }
    }

    /// Of `changes` the one after which the balance is best, and the balance then. `None` if none of them can be made.
    pub(super) fn best(&self, changes: Vec<Change>) -> Option<(Change, Self)> {
        let tried = changes.into_iter().filter_map(|change| Some((change, self.after(change)?)));
        let (change, network, mut state, _) = tried
            .map(|(change, (network, state))| {
                let badness = badness(&network, &state);
                (change, network, state, badness)
            })
            .filter(|(.., badness)| badness.is_finite())
            .min_by(|(.., a), (.., b)| a.total_cmp(b))?;
        // What every transition carries at least is the same part of all as before.
        state.floor = self.state.floor / self.state.mass() * state.mass();
        settle(&network, &mut state, SURE);
        Some((change, Self::around(network, state)))
    }

    /// The flows of this balance.
    pub(super) fn circulation(&self) -> &Circulation {
        &self.state
    }

    /// How bad this balance is: a mean of all ratios in which the worst count most; 1 is perfect.
    pub(super) fn badness(&self) -> f64 {
        badness(&self.network, &self.state)
    }

    /// The transitions that may be worth adding: so many by price and by relief.
    pub(super) fn additions(&self, tries: [usize; 2]) -> Vec<Change> {
        let n = self.network.len();
        let ends = |side: usize| {
            let own = |values: &[f64]| promising(&values[side * n..(side + 1) * n]);
            let mut ends = [own(&self.state.prices), own(&self.relief)].concat();
            ends.sort_unstable();
            ends.dedup();
            ends
        };
        let (rows, columns) = (ends(0), ends(1));
        let usual = self.usual();
        let mut pairs = Vec::new();
        for &from in &rows {
            let exits = &self.network.to[self.network.exits(from)];
            for &to in columns.iter().filter(|&&to| to != from && exits.binary_search(&(to as u32)).is_err()) {
                let price = self.state.prices[from] + self.state.prices[n + to];
                let through = |sheep| self.state.throughput(&self.network, sheep);
                let flow = (usual[from] + price).exp().min(0.5 * through(from).min(through(to))) + self.state.floor;
                let change = Change::Add { from, to };
                pairs.push(([price, flow * (self.relief[from] + self.relief[n + to])], change));
            }
        }
        self.most_promising(pairs, tries)
    }

    /// The transitions that may be worth removing: so many by price and by relief.
    pub(super) fn removals(&self, tries: [usize; 2]) -> Vec<Change> {
        let n = self.network.len();
        let promise = |arc: usize| {
            let (from, to) = self.network.ends(arc);
            let price = self.state.prices[from] + self.state.prices[n + to];
            let flow = self.state.flow[arc];
            let saved = -self.state.floor * price - flow;
            let relief = -(flow + self.state.floor) * (self.relief[from] + self.relief[n + to]);
            ([saved, relief], Change::Remove { from, to })
        };
        self.most_promising((0..self.network.arcs()).map(promise).collect(), tries)
    }

    /// The network and its balance, roughly, after `change`. `None` if not all sheep could be played any more.
    fn after(&self, change: Change) -> Option<(Network, Circulation)> {
        let network = match change {
            Change::Add { from, to } => {
                let mut arcs: Vec<_> = self.arcs().collect();
                let at = arcs.partition_point(|&(a, b, _)| (a as usize, b as usize) < (from, to));
                arcs.insert(at, (from as u32, to as u32, self.usual_of(from)));
                self.network.with_arcs(&arcs)
            }
            Change::Remove { from, to } => {
                let arcs: Vec<_> = self.arcs().filter(|&(a, b, _)| (a as usize, b as usize) != (from, to)).collect();
                let network = self.network.with_arcs(&arcs);
                let class = classes(&network.first, |arc| network.to[arc] as usize);
                if network.arcs() == 0 || class.iter().any(|&class| class > 0) {
                    return None;
                }
                network
            }
        };
        let mut state = self.state.resumed(&network);
        settle(&network, &mut state, ROUGH);
        Some((network, state))
    }

    fn arcs(&self) -> impl Iterator<Item = (u32, u32, f64)> {
        let network = &self.network;
        (0..network.arcs()).map(|arc| (network.from[arc], network.to[arc], network.prior[arc]))
    }

    /// For every sheep, the logarithm of what a new exit's part of all weights would be.
    fn usual(&self) -> Vec<f64> {
        (0..self.network.len()).map(|sheep| self.usual_of(sheep)).collect()
    }

    fn usual_of(&self, sheep: usize) -> f64 {
        let own = &self.network.prior[self.network.exits(sheep)];
        let most = own.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        most + (own.iter().map(|prior| (prior - most).exp()).sum::<f64>() / own.len() as f64).ln()
    }

    /// The changes that promise most, by either figure.
    fn most_promising(&self, mut changes: Vec<Promise>, tries: [usize; 2]) -> Vec<Change> {
        let tries = tries.map(|tries| (EFFORT / self.network.arcs()).clamp(1, tries));
        let mut chosen: Vec<Change> = Vec::new();
        for figure in 0..2 {
            let by_promise = |(a, _): &Promise, (b, _): &Promise| b[figure].total_cmp(&a[figure]);
            let enough = (chosen.len() + tries[figure]).min(changes.len());
            if enough < changes.len() {
                changes.select_nth_unstable_by(enough, by_promise);
            }
            changes[..enough].sort_by(by_promise);
            let new = changes.iter().map(|(_, change)| *change).filter(|change| !chosen.contains(change));
            let new: Vec<Change> = new.take(tries[figure]).collect();
            chosen.extend(new);
        }
        chosen
    }
}

/// Sheep by their places in `values`: all of them, or those with the highest.
fn promising(values: &[f64]) -> Vec<usize> {
    let mut places: Vec<usize> = (0..values.len()).collect();
    if places.len() > PAIRS {
        places.select_nth_unstable_by(PAIRS / 2, |&a, &b| values[b].total_cmp(&values[a]));
        places.truncate(PAIRS / 2);
    }
    places
}

/// Share over want, by sheep; 1 if nothing is wanted.
fn ratios(network: &Network, state: &Circulation) -> Vec<f64> {
    let all: f64 = network.share.iter().zip(&state.scarcity).map(|(share, scarcity)| share / scarcity).sum();
    let ratio = |(sheep, scarcity): (usize, &f64)| if network.is_free(sheep) { 1.0 } else { 1.0 / (scarcity * all) };
    state.scarcity.iter().enumerate().map(ratio).collect()
}

/// How far off a ratio is, to the power.
fn weighed(ratio: f64) -> f64 {
    ratio.max(1.0 / ratio).powi(POWER)
}

fn badness(network: &Network, state: &Circulation) -> f64 {
    let ratios = ratios(network, state);
    (ratios.iter().map(|&ratio| weighed(ratio)).sum::<f64>() / ratios.len() as f64).powf(1.0 / f64::from(POWER))
}

/// How much worse prices make it, by price, in the measure of [`weighed`].
fn slope(network: &Network, state: &Circulation) -> Vec<f64> {
    let ratios = ratios(network, state);
    let worse = |(sheep, &ratio): (usize, &f64)| match ratio {
        _ if network.is_free(sheep) => 0.0,
        ratio if ratio > 1.0 => weighed(ratio),
        ratio => -weighed(ratio),
    };
    let all: f64 = ratios.iter().enumerate().map(worse).sum();
    let own = |(sheep, ratio): (usize, &f64)| {
        let share = ratio * network.share[sheep];
        -(worse((sheep, ratio)) - share * all) / (state.gives_way(network, sheep) * state.scarcity[sheep])
    };
    let slope: Vec<f64> = ratios.iter().enumerate().map(own).collect();
    [slope.clone(), slope].concat()
}

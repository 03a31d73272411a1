//! The parameters of a balance, and the circulation for them.
//!
//! Defines fairness (infinite as a limit) and floor (in plays a year). `solve.rs` searches.

use super::circulation::Circulation;
use super::exact;
use super::network::Network;
use super::reach::Reach;
use super::solve::{EXACT, fairest, nearest, resumed, settle};
use crate::flock::Measure;

/// The highest fairness short of infinity; above, shares differ from the fairest by a millionth at most.
const HIGHEST: f64 = 1e6;
/// Visits are off what the circulation gives by no more than this part of it when weights are written, ...
const TOLERANCE: f64 = 1e-3;
/// ... and by no more than this where shares alone count.
const FAIREST_TOLERANCE: f64 = 2e-7;
/// Transitions that carry nothing in the limit are let carry so little that no visits move by more than this part.
const SILENT: f64 = 2e-7;
/// Floors make up this part of all steps where they ask for more than a year has.
const MAX_FLOOR: f64 = 0.1;
/// A circulation that has to carry more than this to be normalised with its floors is given up.
const MAX_MASS: f64 = 8.0;
/// Tries to find the floor that is right after normalising.
const FLOOR_TRIES: usize = 30;

/// The parameters of a balance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Terms {
    /// The importance of the wants relative to the written weights; above 0. Infinite: only the wants count, and of the
    /// optimal solutions the one nearest to the weights is taken.
    pub fairness: f64,
    /// How often every transition is taken in a year at least, 0 or more.
    pub floor: f64,
    /// Whether equal weights are used in place of the written ones.
    pub afresh: bool,
    /// The measure in which sheep should get what is wanted of them.
    pub by: Measure,
}

/// The circulation for some terms.
pub(super) struct Solution {
    /// The flow of each transition; all of them sum to 1.
    pub(super) flow: Vec<f64>,
    /// The visits of each sheep; all of them sum to 1.
    pub(super) visits: Vec<f64>,
    /// The minimum flow of every transition; lower than in the terms if a year has too few steps.
    pub(super) least: f64,
    /// How near visits should be when weights are rounded, as a part of them.
    pub(super) tolerance: f64,
    /// Whether the wants can be met, if the search had to know.
    pub(super) reach: Option<Reach>,
}

impl Default for Terms {
    fn default() -> Self {
        Self { fairness: 3.0, floor: 12.0, afresh: false, by: Measure::Visits }
    }
}

impl Terms {
    /// The circulation in `network` that fulfils these terms, with so many steps in a year. `near` is one of a network with
    /// the same sheep: the search is shorter from there, its end is the same.
    pub(super) fn find(self, network: &Network, steps_a_year: f64, near: Option<&Circulation>) -> Solution {
        if self.fairness <= HIGHEST {
            let (state, least) = with_floor(network, self.fairness, self.floor / steps_a_year, near);
            let flow = carried(&state);
            return Solution { visits: visits(network, &flow), flow, least, tolerance: TOLERANCE, reach: None };
        }
        let soft = nearest(network, Self::default().fairness, 0.0);
        let reach = Reach::of(network, &carried(&soft));
        let tolerance = FAIREST_TOLERANCE;
        if self.floor > 0.0 {
            let (state, least) = with_floor(network, f64::INFINITY, self.floor / steps_a_year, None);
            let flow = carried(&state);
            return Solution { visits: visits(network, &flow), flow, least, tolerance, reach: Some(reach) };
        }
        let near = without_floor(network, &reach);
        let exact = (reach.deficiency == 0.0).then(|| exact::circulation(network, &near)).flatten();
        if let Some(flow) = exact {
            return Solution { visits: visits(network, &flow), flow, least: 0.0, tolerance, reach: Some(reach) };
        }
        let mut flow = near;
        blend(network, &mut flow, &carried(&soft));
        Solution { visits: visits(network, &flow), flow, least: 0.0, tolerance, reach: Some(reach) }
    }

    /// The search that [`Terms::find`] ends with, for a finite fairness and with floors as far as a year has steps.
    pub(super) fn outline(self, network: &Network, steps_a_year: f64) -> Circulation {
        with_floor(network, self.fairness, self.floor / steps_a_year, None).0
    }
}

/// The nearest circulation in which, after normalising, every transition carries `floor`; and the floor itself, lower
/// where so much can't be.
fn with_floor(network: &Network, fairness: f64, floor: f64, near: Option<&Circulation>) -> (Circulation, f64) {
    let near = near.filter(|near| near.fairness.total_cmp(&fairness).is_eq());
    let search = |floor| match near.and_then(|near| resumed(near, network, floor)) {
        Some(found) => found,
        None if fairness.is_finite() => nearest(network, fairness, floor),
        None => fairest(network, floor),
    };
    // Rounded weights must not fall below the floor.
    let aim = floor * (1.0 + TOLERANCE);
    if aim * (network.arcs() as f64) < 1.0 {
        let mut state = search(aim);
        for _ in 0..FLOOR_TRIES {
            let right = aim * state.mass();
            if right <= state.floor * (1.0 + 0.1 * TOLERANCE) {
                return (state, floor);
            }
            if right > MAX_MASS * aim {
                break;
            }
            state.floor = right;
            settle(network, &mut state, EXACT);
        }
    }
    let state = search(floor.min(MAX_FLOOR / network.arcs() as f64));
    let least = state.floor / state.mass() * (1.0 - TOLERANCE);
    (state, least.min(floor))
}

/// The proportionally fairest circulation, and of those the nearest one.
fn without_floor(network: &Network, reach: &Reach) -> Vec<f64> {
    let met = carried(&fairest(&network.restricted(&reach.carries), 0.0));
    let mut met = met.into_iter();
    reach.carries.iter().map(|&carries| if carries { met.next().unwrap_or(0.0) } else { 0.0 }).collect()
}

/// Lets a little of `other`, a circulation that takes every transition, into `flow`.
fn blend(network: &Network, flow: &mut [f64], other: &[f64]) {
    let (own, others) = (visits(network, flow), visits(network, other));
    let most = others.iter().zip(&own).map(|(other, own)| other / own).fold(1.0, f64::max);
    let part = SILENT / most;
    for (flow, other) in flow.iter_mut().zip(other) {
        *flow += part * (other - *flow);
    }
}

/// The flow of each transition, normalised to a sum of 1.
fn carried(state: &Circulation) -> Vec<f64> {
    let mass = state.mass();
    state.flow.iter().map(|flow| (flow + state.floor) / mass).collect()
}

/// The visits that `flow` gives.
fn visits(network: &Network, flow: &[f64]) -> Vec<f64> {
    (0..network.len()).map(|sheep| flow[network.exits(sheep)].iter().sum()).collect()
}

//! The search for the nearest circulation.
//!
//! Owns the order of sweeps and Newton steps, and the way to high fairness over lower ones. Never touches weights as
//! they are written: `weights.rs` does.

use super::circulation::Circulation;
use super::network::Network;
use super::system::System;

/// A search ends when every row and column is this near to its sheep's throughput, as a part of it.
pub(super) const EXACT: f64 = 1e-12;
/// On the way to a higher fairness this is near enough.
const ON_THE_WAY: f64 = 1e-3;
/// The first fairness, from which higher ones are led to.
const FIRST: f64 = 3.0;
/// By how much fairness rises at a time.
const RISE: f64 = 6.0;
/// Most sweeps before the first step.
const SWEEPS: usize = 40;
/// Sweeps have done their work when they change no price by more.
const SETTLED: f64 = 0.3;
/// Most Newton steps for one fairness.
const STEPS: usize = 80;
/// A search also ends when so many steps in a row bring nothing.
const PATIENCE: usize = 4;

/// The nearest circulation in `network` for `fairness` (finite) with at least `floor` along every transition.
pub(super) fn nearest(network: &Network, fairness: f64, floor: f64) -> Circulation {
    let mut state = Circulation::new(network, fairness.min(FIRST), floor);
    for _ in 0..SWEEPS {
        if state.sweep(network) < SETTLED {
            break;
        }
    }
    while state.fairness < fairness {
        settle(network, &mut state, ON_THE_WAY);
        let next = (state.fairness * RISE).min(fairness);
        lead(network, &mut state, next);
    }
    settle(network, &mut state, EXACT);
    state
}

/// Newton steps until rows and columns are right to `aim`, or rounding ends it. Returns the error that is left.
pub(super) fn settle(network: &Network, state: &mut Circulation, aim: f64) -> f64 {
    let (mut best, mut idle) = (f64::INFINITY, 0);
    for _ in 0..STEPS {
        let (excess, error) = state.excess(network);
        idle = if error < 0.5 * best { 0 } else { idle + 1 };
        best = best.min(error);
        if error <= aim || idle > PATIENCE && error < 1e-6 {
            return error;
        }
        let right: Vec<f64> = excess.iter().map(|excess| -excess).collect();
        let system = System::new(network, state);
        let (direction, _) = system.solve(&right, (0.1 * error.sqrt()).clamp(1e-10, 0.05), 20 * network.len() + 200);
        state.step(network, &direction, &excess, error);
        if error > ON_THE_WAY {
            state.sweep(network);
        }
    }
    best
}

/// Raises the fairness of a settled `state`, its prices along the tangent of their way.
fn lead(network: &Network, state: &mut Circulation, fairness: f64) {
    let n = network.len();
    let right: Vec<f64> = (0..2 * n)
        .map(|at| {
            let scarcity = state.scarcity[at % n];
            network.want[at % n] * (scarcity - 1.0) / (state.fairness * scarcity * scarcity)
        })
        .collect();
    let (tangent, _) = System::new(network, state).solve(&right, 1e-6, 20 * n + 200);
    let by = fairness - state.fairness;
    state.raise(fairness);
    let length = state.longest(network, &tangent, by);
    state.shift(network, &tangent, length);
}

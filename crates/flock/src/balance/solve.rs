//! The search for the nearest circulation.
//!
//! Owns the order of sweeps and Newton steps, the continuation from low to high fairness, and the limit of infinite
//! fairness. Weights are rounded in `weights.rs`.

use super::circulation::Circulation;
use super::network::Network;
use super::system::System;

/// A search ends when every row and column is this near to its sheep's throughput, as a part of it.
pub(super) const EXACT: f64 = 1e-12;
/// An incomplete search is accepted if it came as near as this.
const AT_REST: f64 = 1e-10;
/// On the way to a higher fairness this is near enough.
const ON_THE_WAY: f64 = 1e-2;
/// The first fairness, from which higher ones are led to.
const FIRST: f64 = 3.0;
/// By how much fairness rises at a time.
const RISE: f64 = 2.5;
/// The fairness up to which rises help where the wants alone count.
const HIGHEST: f64 = 1e4;
/// The fairness from which that limit is gone for.
const NEAR: f64 = 300.0;
/// Throughputs are those of infinite fairness when another round moves none by more than this part.
const STILL: f64 = 1e-7;
/// Most rounds towards infinite fairness.
const ROUNDS: usize = 100;
/// Most sweeps before the first step.
const SWEEPS: usize = 40;
/// Sweeps have done their work when they change no price by more.
const SETTLED: f64 = 0.3;
/// Most Newton steps for one fairness.
const STEPS: usize = 80;
/// A search also ends when so many steps in a row bring nothing.
const PATIENCE: usize = 4;

/// The nearest circulation in `network` for `fairness` (finite) with at least `floor` along every transition; for a
/// lower fairness if the numbers overflow before.
pub(super) fn nearest(network: &Network, fairness: f64, floor: f64) -> Circulation {
    let mut state = Circulation::new(network, fairness.min(FIRST), floor);
    for _ in 0..SWEEPS {
        if state.sweep(network) < SETTLED {
            break;
        }
    }
    let mut sound = state.clone();
    while state.fairness < fairness {
        settle(network, &mut state, ON_THE_WAY);
        if !state.is_sound() {
            return sound;
        }
        sound.clone_from(&state);
        let right: Vec<f64> = state.strain(network).into_iter().map(|strain| -strain).collect();
        let (relief, _) = System::new(network, &state).solve(&right, 1e-3);
        let most = (state.fairness * RISE).min(fairness) - state.fairness;
        state.lead(network, &relief, most);
    }
    settle(network, &mut state, EXACT);
    if state.is_sound() { state } else { sound }
}

/// The same from `near`, a circulation of that fairness in a network with the same sheep. `None` if it does not converge.
pub(super) fn resumed(near: &Circulation, network: &Network, floor: f64) -> Option<Circulation> {
    let mut state = near.resumed(network);
    state.floor = floor;
    let error = settle(network, &mut state, EXACT);
    (error <= AT_REST && state.is_sound()).then_some(state)
}

/// The limit of infinite fairness: the wants alone count, and of the circulations that serve them best the nearest one.
///
/// Each round counts nearness from the flows of the round before, so that what the weights as written hold back fades
/// exponentially, and fairness itself may stay finite.
///
/// # Source
/// Proximal minimisation with relative entropy: Censor & Zenios (1992).
pub(super) fn fairest(network: &Network, floor: f64) -> Circulation {
    let mut state = nearest(network, NEAR, floor);
    let mut aim = ON_THE_WAY;
    for _ in 0..ROUNDS {
        let before = state.scarcity.clone();
        state.recentre(network, (HIGHEST / state.fairness).clamp(1.0, 4.0));
        settle(network, &mut state, aim);
        let moved = before.iter().zip(&state.scarcity).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
        if moved < STILL && aim <= STILL {
            break;
        }
        aim = aim.min(0.1 * moved).max(0.01 * aim).max(STILL);
    }
    settle(network, &mut state, EXACT);
    state
}

/// Newton steps until rows and columns are right to `aim`, or rounding ends it. Returns the error that is left.
pub(super) fn settle(network: &Network, state: &mut Circulation, aim: f64) -> f64 {
    let (mut best, mut idle) = (f64::INFINITY, 0);
    for _ in 0..STEPS {
        let (mut excess, mut error) = state.excess(network);
        if error > ON_THE_WAY {
            state.sweep(network);
            (excess, error) = state.excess(network);
        }
        idle = if error < 0.5 * best { 0 } else { idle + 1 };
        best = best.min(error);
        if error <= aim || idle > PATIENCE && error < 1e-6 {
            return error;
        }
        let right: Vec<f64> = excess.iter().map(|excess| -excess).collect();
        let (direction, _) = System::new(network, state).solve(&right, (0.1 * error.sqrt()).clamp(1e-10, 0.05));
        state.step(network, &direction, &excess, error);
    }
    best
}

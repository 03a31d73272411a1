//! The circulation nearest to the written weights and the wants.
//!
//! Owns the state of the search: the flow along each transition, and the errors of rows and columns. One state is
//! improved by [`Circulation::sweep`] (sheep by sheep) and [`Circulation::step`] (all at once, in the direction that
//! `system.rs` finds). `solve.rs` chooses fairness and floor.
//!
//! # Source
//! min over circulations `f >= floor`, with throughput `n`, of `KL(f || prior) + fairness * KL(want || n)`. In its dual
//! each sheep has two prices, `a` for leaving and `b` for entering, and
//! `f = floor + prior * exp(a + b)`, `n = want / (1 + (a + b) / fairness)`: a smooth convex problem, solved by Newton.
//! The fairness is lower for a sheep of which nothing is wanted: [`Network::importance`].
//! Proportional fairness after Kelly, Maulloo & Tan (1998).

use std::ops::Range;

use super::network::Network;

/// The largest rise of a flow's logarithm in one step.
const MAX_RISE: f64 = 12.0;
/// The largest rise of a flow's logarithm by a rise of fairness.
const MAX_LEAD: f64 = 3.0;
/// A step may take at most this part of the way to where a throughput would be infinite.
const MAX_FALL: f64 = 0.9;
/// A step is long enough when the slope at its end is this small beside that at its start.
const FLAT: f64 = 0.3;
/// Tries for the length of a step.
const TRIES: usize = 30;
/// Newton steps of one sheep's own equation, and what another one may bring at most: its neighbours change as well.
const SWEEP_STEPS: usize = 12;
const SWEPT: f64 = 1e-6;
/// A sweep leaves a row or column as it is that is right to this part of its throughput.
const RIGHT: f64 = 1e-3;
/// Sums of flows that have all their digits.
const SUMS: Range<f64> = 1e-250..1e250;
/// The search for a price starts from the one there is where the row is off by less than this part.
const NEAR: f64 = 0.3;
/// Below this relative error a full step is taken unseen: slopes are rounding there.
const CLOSE: f64 = 1e-7;

/// Flows along all transitions of a network, not yet balanced.
#[derive(Clone, Debug)]
pub(super) struct Circulation {
    /// The factor of `KL(want || n)` relative to `KL(f || prior)`; finite, above 0.
    pub(super) fairness: f64,
    /// The minimum flow of each transition.
    pub(super) floor: f64,
    /// The logarithm of what each transition carries above the floor.
    log_flow: Vec<f64>,
    /// The flow of each transition above the floor.
    pub(super) flow: Vec<f64>,
    /// Want over throughput, by sheep.
    pub(super) scarcity: Vec<f64>,
    /// The prices: `a` by sheep, then `b` by sheep.
    pub(super) prices: Vec<f64>,
    /// The flow above the floor out of each sheep, then into each.
    pub(super) sums: Vec<f64>,
    /// Transitions out of each sheep, then into each.
    degrees: Vec<u32>,
}

impl Circulation {
    /// The flows of `network` at prices of 0: the weights as written.
    pub(super) fn new(network: &Network, fairness: f64, floor: f64) -> Self {
        let n = network.len();
        let mut degrees = vec![0; 2 * n];
        for arc in 0..network.arcs() {
            let (from, to) = network.ends(arc);
            degrees[from] += 1;
            degrees[n + to] += 1;
        }
        let mut new = Self {
            fairness,
            floor,
            log_flow: network.prior.clone(),
            flow: vec![0.0; network.arcs()],
            scarcity: vec![1.0; n],
            prices: vec![0.0; 2 * n],
            sums: vec![0.0; 2 * n],
            degrees,
        };
        new.measure(network);
        new
    }

    /// The same prices in `network`, which has the same sheep and other transitions.
    pub(super) fn resumed(&self, network: &Network) -> Self {
        let n = network.len();
        let mut resumed = Self::new(network, self.fairness, self.floor);
        (resumed.scarcity, resumed.prices) = (self.scarcity.clone(), self.prices.clone());
        for arc in 0..network.arcs() {
            let (from, to) = network.ends(arc);
            resumed.log_flow[arc] += self.prices[from] + self.prices[n + to];
        }
        resumed.measure(network);
        resumed
    }

    /// The throughput of `sheep`, by its prices.
    pub(super) fn throughput(&self, network: &Network, sheep: usize) -> f64 {
        network.want[sheep] / self.scarcity[sheep]
    }

    /// The fairness for `sheep`: its prices may rise by so much until it gets half of what is wanted of it.
    pub(super) fn gives_way(&self, network: &Network, sheep: usize) -> f64 {
        self.fairness * network.importance(sheep)
    }

    /// What all sheep and transitions together carry; above or below 1 by how the prices fall.
    pub(super) fn mass(&self) -> f64 {
        self.flow.iter().map(|flow| flow + self.floor).sum()
    }

    /// Whether all flows and throughputs are numbers.
    pub(super) fn is_sound(&self) -> bool {
        self.flow.iter().chain(&self.scarcity).all(|number| number.is_finite()) && self.mass() > 0.0
    }

    /// By how much each row and column is above its sheep's throughput; its largest part of a throughput.
    pub(super) fn excess(&self, network: &Network) -> (Vec<f64>, f64) {
        let n = network.len();
        let mut worst = 0.0f64;
        let excess = (0..2 * n)
            .map(|at| {
                let through = self.throughput(network, at % n);
                let excess = self.sums[at] + self.floor * f64::from(self.degrees[at]) - through;
                worst = worst.max(excess.abs() / through);
                excess
            })
            .collect();
        (excess, worst)
    }

    /// Sets each sheep's two prices in turn to what makes its own row and column right, but for those that nearly are.
    /// Returns the largest change of a price, or of the logarithm of a throughput.
    pub(super) fn sweep(&mut self, network: &Network) -> f64 {
        let n = network.len();
        let mut moved = 0.0f64;
        let mut change = vec![0.0; n];
        let mut sums = self.sums[..n].to_vec();
        for side in 0..2 {
            let ends = if side == 0 { &network.from } else { &network.to };
            let log_sums = self.log_sums(ends, &sums);
            for at in 0..n {
                let fixed = self.floor * f64::from(self.degrees[side * n + at]);
                let fairness = self.gives_way(network, at);
                let by = own_price(log_sums[at], fixed, self.scarcity[at], network.want[at], fairness);
                change[at] = by;
                if by == 0.0 {
                    continue;
                }
                let before = self.scarcity[at];
                self.scarcity[at] += by / fairness;
                moved = moved.max(by.abs()).max((self.scarcity[at] / before).ln().abs());
                self.prices[side * n + at] += by;
            }
            for (log, &at) in self.log_flow.iter_mut().zip(ends) {
                *log += change[at as usize];
            }
            if side == 0 {
                let times: Vec<f64> = change.iter().map(|by| by.exp()).collect();
                sums.fill(0.0);
                for (flow, (&from, &to)) in self.flow.iter().zip(network.from.iter().zip(&network.to)) {
                    sums[to as usize] += flow * times[from as usize];
                }
            }
        }
        self.measure(network);
        moved
    }

    /// The logarithms of `sums`, which are of the flows that share their entry in `ends`; of the flows themselves where a
    /// sum is too small or too large to be right.
    fn log_sums(&self, ends: &[u32], sums: &[f64]) -> Vec<f64> {
        if sums.iter().all(|sum| SUMS.contains(sum)) {
            return sums.iter().map(|sum| sum.ln()).collect();
        }
        let mut most = vec![f64::NEG_INFINITY; sums.len()];
        for (&log, &at) in self.log_flow.iter().zip(ends) {
            most[at as usize] = most[at as usize].max(log);
        }
        let mut parts = vec![0.0; sums.len()];
        for (&log, &at) in self.log_flow.iter().zip(ends) {
            parts[at as usize] += (log - most[at as usize]).exp();
        }
        most.iter().zip(parts).map(|(most, part): (&f64, f64)| most + part.ln()).collect()
    }

    /// Moves all prices along `direction`, as far as that brings the balance nearer. Returns the part of it taken.
    pub(super) fn step(&mut self, network: &Network, direction: &[f64], excess: &[f64], error: f64) -> f64 {
        let slope: f64 = excess.iter().zip(direction).map(|(excess, by)| excess * by).sum();
        let mut length = self.longest(network, direction, 1.0);
        let mut taken = 0.0;
        for _ in 0..TRIES {
            self.shift(network, direction, length - taken);
            taken = length;
            if error < CLOSE {
                break;
            }
            let (excess, _) = self.excess(network);
            let end: f64 = excess.iter().zip(direction).map(|(excess, by)| excess * by).sum();
            if end <= FLAT * slope.abs() {
                break;
            }
            length *= (slope.abs() / (slope.abs() + end)).clamp(0.1, 0.7);
        }
        taken
    }

    /// How far along `direction`, `most` at most, no flow rises and no throughput grows beyond measure.
    pub(super) fn longest(&self, network: &Network, direction: &[f64], most: f64) -> f64 {
        let n = network.len();
        let rise = |arc: usize| direction[network.from[arc] as usize] + direction[n + network.to[arc] as usize];
        let mut per_length = (0..network.arcs()).map(rise).fold(0.0, f64::max) / MAX_RISE;
        for sheep in 0..n {
            let fall = -(direction[sheep] + direction[n + sheep]) / self.gives_way(network, sheep);
            per_length = per_length.max(fall / (MAX_FALL * self.scarcity[sheep]));
        }
        if per_length * most > 1.0 { 1.0 / per_length } else { most }
    }

    /// Counts nearness from the flows as they are from now on, with `times` the fairness; throughputs stay.
    pub(super) fn recentre(&mut self, network: &Network, times: f64) {
        self.fairness *= times;
        for price in &mut self.prices {
            *price *= times;
        }
        let n = network.len();
        for arc in 0..network.arcs() {
            let (from, to) = network.ends(arc);
            self.log_flow[arc] += self.prices[from] + self.prices[n + to];
        }
        self.measure(network);
    }

    /// What a rise of the fairness by 1 would add to rows and columns if prices rose in proportion, and so throughputs
    /// stayed.
    pub(super) fn strain(&self, network: &Network) -> Vec<f64> {
        let n = network.len();
        let mut strain = vec![0.0; 2 * n];
        for arc in 0..network.arcs() {
            let (from, to) = network.ends(arc);
            let more = self.flow[arc] * (self.prices[from] + self.prices[n + to]) / self.fairness;
            strain[from] += more;
            strain[n + to] += more;
        }
        strain
    }

    /// Raises the fairness by up to `by`, as far as no flow rises and no throughput grows beyond measure: prices in
    /// proportion, and by `relief` for each 1.
    pub(super) fn lead(&mut self, network: &Network, relief: &[f64], by: f64) {
        let n = network.len();
        let tangent: Vec<f64> =
            self.prices.iter().zip(relief).map(|(price, relief)| price / self.fairness + relief).collect();
        let rise = |arc: usize| tangent[network.from[arc] as usize] + tangent[n + network.to[arc] as usize];
        let mut per_one = (0..network.arcs()).map(rise).fold(0.0, f64::max) / MAX_LEAD;
        for sheep in 0..n {
            let fall = -(relief[sheep] + relief[n + sheep]) / ((self.fairness + by) * network.importance(sheep));
            per_one = per_one.max(fall / (0.5 * self.scarcity[sheep]));
        }
        let by = (1.0 / per_one).clamp(0.05 * self.fairness, by.max(0.05 * self.fairness)).min(by);
        self.fairness += by;
        for sheep in 0..n {
            let change = by * (relief[sheep] + relief[n + sheep]) / self.gives_way(network, sheep);
            self.scarcity[sheep] = (self.scarcity[sheep] + change).max(0.1 * self.scarcity[sheep]);
        }
        for arc in 0..network.arcs() {
            let (from, to) = network.ends(arc);
            self.log_flow[arc] += by * (tangent[from] + tangent[n + to]);
        }
        for (price, by_one) in self.prices.iter_mut().zip(&tangent) {
            *price += by * by_one;
        }
        self.measure(network);
    }

    /// Moves all prices by `length` times `direction`.
    pub(super) fn shift(&mut self, network: &Network, direction: &[f64], length: f64) {
        let n = network.len();
        for (price, by) in self.prices.iter_mut().zip(direction) {
            *price += length * by;
        }
        for sheep in 0..n {
            let fairness = self.gives_way(network, sheep);
            self.scarcity[sheep] += length * (direction[sheep] + direction[n + sheep]) / fairness;
        }
        for arc in 0..network.arcs() {
            let (from, to) = network.ends(arc);
            self.log_flow[arc] += length * (direction[from] + direction[n + to]);
        }
        self.measure(network);
    }

    /// Recomputes flows and sums from their logarithms.
    fn measure(&mut self, network: &Network) {
        let n = network.len();
        self.sums.fill(0.0);
        for arc in 0..network.arcs() {
            let (from, to) = network.ends(arc);
            let flow = self.log_flow[arc].exp();
            self.flow[arc] = flow;
            self.sums[from] += flow;
            self.sums[n + to] += flow;
        }
    }
}

/// By how much one price must change: the `x` with `e^(log_sum + x) + fixed = want / (scarcity + x / fairness)`; 0 if
/// that is nearly so.
fn own_price(log_sum: f64, fixed: f64, scarcity: f64, want: f64, fairness: f64) -> f64 {
    let through = want / scarcity;
    let off = (log_sum.exp() + fixed) / through - 1.0;
    if off.abs() <= RIGHT {
        return 0.0;
    }
    let aim = (through - fixed).max(1e-3 * through);
    let least = |x: f64| x.max(-MAX_FALL * scarcity * fairness);
    let mut x = if off.abs() < NEAR { 0.0 } else { least(aim.ln() - log_sum) };
    let log_fixed = fixed.ln();
    for _ in 0..SWEEP_STEPS {
        // In logarithms, because flows may underflow.
        let (log_flow, scarce) = (log_sum + x, scarcity + x / fairness);
        let over = log_fixed - log_flow;
        let value = log_flow.max(log_fixed) + (-over.abs()).exp().ln_1p() + scarce.ln() - want.ln();
        let slope = 1.0 / (1.0 + over.exp()) + 1.0 / (fairness * scarce);
        let next = (x - value / slope).clamp(x - MAX_FALL * scarce * fairness, x + MAX_RISE);
        if (next - x).abs() <= SWEPT * (1.0 + x.abs()) {
            return next;
        }
        x = next;
    }
    x
}

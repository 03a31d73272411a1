//! The linear system of one Newton step.
//!
//! Owns its solution by conjugate gradients on the prices of leaving, those of entering eliminated. `circulation.rs`
//! decides the step length.

use super::circulation::Circulation;
use super::network::Network;

/// Multiplications by a transition's flow that one solution may take: some seconds.
const EFFORT: usize = 400_000_000;

/// `[R + H, F + H; F' + H, C + H]`, with the flows `F`, their row sums `R` and column sums `C`, and how throughputs give
/// way to prices, `H`.
pub(super) struct System<'n> {
    network: &'n Network,
    flow: &'n [f64],
    gives: Vec<f64>,
    /// The diagonal: rows, then columns.
    diagonal: Vec<f64>,
    /// The diagonal of the rows' system when columns are eliminated.
    reduced: Vec<f64>,
}

impl<'n> System<'n> {
    /// The system at `state`.
    pub(super) fn new(network: &'n Network, state: &'n Circulation) -> Self {
        let n = network.len();
        let gives: Vec<f64> = (0..n)
            .map(|sheep| {
                let through = state.throughput(network, sheep);
                through / (state.gives_way(network, sheep) * state.scarcity[sheep])
            })
            .collect();
        let diagonal: Vec<f64> = (0..2 * n).map(|at| (state.sums[at] + gives[at % n]).max(f64::MIN_POSITIVE)).collect();
        let mut taken = vec![0.0; n];
        let mut stays = gives.clone();
        for arc in 0..network.arcs() {
            let (from, to) = network.ends(arc);
            if from == to {
                stays[from] += state.flow[arc];
            } else {
                taken[from] += state.flow[arc] * (state.flow[arc] / diagonal[n + to]);
            }
        }
        let reduced = (0..n)
            .map(|at| (diagonal[at] - taken[at] - stays[at] * (stays[at] / diagonal[n + at])).max(1e-13 * diagonal[at]))
            .collect();
        Self { network, flow: &state.flow, gives, diagonal, reduced }
    }

    /// Solves for `right`, rows then columns, until what is left is below `fraction` of it or the effort is spent.
    /// Returns the answer and the rounds.
    pub(super) fn solve(&self, right: &[f64], fraction: f64) -> (Vec<f64>, usize) {
        let n = self.network.len();
        let most = (20 * n + 200).min(EFFORT / (self.flow.len() + n));
        let (rows, columns) = right.split_at(n);
        let mut scaled: Vec<f64> = columns.iter().zip(&self.diagonal[n..]).map(|(right, d)| right / d).collect();
        let mut rest = vec![0.0; n];
        self.across(&scaled, &mut rest);
        for (rest, row) in rest.iter_mut().zip(rows) {
            *rest = row - *rest;
        }
        let mut answer = vec![0.0; 2 * n];
        let mut towards = vec![0.0; n];
        let (mut image, mut size, mut first) = (vec![0.0; n], 1.0, None);
        let mut rounds = 0;
        loop {
            let new: f64 = rest.iter().zip(&self.reduced).map(|(rest, d)| rest * (rest / d)).sum();
            let start = *first.get_or_insert(new);
            if new <= fraction * fraction * start || rounds == most || !new.is_finite() {
                break;
            }
            for at in 0..n {
                towards[at] = rest[at] / self.reduced[at] + if rounds == 0 { 0.0 } else { new / size * towards[at] };
            }
            size = new;
            self.back(&towards, &mut scaled);
            for (scaled, d) in scaled.iter_mut().zip(&self.diagonal[n..]) {
                *scaled /= d;
            }
            self.across(&scaled, &mut image);
            for at in 0..n {
                image[at] = self.diagonal[at] * towards[at] - image[at];
            }
            let curve: f64 = towards.iter().zip(&image).map(|(a, b)| a * b).sum();
            if curve <= 0.0 {
                break;
            }
            let length = size / curve;
            for at in 0..n {
                answer[at] += length * towards[at];
                rest[at] -= length * image[at];
            }
            rounds += 1;
        }
        let (leaving, entering) = answer.split_at_mut(n);
        self.back(leaving, entering);
        for at in 0..n {
            entering[at] = (columns[at] - entering[at]) / self.diagonal[n + at];
        }
        (answer, rounds)
    }

    /// What prices of entering do to rows.
    fn across(&self, entering: &[f64], rows: &mut [f64]) {
        for (sheep, row) in rows.iter_mut().enumerate() {
            let exits = self.network.exits(sheep);
            let to = &self.network.to[exits.clone()];
            let flows = self.flow[exits].iter().zip(to).map(|(flow, &to)| flow * entering[to as usize]);
            *row = self.gives[sheep] * entering[sheep] + flows.sum::<f64>();
        }
    }

    /// What prices of leaving do to columns.
    fn back(&self, leaving: &[f64], columns: &mut [f64]) {
        for (column, (gives, price)) in columns.iter_mut().zip(self.gives.iter().zip(leaving)) {
            *column = gives * price;
        }
        for (sheep, &price) in leaving.iter().enumerate() {
            let exits = self.network.exits(sheep);
            for (flow, &to) in self.flow[exits.clone()].iter().zip(&self.network.to[exits]) {
                columns[to as usize] += flow * price;
            }
        }
    }
}

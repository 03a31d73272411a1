//! Shares of a nearly decomposable flock.
//!
//! Owns the aggregation: parts are groups of sheep that a walk seldom leaves, found by their flows; shares are iterated at
//! two levels in turn, between parts and within each part. Sweeps alone converge as slowly as a walk crosses between parts.
//!
//! Start at [`settle`].

use super::chain::{Chain, normalise};
use super::solve;
use super::sweep::{STILL, sweep};

/// Most rounds of asking the neighbours.
const ROUNDS: usize = 40;
/// Most turns of both levels, and sweeps in each.
const TURNS: usize = 80;
const SWEEPS: usize = 4;
/// It is given up when so many turns brought nothing.
const PATIENCE: usize = 8;

/// Finds the shares of `chain` from a rough guess; only the proof shows whether it succeeded.
///
/// # Source
/// Koury, `McAllister` & Stewart, *Iterative methods for computing stationary distributions of nearly completely
/// decomposable Markov chains* (1984); parts by Raghavan, Albert & Kumara (2007).
pub(super) fn settle(chain: &Chain, shares: &mut [f64]) {
    let parts = Parts::of(chain, shares);
    // Parts of one or two sheep would be as much work as the whole.
    if parts.count < 2 || parts.count > chain.len() / 2 {
        return;
    }
    let (mut least, mut idle) = (f64::INFINITY, 0);
    for _ in 0..TURNS {
        let weighed = parts.weigh(shares);
        let swept = (0..SWEEPS).map(|_| sweep(chain, shares)).last();
        normalise(shares);
        let moved = swept.map_or(weighed, |swept| swept.max(weighed));
        if moved <= STILL {
            break;
        }
        idle = if moved < least / 2.0 { 0 } else { idle + 1 };
        least = least.min(moved);
        if idle >= PATIENCE {
            break;
        }
    }
}

/// Which part each sheep belongs to, and what leads from part to part.
struct Parts {
    of: Vec<u32>,
    count: usize,
    /// Pairs of parts between which there are chances.
    pairs: Vec<(u32, u32)>,
    /// Each chance between two parts: its source, how much it is, and which pair it joins.
    bridges: Vec<(u32, f64, u32)>,
}

impl Parts {
    fn of(chain: &Chain, shares: &[f64]) -> Self {
        let mut of = labels(chain, shares);
        let mut number = vec![u32::MAX; chain.len()];
        let mut count = 0;
        for label in &mut of {
            let number = &mut number[*label as usize];
            if *number == u32::MAX {
                *number = count;
                count += 1;
            }
            *label = *number;
        }
        let between = |&(from, to, _): &(usize, usize, f64)| of[from] != of[to];
        let pair = |from: usize, to: usize| (of[from], of[to]);
        let mut pairs: Vec<_> = chain.arcs().filter(between).map(|(from, to, _)| pair(from, to)).collect();
        pairs.sort_unstable();
        pairs.dedup();
        let bridge = |(from, to, chance): (usize, usize, f64)| {
            let at = pairs.binary_search(&pair(from, to)).expect("every pair was collected");
            (from as u32, chance, at as u32)
        };
        let bridges = chain.arcs().filter(between).map(bridge).collect();
        Self { of, count: count as usize, pairs, bridges }
    }

    /// Scales each part to its share of the whole; returns the largest relative change.
    fn weigh(&self, shares: &mut [f64]) -> f64 {
        let mut weight = vec![0.0; self.count];
        for (&part, &share) in self.of.iter().zip(&*shares) {
            weight[part as usize] += share;
        }
        let mut chances = vec![0.0; self.pairs.len()];
        for &(from, chance, pair) in &self.bridges {
            chances[pair as usize] += shares[from as usize] * chance;
        }
        let flow = |(&(from, to), &flow): (&(u32, u32), &f64)| (from, to, flow / weight[from as usize]);
        let coarse = Chain::new(self.count, || self.pairs.iter().zip(&chances).map(flow));
        let due = solve::estimate(&coarse);
        let (mut moved, total) = (0.0f64, weight.iter().sum::<f64>());
        for (weight, due) in weight.iter_mut().zip(due) {
            let change = due * total / *weight;
            moved = moved.max((change - 1.0).abs());
            *weight = change;
        }
        for (share, &part) in shares.iter_mut().zip(&self.of) {
            *share *= weight[part as usize];
        }
        moved
    }
}

/// Assigns each sheep to the part with which it exchanges most flow, until nothing changes. Sheep are visited in a
/// fixed pseudorandom order, because neighbours in the manifest would influence each other.
fn labels(chain: &Chain, shares: &[f64]) -> Vec<u32> {
    let n = chain.len();
    let neighbours = Neighbours::of(chain, shares);
    let mut order: Vec<u32> = (0..n as u32).collect();
    order.sort_by_key(|&sheep| scattered(sheep));
    let mut label: Vec<u32> = (0..n as u32).collect();
    let (mut is_asked, mut tally) = (vec![true; n], vec![0.0f64; n]);
    for _ in 0..ROUNDS {
        let mut changed = 0;
        for &sheep in &order {
            let at = sheep as usize;
            if !std::mem::replace(&mut is_asked[at], false) {
                continue;
            }
            for (near, flow) in neighbours.around(at) {
                tally[label[near] as usize] += flow;
            }
            let mut best = label[at];
            for (near, _) in neighbours.around(at) {
                let other = label[near];
                let better = tally[other as usize].total_cmp(&tally[best as usize]);
                let drawn = || best != label[at] && scattered(other) < scattered(best);
                if better.then_with(|| drawn().cmp(&false)).is_gt() {
                    best = other;
                }
            }
            for (near, _) in neighbours.around(at) {
                tally[label[near] as usize] = 0.0;
            }
            if best != label[at] {
                label[at] = best;
                changed += 1;
                neighbours.around(at).for_each(|(near, _)| is_asked[near] = true);
            }
        }
        // A few sheep on a border may keep changing.
        if changed * 1000 <= n {
            break;
        }
    }
    label
}

/// A pseudorandom number for each number.
fn scattered(at: u32) -> u64 {
    let mixed = u64::from(at).wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    (mixed ^ mixed >> 29).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 16
}

/// Flows between sheep, either way.
struct Neighbours {
    first: Vec<u32>,
    near: Vec<u32>,
    flow: Vec<f64>,
}

impl Neighbours {
    fn of(chain: &Chain, shares: &[f64]) -> Self {
        let n = chain.len();
        let mut first = vec![0u32; n + 2];
        for (from, to, _) in chain.arcs() {
            first[from + 2] += 1;
            first[to + 2] += 1;
        }
        for at in 2..first.len() {
            first[at] += first[at - 1];
        }
        let (mut near, mut flow) = (vec![0; first[n + 1] as usize], vec![0.0; first[n + 1] as usize]);
        for (from, to, chance) in chain.arcs() {
            for (one, other) in [(from, to), (to, from)] {
                let next = &mut first[one + 1];
                near[*next as usize] = other as u32;
                flow[*next as usize] = shares[from] * chance;
                *next += 1;
            }
        }
        first.pop();
        Self { first, near, flow }
    }

    fn around(&self, sheep: usize) -> impl Iterator<Item = (usize, f64)> {
        let row = self.first[sheep] as usize..self.first[sheep + 1] as usize;
        self.near[row.clone()].iter().map(|&near| near as usize).zip(self.flow[row].iter().copied())
    }
}

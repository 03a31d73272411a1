//! A proved bound on the error of shares.
//!
//! A small residual proves nothing: in a flock of two halves joined by one bridge, shares that are wrong by half may
//! have a residual of a billionth. The proof uses how much the *probabilities* would have to change to make the shares
//! exact. Each share is a sum, over the trees that lead every sheep to that one, of products with one probability of
//! each sheep (the Markov chain tree theorem): if those of sheep `v` change by at most the relative amount `e_v`, no
//! share changes by more than the product of `(1 + e_v) / (1 - e_v)`.
//!
//! To make given shares exact it is enough to change flows along a spanning tree: the imbalance of a branch goes over
//! the transition that connects it. The tree of the strongest flows needs the smallest changes. The imbalance is a
//! difference of nearly equal sums, and is computed in double-double arithmetic.
//!
//! Sources: Leighton & Rivest, *Estimating a probability using finite memory* (1986), for the theorem; O'Cinneide,
//! *Entrywise perturbation theory and error analysis for Markov chains* (1993), for its use.

use super::chain::Chain;

/// The unit of rounding.
const U: f64 = f64::EPSILON / 2.0;
/// Flows smaller than this have no full double-double precision.
const MIN_FLOW: f64 = 1e-250;

/// The bound on the relative error of `shares` for `chain`. Infinite if nothing can be proved.
pub(super) fn off_by(chain: &Chain, shares: &[f64]) -> f64 {
    let usable = |flow: f64| flow.is_finite() && flow > MIN_FLOW;
    if !flows(chain, shares).all(|(.., flow)| usable(flow)) {
        return f64::INFINITY;
    }
    let Some(tree) = strongest_tree(chain, shares) else { return f64::INFINITY };
    let strain: f64 =
        strains(&tree, imbalance(chain, shares)).map(|e| if e < 1.0 { 2.0 * e / (1.0 - e) } else { 1.0 }).sum();
    // The probabilities are rounded, too: once for each addition of weights, once for the quotient.
    let total = strain + 2.0 * U * (chain.arc_count() + chain.len()) as f64;
    if total < 1.0 { total / (1.0 - total) } else { f64::INFINITY }
}

/// A branch of the tree that spans a flock.
struct Branch {
    from: u32,
    to: u32,
    flow: f64,
}

/// Every transition with its flow, as often as it is asked for: a million of them would take 8 MB.
fn flows(chain: &Chain, shares: &[f64]) -> impl Iterator<Item = (usize, usize, f64)> {
    chain.arcs().map(|(from, to, chance)| (from, to, shares[from] * chance))
}

/// The tree of the strongest flows, to within a factor of 2. `None` if the flows do not join all sheep.
///
/// # Source
/// Kruskal (1956), on flows sorted by their binary exponents.
fn strongest_tree(chain: &Chain, shares: &[f64]) -> Option<Vec<Branch>> {
    let exponent = |flow: f64| 2047 - (flow.to_bits() >> 52) as usize;
    let mut start = vec![0usize; 2049];
    for (.., flow) in flows(chain, shares) {
        start[exponent(flow) + 1] += 1;
    }
    for at in 1..start.len() {
        start[at] += start[at - 1];
    }
    let mut sorted = vec![(0u32, 0u32, 0.0); chain.arc_count()];
    for (from, to, flow) in flows(chain, shares) {
        let next = &mut start[exponent(flow)];
        sorted[*next] = (from as u32, to as u32, flow);
        *next += 1;
    }
    let mut sets = Sets { above: (0..chain.len() as u32).collect() };
    let mut tree = Vec::with_capacity(chain.len());
    for (from, to, flow) in sorted {
        if sets.join(from, to) {
            tree.push(Branch { from, to, flow });
            if tree.len() + 1 == chain.len() {
                break;
            }
        }
    }
    (tree.len() + 1 == chain.len()).then_some(tree)
}

/// Which sheep hang together so far.
struct Sets {
    above: Vec<u32>,
}

impl Sets {
    fn root(&mut self, mut at: u32) -> u32 {
        while self.above[at as usize] != at {
            let next = self.above[at as usize];
            self.above[at as usize] = self.above[next as usize];
            at = next;
        }
        at
    }

    /// Joins the sets of `a` and `b`; whether they were two.
    fn join(&mut self, a: u32, b: u32) -> bool {
        let (a, b) = (self.root(a), self.root(b));
        // The lower number stays on top: no ranks are needed to be quick enough, and the order is always the same.
        self.above[a.max(b) as usize] = a.min(b);
        a != b
    }
}

/// The inflow of each sheep minus its outflow.
fn imbalance(chain: &Chain, shares: &[f64]) -> Vec<DoubleDouble> {
    let n = chain.len();
    let (mut imbalance, mut leaving) = (vec![DoubleDouble::ZERO; n], vec![DoubleDouble::ZERO; n]);
    for (from, to, chance) in chain.arcs() {
        imbalance[to] = imbalance[to].plus(DoubleDouble::product(shares[from], chance));
        leaving[from] = leaving[from].plus(DoubleDouble { high: chance, low: 0.0 });
    }
    for ((imbalance, leaving), &share) in imbalance.iter_mut().zip(leaving).zip(shares) {
        let high = DoubleDouble::product(leaving.high, -share);
        *imbalance = imbalance.plus(high).plus(DoubleDouble { high: leaving.low * -share, low: 0.0 });
    }
    imbalance
}

/// The relative change of each sheep's probabilities that removes the imbalance.
fn strains(tree: &[Branch], mut imbalance: Vec<DoubleDouble>) -> impl Iterator<Item = f64> + use<> {
    let n = imbalance.len();
    // A leaf has one branch: the exclusive or of its branches' numbers is that one.
    let (mut branches, mut which) = (vec![0u32; n], vec![0usize; n]);
    for (number, branch) in tree.iter().enumerate() {
        for end in [branch.from, branch.to] {
            branches[end as usize] += 1;
            which[end as usize] ^= number;
        }
    }
    let mut leaves: Vec<usize> = (0..n).filter(|&sheep| branches[sheep] == 1).collect();
    let mut strain = vec![0.0f64; n];
    while let Some(leaf) = leaves.pop() {
        if branches[leaf] != 1 {
            continue;
        }
        let number = which[leaf];
        let branch = &tree[number];
        let other = (branch.from ^ branch.to) as usize ^ leaf;
        let from = branch.from as usize;
        strain[from] = strain[from].max(imbalance[leaf].high.abs() / branch.flow);
        imbalance[other] = imbalance[other].plus(imbalance[leaf]);
        branches[leaf] = 0;
        branches[other] -= 1;
        which[other] ^= number;
        if branches[other] == 1 {
            leaves.push(other);
        }
    }
    strain.into_iter()
}

/// A number with twice the precision: the sum of two.
///
/// # Source
/// Dekker, *A floating-point technique for extending the available precision* (1971).
#[derive(Clone, Copy, Debug)]
struct DoubleDouble {
    high: f64,
    low: f64,
}

impl DoubleDouble {
    const ZERO: Self = Self { high: 0.0, low: 0.0 };

    /// `a * b` without loss.
    fn product(a: f64, b: f64) -> Self {
        let high = a * b;
        Self { high, low: a.mul_add(b, -high) }
    }

    fn plus(self, other: Self) -> Self {
        let high = self.high + other.high;
        let part = high - self.high;
        let lost = (self.high - (high - part)) + (other.high - part);
        let low = lost + self.low + other.low;
        let sum = high + low;
        Self { high: sum, low: low - (sum - high) }
    }
}

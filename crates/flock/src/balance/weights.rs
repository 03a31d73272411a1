//! From a circulation to weights that a manifest can hold.
//!
//! Owns the rounding: as few digits as keep the visits where they should be. Never changes a flow beyond that.

use crate::graph::Graph;
use crate::shares::Shares;

/// The significant digits that are tried, fewest first.
const DIGITS: [usize; 7] = [3, 4, 6, 8, 10, 13, 17];
/// Flocks of more sheep get a single try: the shares of a large flock are not for nothing.
const LARGE: usize = 3000;
/// The least chance that is written: shares multiply chances, and must stay numbers.
const LEAST: f64 = 1e-40;
/// Weights that differ by no more than this part are the same: another machine may round another way.
const SAME: f64 = 1e-9;
/// What rounding takes from the mean of a sheep's weights, or gives, at most.
const ROUNDED: f64 = 0.01;

/// Weights as they are written, and what the walk makes of them.
#[derive(Clone, Debug)]
pub(super) struct Written {
    /// By exit; those of a sheep are 1 in the mean.
    pub(super) weights: Vec<f64>,
    /// Of the walk with these weights.
    pub(super) shares: Shares,
}

impl Written {
    /// Weights by which `graph` carries `flow`, whose visits are `visits`; no visit more than the part `tolerance` off,
    /// no transition taken less than `least`.
    pub(super) fn new(graph: &Graph, flow: &[f64], visits: &[f64], tolerance: f64, least: f64) -> Option<Self> {
        let exact = weights(graph, flow);
        let mut closest: Option<(f64, Self)> = None;
        let enough = (1.0 - tolerance.log10()).ceil() as usize;
        let tried = DIGITS.iter().filter(|&&digits| graph.len() <= LARGE || digits >= enough);
        for &digits in tried {
            let weights: Vec<f64> = exact.iter().map(|&weight| rounded(weight, digits)).collect();
            let shares = Shares::of(&graph.reweighted(&weights)).ok()?;
            let off = graph.sheep().map(|sheep| (shares.visits(sheep) / visits[sheep.index()] - 1.0).abs());
            let off = off.fold(0.0, f64::max);
            let exits = graph.sheep().flat_map(|sheep| graph.exits(sheep));
            let fits = off <= tolerance && exits.into_iter().all(|exit| shares.taken(exit) >= least);
            let written = Self { weights, shares };
            if fits || graph.len() > LARGE {
                return Some(written);
            }
            if closest.as_ref().is_none_or(|(best, _)| off < *best) {
                closest = Some((off, written));
            }
        }
        closest.map(|(_, written)| written)
    }

    /// The weights of `graph` as they stand, whose shares are `shares`.
    pub(super) fn standing(graph: &Graph, shares: &Shares) -> Self {
        let exits = graph.sheep().flat_map(|sheep| graph.exits(sheep));
        Self { weights: exits.map(|exit| graph.weight(exit)).collect(), shares: shares.clone() }
    }

    /// Whether these are the weights of `graph` as they stand.
    pub(super) fn stands(&self, graph: &Graph) -> bool {
        let exits = graph.sheep().flat_map(|sheep| graph.exits(sheep));
        exits.zip(&self.weights).all(|(exit, weight)| (graph.weight(exit) / weight - 1.0).abs() <= SAME)
    }
}

/// Whether the weights of `graph` may have been written by a balance: those of each sheep are 1 in the mean, and they
/// are not all equal.
pub(super) fn may_be_ours(graph: &Graph) -> bool {
    let equal = |row: &[f64]| row.iter().all(|weight| (weight - row[0]).abs() <= SAME * row[0]);
    let rows = || graph.sheep().map(|sheep| graph.weights(sheep)).filter(|row| !row.is_empty());
    let ours = |row: &[f64]| (row.iter().sum::<f64>() / row.len() as f64 - 1.0).abs() <= ROUNDED;
    rows().all(ours) && !rows().all(equal)
}

/// The weights of `flow`: chances, times the number of exits.
fn weights(graph: &Graph, flow: &[f64]) -> Vec<f64> {
    let mut weights = Vec::with_capacity(flow.len());
    for sheep in graph.sheep() {
        let own = &flow[graph.row(sheep)];
        let total: f64 = own.iter().sum();
        weights.extend(own.iter().map(|flow| (flow / total).max(LEAST) * own.len() as f64));
    }
    weights
}

/// `number` with so many significant decimal digits.
pub(super) fn rounded(number: f64, digits: usize) -> f64 {
    format!("{number:.*e}", digits - 1).parse().expect("a printed number is a number")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_keeps_the_leading_digits_and_no_others() {
        let told = |number, digits| rounded(number, digits).to_string();
        assert_eq!([told(0.012_345_67, 3), told(1.999_9, 3), told(4.3e-3, 1)], ["0.0123", "2", "0.004"]);
    }
}

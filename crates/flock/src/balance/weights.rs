//! Rounding of a circulation to weights for a manifest.
//!
//! Uses the fewest digits that keep the visits within tolerance.

use crate::graph::Graph;
use crate::shares::Shares;

/// The significant digits that are tried, fewest first.
const DIGITS: [usize; 7] = [3, 4, 6, 8, 10, 13, MAX_DIGITS];
/// So many digits lose nothing.
const MAX_DIGITS: usize = 17;
/// Visits that are off by so many times what they may be are so, however roughly they are known.
const SURELY: f64 = 1.5;
/// Flocks of more sheep get a single try: the shares of a large flock are not for nothing.
const LARGE: usize = 3000;
/// The smallest probability that is written: shares are products of probabilities, and must stay finite.
const LEAST: f64 = 1e-40;
/// Relative difference below which weights are equal: rounding may differ between machines.
const SAME: f64 = 1e-9;
/// What rounding takes from the mean of a sheep's weights, or gives, at most.
const ROUNDED: f64 = 0.01;

/// The quick way of rounding is right for up to so many digits and powers of ten.
const FEW: usize = 13;
const POWERS: i32 = 22;
/// So near to halfway between two numbers it might not be.
const HALFWAY: f64 = 1e-2;

/// Weights as they are written, and what the walk makes of them.
#[derive(Clone, Debug)]
pub(super) struct RoundedWeights {
    /// By exit; those of a sheep are 1 in the mean.
    pub(super) weights: Vec<f64>,
    /// Of the walk with these weights.
    pub(super) shares: Shares,
}

impl RoundedWeights {
    /// Weights by which `graph` carries `flow`, whose visits are `visits`; no visit more than the part `tolerance` off,
    /// no transition taken less than `least`.
    pub(super) fn new(graph: &Graph, flow: &[f64], visits: &[f64], tolerance: f64, least: f64) -> Option<Self> {
        let mut closest: Option<(f64, Self)> = None;
        let enough = (1.0 - tolerance.log10()).ceil() as usize;
        let tried = DIGITS.iter().filter(|&&digits| graph.len() <= LARGE || digits >= enough);
        for &digits in tried {
            let weights: Vec<f64> = weights(graph, flow).into_iter().map(|weight| rounded(weight, digits)).collect();
            let reweighted = graph.reweighted(&weights);
            // What a few sweeps tell to be too far off need not be solved, unless it is the last to be tried.
            let is_last = digits == MAX_DIGITS || graph.len() > LARGE;
            if !is_last && off(visits, &Shares::swept(&reweighted, visits)) > SURELY * tolerance {
                continue;
            }
            let shares = Shares::of(&reweighted).ok()?;
            let got: Vec<f64> = graph.sheep().map(|sheep| shares.visits(sheep)).collect();
            let off = off(visits, &got);
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

/// By which part of themselves `visits` are off what was got, at most.
fn off(visits: &[f64], got: &[f64]) -> f64 {
    got.iter().zip(visits).map(|(got, visits)| (got / visits - 1.0).abs()).fold(0.0, f64::max)
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

/// `number`, which is finite, with so many significant decimal digits.
pub(super) fn rounded(number: f64, digits: usize) -> f64 {
    let places = (digits as i32 - 1).saturating_sub(number.abs().log10().floor() as i32);
    if digits <= FEW && (0..=POWERS).contains(&places) {
        let power = 10f64.powi(places);
        let scaled = number * power;
        // A whole number over a power of ten, neither of them rounded, is what the digits would be read as. What is nearly
        // halfway between two of them is left to the exact way.
        if ((scaled - scaled.trunc()).abs() - 0.5).abs() > HALFWAY {
            return scaled.round() / power;
        }
    }
    format!("{number:.*e}", digits - 1).parse().expect("a printed number is a number")
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn rounding_keeps_the_leading_digits_and_no_others() {
        let told = |number: f64, digits| rounded(number, digits).to_string();
        assert_eq!([told(0.012_345_67, 3), told(1.999_9, 3), told(4.3e-3, 1)], ["0.0123", "2", "0.004"]);
    }

    proptest! {
        #[test]
        fn rounding_is_what_printing_and_reading_make_of_a_number(
            part in 1.0f64..10.0, power in -60i32..20, digits in prop::sample::select(DIGITS.to_vec()),
        ) {
            let number = part * 10f64.powi(power);
            let read: f64 = format!("{number:.*e}", digits - 1).parse().unwrap();
            prop_assert_eq!(rounded(number, digits).to_bits(), read.to_bits(), "{} to {} digits", number, digits);
        }
    }
}

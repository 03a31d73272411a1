//! Which method finds the shares of a chain.
//!
//! Owns the order of methods: cheap ones first, until the proof is good enough. Small flocks are solved by dense
//! elimination; large ones by sweeps, which suffice if the walk mixes fast; then by eliminating sheep at no cost
//! (chains and rings may vanish completely) and aggregating the rest; at last by eliminating as much as memory allows.

use super::chain::{Chain, normalise};
use super::dense;
use super::parts;
use super::proof::off_by;
use super::reduce::{Limits, Reduction};
use super::sweep;

/// Up to this many sheep a chain is solved by dense elimination, in a few milliseconds.
const SMALL: usize = 400;
/// A bound that ends the search: a billionth, because it includes the rounding of a million probabilities.
const ENOUGH: f64 = 1e-8;
/// How far large chains are reduced, first at no cost, then in seconds and half a gigabyte.
const LIGHT: Limits = Limits { ways: 4, work: usize::MAX };
const HEAVY: Limits = Limits { ways: 10_000, work: 1_500_000_000 };
/// Until what is left is full.
const LIMITLESS: Limits = Limits { ways: usize::MAX, work: usize::MAX };

/// The shares of a chain.
#[derive(Debug)]
pub(super) struct SolvedShares {
    /// They sum to 1.
    pub(super) visits: Vec<f64>,
    /// The bound on their relative error; infinite if nothing could be proved.
    pub(super) off_by: f64,
}

/// The shares of `chain`, which is strongly connected.
pub(super) fn solve(chain: &Chain) -> SolvedShares {
    if chain.len() <= SMALL {
        return proved(chain, outright(chain));
    }
    let (guess, is_still) = swept(chain);
    let mut best = SolvedShares { visits: guess, off_by: f64::INFINITY };
    if is_still {
        best = proved(chain, best.visits);
    }
    for limits in [LIGHT, HEAVY] {
        if best.off_by <= ENOUGH {
            break;
        }
        let found = proved(chain, reduced(chain, limits, &best.visits));
        if found.off_by < best.off_by || best.off_by.is_infinite() {
            best = found;
        }
    }
    best
}

/// The same at low cost and without a proof, for intermediate steps of a search.
pub(super) fn estimate(chain: &Chain) -> Vec<f64> {
    let mut shares = if chain.len() <= SMALL {
        outright(chain)
    } else {
        let (guess, is_still) = swept(chain);
        if is_still { guess } else { reduced(chain, LIGHT, &guess) }
    };
    normalise(&mut shares);
    shares
}

/// The shares of `chain` by sweeps from equal parts; whether they converged.
fn swept(chain: &Chain) -> (Vec<f64>, bool) {
    let mut shares = vec![1.0 / chain.len() as f64; chain.len()];
    let is_still = sweep::settle(chain, &mut shares);
    (shares, is_still)
}

/// The shares of `chain` by way of its core, where `guess` is needed as a start.
fn reduced(chain: &Chain, limits: Limits, guess: &[f64]) -> Vec<f64> {
    let reduction = Reduction::of(chain, limits);
    let core = &reduction.core;
    let shares = if core.len() <= dense::MOST {
        outright(core)
    } else {
        let mut shares: Vec<f64> = reduction.kept.iter().map(|&sheep| guess[sheep as usize]).collect();
        parts::settle(core, &mut shares);
        shares
    };
    reduction.put_back(&shares)
}

/// The shares of a chain of at most [`dense::MOST`] sheep by elimination alone.
fn outright(chain: &Chain) -> Vec<f64> {
    let reduction = Reduction::of(chain, LIMITLESS);
    reduction.put_back(&dense::eliminated(&reduction.core))
}

/// `visits` with their bound; equal parts without a bound if they are not finite.
fn proved(chain: &Chain, mut visits: Vec<f64>) -> SolvedShares {
    normalise(&mut visits);
    if !visits.iter().all(|share| share.is_finite()) {
        let equal = 1.0 / chain.len() as f64;
        return SolvedShares { visits: vec![equal; chain.len()], off_by: f64::INFINITY };
    }
    SolvedShares { off_by: off_by(chain, &visits), visits }
}

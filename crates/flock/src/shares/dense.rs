//! Shares of a small chain, as a dense matrix.
//!
//! Owns the elimination on a full matrix. It has no subtraction, so that each share is accurate to the last bits,
//! however small it is.

use super::chain::{Chain, keep_in_range};

/// Most sheep: 32 MB, two seconds.
pub(super) const MOST: usize = 2000;

/// The shares of `chain`, not normalised: takes the sheep out of the chain one by one, then puts them back.
/// `8 n^2` bytes, some `n^3 / 3` multiplications.
///
/// # Source
/// Grassmann, Taksar & Heyman, *Regenerative analysis and steady state distributions for Markov chains* (1985).
pub(super) fn eliminated(chain: &Chain) -> Vec<f64> {
    let n = chain.len();
    let mut flow = vec![0.0; n * n];
    for (from, to, chance) in chain.arcs() {
        flow[from * n + to] += chance;
    }
    for gone in (1..n).rev() {
        let (rest, row) = flow.split_at_mut(gone * n);
        let row = &row[..gone];
        let out: f64 = row.iter().sum();
        for from in rest.chunks_exact_mut(n) {
            from[gone] /= out;
            let into = from[gone];
            if into > 0.0 {
                for (to, &chance) in from.iter_mut().zip(row) {
                    *to += into * chance;
                }
            }
        }
    }
    let mut visits = vec![0.0; n];
    visits[0] = 1.0;
    for at in 1..n {
        visits[at] = (0..at).map(|from| visits[from] * flow[from * n + at]).sum();
        keep_in_range(&mut visits, at);
    }
    visits
}

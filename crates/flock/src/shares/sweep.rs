//! Shares by Gauss-Seidel sweeps.
//!
//! Owns the sweep and its stopping rule. Fast if the walk mixes fast, and useless if not: a flock of two halves joined
//! by one bridge looks converged long before it is. So only `proof.rs` decides whether the result is right.

use super::chain::{Chain, normalise};

/// Relaxation factor; below 1 so that a ring swept backwards converges, too.
const RELAX: f64 = 0.95;
/// Relative change at which a sweep has converged to the last bits.
pub(super) const STILL: f64 = 1e-15;
/// Below this it may oscillate in the last bits.
const NEARLY_STILL: f64 = 1e-13;
/// Sweeps between two checks of progress.
const LOOK: usize = 10;
/// Sweeping stops if this many sweeps do not halve the change.
const PATIENCE: usize = 2;
/// Most sweeps.
const MOST: usize = 600;

/// One sweep over `shares`; returns the largest relative change.
pub(super) fn sweep(chain: &Chain, shares: &mut [f64]) -> f64 {
    let mut moved = 0.0f64;
    for at in 0..shares.len() {
        let brought: f64 = chain.arriving(at).map(|(from, chance)| shares[from] * chance).sum();
        let (had, due) = (shares[at], brought / chain.leaving(at));
        let has = (1.0 - RELAX) * had + RELAX * due;
        moved = moved.max((has - had).abs() / has);
        shares[at] = has;
    }
    moved
}

/// Sweeps `shares` until the next check of progress.
pub(super) fn some(chain: &Chain, shares: &mut [f64]) {
    for _ in 0..LOOK {
        sweep(chain, shares);
    }
    normalise(shares);
}

/// Sweeps `shares` until it converges; whether it did.
pub(super) fn settle(chain: &Chain, shares: &mut [f64]) -> bool {
    let (mut before, mut slow) = (f64::INFINITY, 0);
    for _ in 0..MOST / LOOK {
        let mut moved = 0.0;
        for _ in 0..LOOK {
            moved = sweep(chain, shares);
            if moved <= STILL {
                normalise(shares);
                return true;
            }
        }
        normalise(shares);
        if moved > before / 2.0 {
            slow += 1;
            if moved < NEARLY_STILL {
                return true;
            }
            if slow >= PATIENCE {
                return false;
            }
        }
        before = moved;
    }
    false
}

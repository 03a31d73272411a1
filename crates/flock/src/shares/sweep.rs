//! Shares by letting every sheep take what the others bring it, again and again.
//!
//! Owns the sweep and when sweeping is given up. Quick where a walk soon forgets where it began, and useless where it
//! does not: a flock of two halves that one bridge joins looks settled long before it is. So it never says that it is
//! right: `proof.rs` does.

use super::chain::{Chain, normalise};

/// How far a sweep goes towards its answer; below 1 so that a ring swept backwards settles too.
const RELAX: f64 = 0.95;
/// A sweep that moves no share by more than this part of it has come to the last bits.
pub(super) const STILL: f64 = 1e-15;
/// Below this it may end by circling among the last bits.
const NEARLY_STILL: f64 = 1e-13;
/// Sweeps between two looks at how it goes.
const LOOK: usize = 10;
/// Sweeping is given up if so many sweeps do not even halve what moves.
const PATIENCE: usize = 2;
/// Most sweeps.
const MOST: usize = 600;

/// One sweep over `shares`; by what part of itself a share was moved, at most.
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

/// Sweeps `shares` as often as there are sweeps between two looks.
pub(super) fn some(chain: &Chain, shares: &mut [f64]) {
    for _ in 0..LOOK {
        sweep(chain, shares);
    }
    normalise(shares);
}

/// Sweeps `shares` until nothing moves; whether it came to that.
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

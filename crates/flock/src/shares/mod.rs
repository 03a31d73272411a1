//! The long-run frequencies of visits and transitions.
//!
//! Owns the stationary distribution of the chances of one strongly connected class, and a proved bound on the error.
//! Wants and clips are handled in `flock/flock_shares.rs`.
//!
//! Start at [`Shares::of`]; `solve.rs` chooses the method, the bound is in `proof.rs`.

mod chain;
mod dense;
#[cfg(test)]
mod exact;
mod parts;
mod proof;
mod reduce;
mod solve;
mod sweep;
#[cfg(test)]
mod tests;

use crate::graph::{Exit, Graph, SheepIx, Structure};
use chain::Chain;

/// The long-run fractions of a walk on one strongly connected class, by the ordinals of its graph.
///
/// A step is one transition and the visit that it leads to. In the long run the walk's visits are the stationary
/// distribution of the chances `p`, whatever steers it: its credits keep `|taken - p * visits|` bounded for ever.
#[derive(Clone, Debug, PartialEq)]
pub struct Shares {
    visits: Vec<f64>,
    taken: Vec<f64>,
    off_by: f64,
}

/// Why a graph has no shares.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SharesError {
    /// The graph is not strongly connected, so the shares depend on the start.
    #[error("the graph has {found} strongly connected classes, shares are defined for one")]
    Classes {
        /// How many there are.
        found: usize,
    },
}

impl Shares {
    /// The largest relative error with which shares count as proved.
    pub const PROVED: f64 = 1e-6;

    /// The shares of the walk on `graph`. A single sheep without exits has all visits.
    ///
    /// Deterministic: the same graph gives the same bits on every machine.
    ///
    /// # Errors
    /// [`SharesError::Classes`] unless every sheep of `graph` can be reached from every other; an empty graph has no class.
    pub fn of(graph: &Graph) -> Result<Self, SharesError> {
        let found = Structure::of(graph).class_count();
        if found != 1 {
            return Err(SharesError::Classes { found });
        }
        let solved = solve::solve(&Chain::of(graph));
        let visits = solved.visits;
        // Of its length from the start: lists that grow leave gaps in memory.
        let mut taken = Vec::with_capacity(graph.exit_count());
        for sheep in graph.sheep() {
            taken.extend(graph.exits(sheep).map(|exit| visits[sheep.index()] * graph.chance(exit)));
        }
        Ok(Self { taken, visits, off_by: solved.off_by })
    }

    /// A few sweeps over `graph`, one class, from `shares`: close to the shares of the graph if the walk mixes fast,
    /// else in between.
    pub(crate) fn swept(graph: &Graph, shares: &[f64]) -> Vec<f64> {
        let mut shares = shares.to_vec();
        sweep::some(&Chain::of(graph), &mut shares);
        shares
    }

    /// The fraction of visits that `sheep` gets; all of them sum to 1.
    pub fn visits(&self, sheep: SheepIx) -> f64 {
        self.visits[sheep.index()]
    }

    /// The fraction of steps that take `exit`; all of them sum to 1.
    pub fn taken(&self, exit: Exit) -> f64 {
        self.taken[exit.index()]
    }

    /// The proved bound on the relative error of any share, rounding included. Infinite if nothing could be proved;
    /// above [`Shares::PROVED`] the shares are only an estimate.
    pub fn off_by(&self) -> f64 {
        self.off_by
    }

    /// The entropy of the visits, in bits; at most `log2 n` for `n` sheep.
    pub fn entropy_bits(&self) -> f64 {
        0.0 - self.visits.iter().filter(|&&share| share > 0.0).map(|share| share * share.log2()).sum::<f64>()
    }
}

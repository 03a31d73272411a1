//! The small map that keeps a pool wide.
//!
//! Owns which niche a sheep is in. Never says what that is worth.
//!
//! Start at [`Niches::of`].

use serde::Serialize;

use crate::traits::Traits;

/// The borders of niches: two figures, each in bins that hold equally many of the sheep that they are made from. A pool
/// takes its sheep without parents for that, alive and dead, so the map stays where chance puts sheep while the pool moves: with
/// borders of the living the niches shrank with the pool, and its diversity after 40 broods was lower by 0.11.
#[derive(Clone, Debug, PartialEq)]
pub struct Niches {
    axes: [usize; 2],
    borders: [Vec<f64>; 2],
}

/// A niche: its bin on either axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Niche([usize; 2]);

impl Niches {
    /// The niches of these sheep: `bins` times `bins` of them.
    pub fn of<'a>(sheep: &(impl Iterator<Item = &'a Traits> + Clone), axes: [usize; 2], bins: usize) -> Niches {
        let borders = axes.map(|axis| {
            let mut values: Vec<f64> = sheep.clone().map(|traits| traits.at(axis)).collect();
            values.sort_unstable_by(f64::total_cmp);
            (1..bins).filter_map(|bin| values.get(bin * values.len() / bins).copied()).collect()
        });
        Niches { axes, borders }
    }

    /// The niche of a sheep.
    pub fn niche(&self, traits: &Traits) -> Niche {
        let bin = |at: usize| self.borders[at].partition_point(|border| *border <= traits.at(self.axes[at]));
        Niche([bin(0), bin(1)])
    }
}

//! Chances that a place in a plant takes.
//!
//! Owns how a seed and a place give numbers: always the same ones, whatever else grows. Between two seeds, every number is
//! between theirs.
//!
//! Start at [`Chance::at`].

use species::Rng;

use crate::vector::between;

/// The seed, or a moment between two of them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Chance {
    seeds: [u64; 2],
    share: f64,
}

/// Numbers of one place, in order.
#[derive(Debug)]
pub(crate) struct Draws {
    streams: [Rng; 2],
    share: f64,
}

impl Chance {
    pub(crate) fn of(seed: u64) -> Chance {
        Chance { seeds: [seed; 2], share: 0.0 }
    }

    /// `share` of the way from one seed to another.
    pub(crate) fn between(seeds: [u64; 2], share: f64) -> Chance {
        Chance { seeds, share: if seeds[0] == seeds[1] { 0.0 } else { share } }
    }

    /// The numbers of a place.
    pub(crate) fn at(&self, place: u64) -> Draws {
        Draws { streams: self.seeds.map(|seed| Rng::stream(seed, place)), share: self.share }
    }
}

impl Draws {
    /// A number in `-1.0..1.0`.
    pub(crate) fn signed(&mut self) -> f64 {
        if self.share == 0.0 {
            return self.streams[0].signed();
        }
        let [from, to] = &mut self.streams;
        between(from.signed(), to.signed(), self.share)
    }
}

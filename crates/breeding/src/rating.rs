//! How much a sheep is liked, beside what was to be expected from its showings.
//!
//! Owns the counts of all units, which are halved with time, and the rating. Never knows who pressed or when in the day.
//!
//! Start at [`Votes::tallies`], then [`Tally::rating`].

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::event::Day;
use crate::id::Id;

/// More halvings leave nothing, and would leave the range of numbers.
const MOST_HALVINGS: f64 = 500.0;

/// What a unit counted of a sheep.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Count {
    /// Showings.
    pub shown: u64,
    /// Votes for it.
    #[serde(default)]
    pub up: u64,
    /// Votes against it.
    #[serde(default)]
    pub down: u64,
}

impl Count {
    /// By how much this is more than `known`, number by number.
    #[must_use]
    pub fn since(self, known: Count) -> Count {
        Count {
            shown: self.shown.saturating_sub(known.shown),
            up: self.up.saturating_sub(known.up),
            down: self.down.saturating_sub(known.down),
        }
    }

    /// The larger of both, number by number.
    #[must_use]
    pub fn larger(self, other: Count) -> Count {
        Count { shown: self.shown.max(other.shown), up: self.up.max(other.up), down: self.down.max(other.down) }
    }
}

/// The votes that a sheep got, and those that its showings let expect.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    /// Votes for it less votes against it.
    pub got: f64,
    /// Expected votes for it.
    pub expected: f64,
}

/// What all units counted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Votes {
    /// The first day; counts are kept as if halving went backwards from it, so that none is touched when days pass.
    first: Option<Day>,
    half_life_days: f64,
    units: BTreeMap<String, Unit>,
}

#[derive(Clone, Debug, Default, PartialEq)]
struct Unit {
    shown: f64,
    up: f64,
    /// Showings, and votes for less votes against, of sheep whose ids are of a pool.
    sheep: BTreeMap<Id, [f64; 2]>,
}

impl Tally {
    /// Votes received as a multiple of those expected, shrunk towards 1, which is average: (1 + got) / (1 + expected), at
    /// least 0. The prior is worth one expected vote.
    pub fn rating(&self) -> f64 {
        ((1.0 + self.got) / (1.0 + self.expected)).max(0.0)
    }

    /// The standard deviation of the rating: sqrt(1 + got) / (1 + expected).
    pub fn uncertainty(&self) -> f64 {
        libm::sqrt(1.0 + self.got.max(0.0)) / (1.0 + self.expected)
    }

    /// Both, added.
    #[must_use]
    pub fn with(self, other: Tally) -> Tally {
        Tally { got: self.got + other.got, expected: self.expected + other.expected }
    }

    /// So many times it.
    #[must_use]
    pub fn times(self, factor: f64) -> Tally {
        Tally { got: self.got * factor, expected: self.expected * factor }
    }
}

impl Votes {
    /// No votes; they will be halved every `half_life_days`.
    pub fn new(half_life_days: f64) -> Votes {
        Votes { first: None, half_life_days, units: BTreeMap::new() }
    }

    /// Adds what `unit` counted until `day` since it was last heard of. An id that is of no pool counts only for how much is
    /// pressed at the unit.
    pub fn add<'a>(&mut self, unit: &str, day: Day, counts: impl IntoIterator<Item = (&'a str, Count)>) {
        let first = *self.first.get_or_insert(day);
        let weight = self.halvings(first, day);
        let unit = self.units.entry(unit.to_owned()).or_default();
        for (id, count) in counts {
            let [shown, up, down] = [count.shown, count.up, count.down].map(|count| count as f64 * weight);
            unit.shown += shown;
            unit.up += up;
            if let Ok(id) = id.parse() {
                let sums = unit.sheep.entry(id).or_default();
                sums[0] += shown;
                sums[1] += up - down;
            }
        }
    }

    /// What every sheep that was shown got and let expect, as of `today`: showings at a unit let expect as many votes as
    /// showings there bring on average, so where somebody presses all day only differences count.
    ///
    /// # Source
    /// Indirect standardisation, as of mortality ratios.
    pub fn tallies(&self, today: Day) -> BTreeMap<Id, Tally> {
        let weight = self.first.map_or(1.0, |first| 1.0 / self.halvings(first, today));
        let mut tallies: BTreeMap<Id, Tally> = BTreeMap::new();
        for unit in self.units.values() {
            let votes_per_showing = (unit.up * weight + 0.5) / (unit.shown * weight + 1.0);
            for (id, [shown, got]) in &unit.sheep {
                let tally = Tally { got: got * weight, expected: shown * weight * votes_per_showing };
                let sum = tallies.entry(*id).or_default();
                *sum = sum.with(tally);
            }
        }
        tallies
    }

    /// How much more a vote of `day` weighs than one of `first`.
    fn halvings(&self, first: Day, day: Day) -> f64 {
        libm::exp2(((f64::from(day.0) - f64::from(first.0)) / self.half_life_days).clamp(-MOST_HALVINGS, MOST_HALVINGS))
    }
}

//! What is known of all sheep at the moment of a decision.
//!
//! Owns the snapshot that a brood is made from: ratings, normalised figures, niches. It is frozen, so that no birth changes
//! what another one sees. Never decides.
//!
//! Start at [`Census::of`].

use std::collections::BTreeMap;

use crate::event::{Day, Mark};
use crate::id::Id;
use crate::niches::{Niche, Niches};
use crate::pool::{Pool, Sheep};
use crate::rating::Tally;
use crate::traits::{Point, Scale, Traits};

/// What *keep* counts as: three votes where one was expected.
const KEPT: Tally = Tally { got: 3.0, expected: 1.0 };
/// What *reject* counts as in screening: none where one was expected.
const REJECTED: Tally = Tally { got: 0.0, expected: 1.0 };

/// Sheep with fewer expected votes are not judged: they neither have children nor die.
///
/// # Source
/// Our simulation: with the 0.5 that was planned, a pool shown ten times between two broods has no parents for its first
/// brood, and after ten broods its mean percentile is lower by 0.02.
pub(crate) const JUDGED: f64 = 0.3;

/// The snapshot.
#[derive(Clone, Debug)]
pub struct Census {
    audience: BTreeMap<Id, Tally>,
    scale: Scale,
    niches: Niches,
}

impl Census {
    /// The snapshot of a pool on a day.
    pub fn of(pool: &Pool, day: Day) -> Census {
        let living = pool.living().map(|sheep| &sheep.born.figures);
        let founders = pool.sheep().filter(|sheep| sheep.born.parents.is_empty()).map(|sheep| &sheep.born.figures);
        let settings = &pool.settings;
        Census {
            audience: pool.votes().tallies(day),
            scale: Scale::of(&living),
            niches: Niches::of(&founders, settings.axes(), settings.bins),
        }
    }

    /// What a sheep got and was expected to get, with the artist's *keep*.
    pub fn tally(&self, sheep: &Sheep) -> Tally {
        let audience = self.audience(sheep);
        if sheep.is_pinned() { audience.with(KEPT) } else { audience }
    }

    /// The same for screening, where the artist's marks have a share of their own.
    pub(crate) fn liking(&self, sheep: &Sheep, artist_share: f64) -> Tally {
        let artist = match sheep.mark {
            Mark::Keep => KEPT,
            Mark::None => Tally::default(),
            Mark::Reject => REJECTED,
        };
        self.audience(sheep).times(1.0 - artist_share).with(artist.times(artist_share))
    }

    fn audience(&self, sheep: &Sheep) -> Tally {
        self.audience.get(&sheep.born.id).copied().unwrap_or_default()
    }

    /// The rating of a sheep: 1 is average.
    pub fn rating(&self, sheep: &Sheep) -> f64 {
        self.tally(sheep).rating()
    }

    /// Whether enough is known of a sheep to let it have children, or die.
    pub fn is_judged(&self, sheep: &Sheep) -> bool {
        is_judged(self.tally(sheep))
    }

    /// Its niche.
    pub fn niche(&self, sheep: &Sheep) -> Niche {
        self.niches.niche(&sheep.born.figures)
    }

    /// Its normalised figures.
    pub fn point(&self, figures: &Traits) -> Point {
        self.scale.point(figures)
    }
}

pub(crate) fn is_judged(tally: Tally) -> bool {
    tally.expected >= JUDGED
}

//! An edition: the sheep of a pool that a unit gets.
//!
//! Owns the choice and its limits. Never writes a flock.
//!
//! Start at [`elect`].

use std::collections::{BTreeMap, BTreeSet};

use crate::census::Census;
use crate::id::Id;
use crate::niches::Niche;
use crate::pool::{Pool, Sheep};
use crate::screening::{likeness, width};
use crate::traits::Point;

/// The most sheep of a niche.
pub(crate) const MOST_OF_NICHE: usize = 4;
/// The largest part that is of one founding family, and the least that are newcomers.
pub(crate) const MOST_OF_FAMILY: f64 = 0.15;
pub(crate) const LEAST_NEWCOMERS: f64 = 0.1;
/// A sheep with fewer expected votes is a newcomer.
pub(crate) const NEWCOMER: f64 = 2.0;
/// What the likeness to a chosen sheep takes from a rating: this part at most.
pub(crate) const LIKENESS: f64 = 0.5;

/// What is asked of an edition.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ballot {
    /// Its name: the unit that it is for. The last edition of the same name does not count as another's.
    pub edition: String,
    /// How many sheep.
    pub sheep: usize,
    /// How many of them, the last ones, are in no other edition, and in no later one, unless the artist keeps them. Fewer if
    /// the artist keeps more than the others.
    pub unique: usize,
}

/// Why a sheep was chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// The artist keeps it.
    Pinned,
    /// It was the best of all that were left, or of the newcomers, if too few of them were in.
    Rated,
    /// It was the best of those that no other edition has.
    Unique,
}

/// A sheep of the edition.
#[derive(Clone, Debug, PartialEq)]
pub struct Elected {
    /// Which.
    pub id: Id,
    /// Why.
    pub reason: Reason,
    /// Its rating.
    pub rating: f64,
    /// The rating less what its likeness to the ones before took.
    pub worth: f64,
}

struct Candidate<'a> {
    sheep: &'a Sheep,
    point: Point,
    niche: Niche,
    rating: f64,
    is_newcomer: bool,
    is_elsewhere: bool,
    likeness: f64,
}

/// Chooses an edition: first what the artist keeps, then step by step the sheep with the largest rating * (1 - 0.5 *
/// likeness to the nearest one chosen). Of a niche there are at most 4, of a founding family at most 15 % (but for those
/// that are kept), and at least 10 % are newcomers, if there are so many. It has fewer sheep than asked for if no others
/// are within the limits.
pub fn elect(pool: &Pool, census: &Census, ballot: &Ballot) -> Vec<Elected> {
    let mut election = Election::of(pool, census, ballot);
    let shared = ballot.sheep - ballot.unique.min(ballot.sheep);
    let newcomers = (ballot.sheep as f64 * LEAST_NEWCOMERS).ceil() as usize;
    for (goal, reason) in [(ballot.sheep, Reason::Pinned), (shared, Reason::Rated), (ballot.sheep, Reason::Unique)] {
        while election.chosen.len() < goal {
            // The last places are kept for the newcomers that are missing still.
            let missing = newcomers.saturating_sub(election.newcomers);
            let is_tight = reason != Reason::Pinned && goal - election.chosen.len() <= missing;
            if !(is_tight && election.step(reason, true) || election.step(reason, false)) {
                break;
            }
        }
    }
    election.chosen
}

struct Election<'a> {
    left: Vec<Candidate<'a>>,
    chosen: Vec<Elected>,
    niches: BTreeMap<Niche, usize>,
    families: BTreeMap<Id, usize>,
    most_of_family: usize,
    newcomers: usize,
    width: f64,
}

impl<'a> Election<'a> {
    fn of(pool: &'a Pool, census: &Census, ballot: &Ballot) -> Self {
        let others = || pool.editions().filter(|(name, _)| *name != ballot.edition).map(|(_, edition)| edition);
        let elsewhere: BTreeSet<Id> = others().flat_map(|edition| edition.ids.iter().copied()).collect();
        let reserved: BTreeSet<Id> = others().flat_map(|edition| edition.unique().iter().copied()).collect();
        let candidate = |sheep: &'a Sheep| Candidate {
            sheep,
            point: census.point(&sheep.born.figures),
            niche: census.niche(sheep),
            rating: census.rating(sheep),
            is_newcomer: census.tally(sheep).expected < NEWCOMER,
            is_elsewhere: elsewhere.contains(&sheep.born.id),
            likeness: 0.0,
        };
        let left: Vec<Candidate> = pool
            .living()
            .filter(|sheep| sheep.is_pinned() || !reserved.contains(&sheep.born.id))
            .map(candidate)
            .collect();
        let width = width(&left.iter().map(|candidate| &candidate.point).collect::<Vec<_>>());
        let most_of_family = ((ballot.sheep as f64 * MOST_OF_FAMILY) as usize).max(1);
        let (niches, families) = (BTreeMap::new(), BTreeMap::new());
        Election { left, chosen: Vec::new(), niches, families, most_of_family, newcomers: 0, width }
    }

    fn may(&self, candidate: &Candidate, reason: Reason, only_newcomers: bool) -> bool {
        let count = |count: Option<&usize>| count.copied().unwrap_or(0);
        let is_within = count(self.niches.get(&candidate.niche)) < MOST_OF_NICHE
            && count(self.families.get(&candidate.sheep.family)) < self.most_of_family;
        let suits = match reason {
            Reason::Pinned => candidate.sheep.is_pinned(),
            Reason::Rated => is_within,
            Reason::Unique => is_within && !candidate.is_elsewhere,
        };
        suits && (candidate.is_newcomer || !only_newcomers)
    }

    /// Chooses one more; whether there was one.
    fn step(&mut self, reason: Reason, only_newcomers: bool) -> bool {
        let worth = |candidate: &Candidate| candidate.rating * (1.0 - LIKENESS * candidate.likeness);
        let may = (0..self.left.len()).filter(|at| self.may(&self.left[*at], reason, only_newcomers));
        let best = may.reduce(|best, next| if worth(&self.left[next]) > worth(&self.left[best]) { next } else { best });
        let Some(best) = best else { return false };
        let taken = self.left.remove(best);
        *self.niches.entry(taken.niche).or_default() += 1;
        *self.families.entry(taken.sheep.family).or_default() += 1;
        self.newcomers += usize::from(taken.is_newcomer);
        let id = taken.sheep.born.id;
        for other in &mut self.left {
            let likeness = if self.width > 0.0 { likeness(&other.point, &taken.point, self.width) } else { 0.0 };
            other.likeness = other.likeness.max(likeness);
        }
        let (rating, worth) = (taken.rating, worth(&taken));
        self.chosen.push(Elected { id, reason, rating, worth });
        true
    }
}

//! Who dies when a pool has too many.
//!
//! Owns the choice. Nothing dies for good: genomes, lineage and votes stay. Never kills: the ledger is told.
//!
//! Start at [`deaths`].

use std::collections::{BTreeMap, BTreeSet};

use crate::births::Plan;
use crate::census::Census;
use crate::event::{Entry, Event, Stamp};
use crate::id::Id;
use crate::niches::Niche;
use crate::pool::{Pool, Sheep};

/// Sheep that are younger, in broods, do not die.
pub(crate) const YOUNG: u32 = 2;
/// The best of a niche does not die while its rating is above this.
pub(crate) const GOOD: f64 = 0.8;
/// What every sheep of its niche, itself among them, takes from a sheep's worth.
///
/// # Source
/// Our simulation: 0.04 was planned, with which diversity after 40 broods was lower by 0.03, at the same taste.
pub(crate) const CROWD: f64 = 0.1;

/// Who dies, the first first, and how many more live than the settings say because the others may not die.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Deaths {
    /// Who dies.
    pub ids: Vec<Id>,
    /// How many live beyond the limit.
    pub beyond: usize,
}

/// A sheep that may die.
struct Mortal<'a> {
    sheep: &'a Sheep,
    niche: Niche,
    /// The rating and half its uncertainty.
    worth: f64,
}

/// Who dies of a pool in which the births of the last brood are: a function of the pool and the census. A sheep does not die
/// that is kept, in an edition, young or not judged, nor the best of a niche. Of the others the one of least worth dies,
/// until as many live as the settings say; the oldest among equals.
pub fn deaths(pool: &Pool, census: &Census) -> Deaths {
    deaths_beside(pool, census, 0)
}

/// Who is likely to die when the births of `plan` have taken place. As many die if all of them do; which ones is a guess,
/// since nobody knows yet in which niches the newborn will be.
///
/// # Panics
/// A plan of another pool has rebirths of sheep that are not there.
pub fn foreseen(pool: &Pool, plan: &Plan) -> Deaths {
    let mut after = pool.clone();
    let stamp = Stamp { number: u64::MAX, pool: pool.settings.origin };
    let brood = Event::Brood { brood: plan.brood, seed: plan.seed };
    let reborn = plan.reborn.iter().map(|id| Event::Reborn { id: *id });
    for event in std::iter::once(brood).chain(reborn) {
        let entry = Entry { stamp, day: pool.last_day(), event };
        after.apply(&entry).expect("a plan's rebirths are of the dead of its pool");
    }
    deaths_beside(&after, &Census::of(&after, after.last_day()), plan.births.len())
}

/// Who dies beside so many newborn that the pool does not have yet, none of whom may die.
fn deaths_beside(pool: &Pool, census: &Census, newborn: usize) -> Deaths {
    let living = pool.living().count() + newborn;
    let too_many = living.saturating_sub(pool.settings.limit);
    let elected: BTreeSet<Id> = pool.editions().flat_map(|(_, edition)| edition.ids.iter().copied()).collect();
    let has_bins = pool.settings.bins > 1;
    let mut crowds: BTreeMap<Niche, usize> = BTreeMap::new();
    let mut best: BTreeMap<Niche, (f64, Id)> = BTreeMap::new();
    let mut mortals = Vec::new();
    for sheep in pool.living() {
        let (niche, tally) = (census.niche(sheep), census.tally(sheep));
        let rating = tally.rating();
        *crowds.entry(niche).or_default() += 1;
        let id = sheep.born.id;
        let is_judged = census.is_judged(sheep);
        if has_bins && is_judged && rating > GOOD && best.get(&niche).is_none_or(|(most, _)| rating > *most) {
            best.insert(niche, (rating, id));
        }
        let is_young = pool.broods() - sheep.since < YOUNG;
        if is_judged && !sheep.is_pinned() && !is_young && !elected.contains(&id) {
            mortals.push(Mortal { sheep, niche, worth: rating + tally.uncertainty() / 2.0 });
        }
    }
    mortals.retain(|mortal| best.get(&mortal.niche).is_none_or(|(_, id)| *id != mortal.sheep.born.id));
    let mut ids = Vec::new();
    while ids.len() < too_many && !mortals.is_empty() {
        let worth =
            |mortal: &Mortal| mortal.worth - CROWD * crowds.get(&mortal.niche).map_or(0.0, |count| *count as f64);
        let order = |a: &Mortal, b: &Mortal| {
            worth(a)
                .total_cmp(&worth(b))
                .then(a.sheep.since.cmp(&b.sheep.since))
                .then(a.sheep.born.id.cmp(&b.sheep.born.id))
        };
        let Some(least) = (0..mortals.len()).min_by(|a, b| order(&mortals[*a], &mortals[*b])) else { break };
        let dead = mortals.swap_remove(least);
        crowds.entry(dead.niche).and_modify(|count| *count -= 1);
        ids.push(dead.sheep.born.id);
    }
    Deaths { beyond: too_many - ids.len(), ids }
}

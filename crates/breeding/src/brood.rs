//! A brood: births that are planned, made, judged by their figures, and told to the ledger.
//!
//! Owns the order of these steps, and what makes them the same on any number of threads. Never knows a genome: a [`Nursery`]
//! does, which makes candidates and tells their figures.
//!
//! Start at [`breed`].

use std::collections::BTreeMap;

use rayon::iter::{IntoParallelIterator, ParallelIterator};
use species::Rng;

use crate::births::{Birth, Order, Plan, plan};
use crate::census::Census;
use crate::event::{Born, Event};
use crate::id::Id;
use crate::lookalikes::{CLONE, Lookalikes};
use crate::pool::Pool;
use crate::screening::Liking;
use crate::traits::Traits;

/// Candidates that may be refused in a row; then the birth does not take place.
pub(crate) const TRIES: usize = 20;

/// What is wrong with parents that have no child.
const BARREN: &str = "no child";

/// What makes candidates, and looks at them. All three are called on many threads at once.
pub trait Nursery: Sync {
    /// A genome that may be born.
    type Candidate: Send + Sync;

    /// A candidate for a birth: the genome that waits for it, if there is one. `None` if these parents have no child that can
    /// be drawn.
    fn candidate(&self, birth: &Birth, rng: &mut Rng) -> Option<Made<Self::Candidate>>;

    /// Its figures, from few samples: while candidates are screened.
    ///
    /// # Errors
    /// What is wrong with it, in a word each.
    fn sketch(&self, candidate: &Self::Candidate) -> Result<Traits, Vec<String>> {
        self.figures(candidate)
    }

    /// Its figures.
    ///
    /// # Errors
    /// What is wrong with it, in a word each: nobody is to see it.
    fn figures(&self, candidate: &Self::Candidate) -> Result<Traits, Vec<String>>;
}

/// A candidate, with what its birth will be told as.
#[derive(Clone, Debug)]
pub struct Made<C> {
    /// The genome.
    pub candidate: C,
    /// How it was made.
    pub operator: String,
    /// Its licence.
    pub licence: String,
}

/// What came of a plan.
#[derive(Clone, Debug)]
pub struct Brood<C> {
    /// Its number.
    pub brood: u32,
    /// The seed of all of it.
    pub seed: u64,
    /// The births, with the genomes.
    pub born: Vec<(Born, C)>,
    /// The dead that live again.
    pub reborn: Vec<Id>,
    /// Births that did not take place, because every candidate was refused.
    pub missing: usize,
    /// Candidates that were refused.
    pub refused: Vec<Refused<C>>,
}

/// A candidate that nobody is to see.
#[derive(Clone, Debug)]
pub struct Refused<C> {
    /// The genome; `None` if the parents had no child.
    pub candidate: Option<C>,
    /// What is wrong with it, in a word each.
    pub faults: Vec<String>,
}

impl<C> Brood<C> {
    /// What the ledger is told. The genomes must be on the disk before.
    pub fn events(&self) -> Vec<Event> {
        let mut events = vec![Event::Brood { brood: self.brood, seed: self.seed }];
        events.extend(self.born.iter().map(|(born, _)| Event::Born(born.clone())));
        events.extend(self.reborn.iter().map(|id| Event::Reborn { id: *id }));
        events
    }

    /// What was wrong with refused candidates, and with how many.
    pub fn faults(&self) -> BTreeMap<String, usize> {
        let mut faults = BTreeMap::new();
        for fault in self.refused.iter().flat_map(|refused| &refused.faults) {
            *faults.entry(fault.clone()).or_insert(0) += 1;
        }
        faults
    }
}

/// The next brood of a pool. It is the same on any number of threads: rayon's current pool is used.
pub fn breed<N: Nursery>(pool: &Pool, census: &Census, order: &Order, nursery: &N) -> Brood<N::Candidate> {
    let Plan { brood, seed, births, reborn } = plan(pool, census, order);
    let liking = Liking::of(pool, census);
    let living = Lookalikes::of(pool);
    let mut siblings = living.emptied();
    let cradle = Cradle { nursery, census, liking, living };
    let mut refused = Vec::new();
    let planned = births.len();
    let (brought, births): (Vec<Birth>, Vec<Birth>) = births.into_iter().partition(|birth| birth.waited.is_some());
    let mut accepted: BTreeMap<usize, (Birth, Accepted<N::Candidate>)> = BTreeMap::new();
    accepted.extend(brought.into_iter().filter_map(|birth| Some((birth.index, cradle.brought_in(pool, birth)?))));
    for (birth, found) in accepted.values() {
        siblings.add(&birth.species, &found.figures);
    }
    let mut open: Vec<Trial<N::Candidate>> = births.into_iter().map(Trial::new).collect();
    // What is too like a sibling of a lower number is made again, with the siblings known: rounds, until all are settled.
    while !open.is_empty() {
        let tried: Vec<_> = open.into_par_iter().map(|trial| cradle.next(trial)).collect();
        open = Vec::new();
        for (mut trial, found) in tried {
            refused.append(&mut trial.refused);
            let Some(found) = found else { continue };
            if siblings.have(&trial.birth.species, &found.figures) {
                trial.refuse(Some(found.made.candidate), vec![CLONE.to_owned()]);
                open.push(trial);
            } else {
                siblings.add(&trial.birth.species, &found.figures);
                accepted.insert(trial.birth.index, (trial.birth, found));
            }
        }
    }
    let first = pool.next_serial();
    let missing = planned - accepted.len();
    let born = |(serial, (birth, found)): (u32, (Birth, Accepted<N::Candidate>))| {
        let id = Id { brood, serial, origin: pool.settings.origin };
        (found.born(id, birth), found.made.candidate)
    };
    let born = (first..).zip(accepted.into_values()).map(born).collect();
    Brood { brood, seed, born, reborn, missing, refused }
}

/// A birth that is being tried.
struct Trial<C> {
    birth: Birth,
    rng: Rng,
    tries: usize,
    refused: Vec<Refused<C>>,
}

impl<C> Trial<C> {
    fn new(birth: Birth) -> Trial<C> {
        Trial { rng: Rng::stream(birth.seed, 0), birth, tries: 0, refused: Vec::new() }
    }

    fn refuse(&mut self, candidate: Option<C>, faults: Vec<String>) {
        self.refused.push(Refused { candidate, faults });
    }
}

/// A candidate that may be shown.
struct Accepted<C> {
    made: Made<C>,
    figures: Traits,
}

impl<C> Accepted<C> {
    fn born(&self, id: Id, birth: Birth) -> Born {
        Born {
            id,
            parents: birth.parents,
            operator: self.made.operator.clone(),
            seed: birth.seed,
            species: birth.species,
            figures: self.figures.clone(),
            licence: self.made.licence.clone(),
            strength: (birth.strength * 1e6).round() / 1e6,
            waited: birth.waited,
        }
    }
}

/// What all births of a brood see.
struct Cradle<'a, N: Nursery> {
    nursery: &'a N,
    census: &'a Census,
    liking: Option<Liking>,
    living: Lookalikes,
}

impl<N: Nursery> Cradle<'_, N> {
    /// A genome that waited for its birth. Whatever it looks like, the artist chose it. `None` if it is not there: it waits on
    /// then.
    fn brought_in(&self, pool: &Pool, birth: Birth) -> Option<(Birth, Accepted<N::Candidate>)> {
        let (_, waiting) = pool.waiting().find(|(since, _)| Some(*since) == birth.waited)?;
        let made = self.nursery.candidate(&birth, &mut Rng::stream(birth.seed, 0))?;
        Some((birth, Accepted { made, figures: waiting.figures.clone() }))
    }

    /// Tries until a candidate is accepted, or too many were refused.
    fn next(&self, mut trial: Trial<N::Candidate>) -> (Trial<N::Candidate>, Option<Accepted<N::Candidate>>) {
        while trial.tries < TRIES {
            trial.tries += 1;
            let Some(made) = self.best(&mut trial) else { continue };
            match self.nursery.figures(&made.candidate) {
                Err(faults) => trial.refuse(Some(made.candidate), faults),
                Ok(figures) => {
                    if !self.living.have(&trial.birth.species, &figures) {
                        return (trial, Some(Accepted { made, figures }));
                    }
                    trial.refuse(Some(made.candidate), vec![CLONE.to_owned()]);
                }
            }
        }
        (trial, None)
    }

    /// A candidate; of a screened birth the one of which most is to be expected. Those that a sketch shows to be wrong are
    /// left out.
    fn best(&self, trial: &mut Trial<N::Candidate>) -> Option<Made<N::Candidate>> {
        let screening = self.liking.as_ref().filter(|_| trial.birth.candidates > 1);
        let barren = || vec![BARREN.to_owned()];
        let Some(liking) = screening else {
            let made = self.nursery.candidate(&trial.birth, &mut trial.rng);
            if made.is_none() {
                trial.refuse(None, barren());
            }
            return made;
        };
        let mut best: Option<(f64, Made<N::Candidate>)> = None;
        let mut refused = Vec::new();
        for _ in 0..trial.birth.candidates {
            let Some(made) = self.nursery.candidate(&trial.birth, &mut trial.rng) else { continue };
            match self.nursery.sketch(&made.candidate) {
                Err(faults) => refused.push(Refused { candidate: Some(made.candidate), faults }),
                Ok(figures) => {
                    let guess = liking.guess(&self.census.point(&figures));
                    if best.as_ref().is_none_or(|(most, _)| guess > *most) {
                        best = Some((guess, made));
                    }
                }
            }
        }
        if best.is_none() && refused.is_empty() {
            trial.refuse(None, barren());
        }
        if best.is_none() {
            trial.refused.append(&mut refused);
        }
        best.map(|(_, made)| made)
    }
}

//! Which births a brood has, and of which parents.
//!
//! Owns the plan of a brood: kinds of births, tournaments among parents, which births are screened; and that genomes which
//! wait are the first strangers. Never makes a genome.
//!
//! Start at [`plan`].

use std::collections::BTreeMap;

use species::Rng;

use crate::census::Census;
use crate::chance::{PLAN, birth_seed};
use crate::event::Stamp;
use crate::id::Id;
use crate::pool::{Pool, Sheep};

/// Sheep that compete to be a parent.
pub(crate) const TOURNAMENT: usize = 3;
/// The part of a brood's births in which one sheep may be a parent: 4 of 20.
pub(crate) const MOST_CHILDREN: f64 = 0.2;
/// With fewer sheep that may be parents, there are strangers instead.
pub(crate) const LEAST_PARENTS: usize = 3;
/// Dead sheep of which more is known are not born again.
pub(crate) const UNKNOWN: f64 = 2.0;
/// The standard deviation of the logarithm of a child's strength beside its parents', and the limits of strengths.
const DRIFT: f64 = 0.2;
const STRENGTHS: [f64; 2] = [0.25, 4.0];

/// How a sheep is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operation {
    /// Of two parents.
    Cross,
    /// Of one parent.
    Mutation,
    /// Of none: by chance, or brought in by the artist.
    Stranger,
}

/// What the artist asks of a brood, beside the settings.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Order {
    /// How many births.
    pub births: Option<usize>,
    /// The parents of all of them: one or two. Whether they are judged is not asked then.
    pub parents: Vec<Id>,
    /// How all of them are made.
    pub operation: Option<Operation>,
    /// Another seed than that of the pool.
    pub seed: Option<u64>,
    /// Candidates of a screened birth.
    pub screening: Option<usize>,
    /// By how much every mutation is stronger.
    pub strength: Option<f64>,
}

/// A birth that is to be.
#[derive(Clone, Debug, PartialEq)]
pub struct Birth {
    /// Its number in the brood.
    pub index: usize,
    /// How the sheep is made.
    pub operation: Operation,
    /// As many parents as that takes.
    pub parents: Vec<Id>,
    /// Its species.
    pub species: String,
    /// The strength that it will have itself: its parents', changed a little.
    pub strength: f64,
    /// The strength with which it is made.
    pub amount: f64,
    /// How many candidates it is the best guess of.
    pub candidates: usize,
    /// The seed of its random numbers.
    pub seed: u64,
    /// The event since which its genome waits, of a stranger that the artist brought in.
    pub waited: Option<Stamp>,
}

/// The plan of a brood.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The brood's number.
    pub brood: u32,
    /// The seed of all of it.
    pub seed: u64,
    /// The births.
    pub births: Vec<Birth>,
    /// The dead that live again.
    pub reborn: Vec<Id>,
}

/// The plan of the next brood: a function of the pool, the census and the order.
pub fn plan(pool: &Pool, census: &Census, order: &Order) -> Plan {
    let brood = pool.next_brood();
    let seed = crate::chance::brood_seed(order.seed.unwrap_or(pool.settings.seed), brood);
    let mut rng = Rng::stream(seed, PLAN);
    let count = order.births.unwrap_or(pool.settings.births);
    let mut operations = operations(pool, order, count);
    rng.shuffle(&mut operations);
    // Whoever names parents or an operator wants their children, and nobody else.
    let is_named = !order.parents.is_empty() || order.operation.is_some();
    let reborn = if is_named { Vec::new() } else { reborn(pool, census, count, &mut rng) };
    operations.truncate(count.saturating_sub(reborn.len()));
    let screened = (operations.len() as f64 * pool.settings.screened).round() as usize;
    let mut is_screened: Vec<bool> = (0..operations.len()).map(|index| index < screened).collect();
    rng.shuffle(&mut is_screened);
    let mut parents = Parents::of(pool, census, order, count);
    let mut births = Vec::with_capacity(operations.len());
    for (index, operation) in operations.into_iter().enumerate() {
        let candidates = if is_screened[index] { order.screening.unwrap_or(pool.settings.screening) } else { 1 };
        let mut birth = parents.birth(pool, operation, &mut rng);
        birth.strength = birth.strength.clamp(STRENGTHS[0], STRENGTHS[1]);
        birth.amount = birth.strength * order.strength.unwrap_or(1.0);
        births.push(Birth { index, candidates, seed: birth_seed(seed, index), ..birth });
    }
    // Without these the other births would be the same.
    let strangers = births.iter_mut().filter(|birth| birth.operation == Operation::Stranger);
    for (stranger, (since, waiting)) in strangers.zip(pool.waiting()) {
        (stranger.species, stranger.candidates, stranger.waited) = (waiting.species.clone(), 1, Some(since));
    }
    Plan { brood, seed, births, reborn }
}

fn operations(pool: &Pool, order: &Order, count: usize) -> Vec<Operation> {
    let given = match order.parents.len() {
        0 => None,
        1 => Some(Operation::Mutation),
        _ => Some(Operation::Cross),
    };
    if let Some(operation) = order.operation.or(given) {
        return vec![operation; count];
    }
    let part = |part: f64| (part * count as f64).round() as usize;
    let (crossings, mutations) = (part(pool.settings.crossings), part(pool.settings.mutations));
    let operation = |index: usize| match index {
        _ if index < crossings => Operation::Cross,
        _ if index < crossings + mutations => Operation::Mutation,
        _ => Operation::Stranger,
    };
    (0..count).map(operation).collect()
}

/// The dead that live again: the less is known of one, the likelier.
fn reborn(pool: &Pool, census: &Census, count: usize, rng: &mut Rng) -> Vec<Id> {
    let is_unknown = |sheep: &&Sheep| census.tally(sheep).expected < UNKNOWN && sheep.mark != crate::Mark::Reject;
    let mut dead: Vec<&Sheep> = pool.dead().into_iter().filter(is_unknown).collect();
    let mut found = Vec::new();
    for _ in 0..(count as f64 * pool.settings.rebirths).round() as usize {
        let weights: Vec<f64> = dead.iter().map(|sheep| census.tally(sheep).uncertainty()).collect();
        let Some(drawn) = rng.weighted(&weights) else { break };
        found.push(dead.remove(drawn).born.id);
    }
    found
}

/// Those that may be parents.
struct Parents<'a> {
    census: &'a Census,
    sheep: Vec<&'a Sheep>,
    /// Parents that the artist named, who have no limit.
    are_named: bool,
    children: BTreeMap<Id, usize>,
    most: usize,
}

impl<'a> Parents<'a> {
    fn of(pool: &'a Pool, census: &'a Census, order: &Order, count: usize) -> Self {
        let may = |sheep: &&Sheep| {
            (census.is_judged(sheep) || sheep.is_pinned()) && pool.settings.licence.allows(&sheep.born.licence)
        };
        let named: Vec<&Sheep> = order.parents.iter().filter_map(|id| pool.get(*id)).collect();
        let are_named = !order.parents.is_empty();
        let sheep = if are_named { named } else { pool.living().filter(may).collect() };
        let most = ((count as f64 * MOST_CHILDREN).ceil() as usize).max(1);
        Parents { census, sheep, are_named, children: BTreeMap::new(), most }
    }

    /// A birth with its parents and its strength. Where parents are missing it is one that needs fewer.
    fn birth(&mut self, pool: &Pool, operation: Operation, rng: &mut Rng) -> Birth {
        let parents = match operation {
            Operation::Stranger => Vec::new(),
            _ if self.are_named => self.sheep.clone(),
            _ if self.sheep.len() < LEAST_PARENTS => Vec::new(),
            Operation::Mutation => self.first(rng).into_iter().collect(),
            Operation::Cross => self.two(rng),
        };
        let operation = match parents.len() {
            0 => Operation::Stranger,
            1 => Operation::Mutation,
            _ => operation,
        };
        for parent in &parents {
            *self.children.entry(parent.born.id).or_default() += 1;
        }
        let logs: f64 =
            parents.iter().map(|parent| libm::log(parent.born.strength.clamp(STRENGTHS[0], STRENGTHS[1]))).sum();
        let inherited = libm::exp(logs / parents.len().max(1) as f64);
        let species = match parents.first() {
            Some(parent) => parent.born.species.clone(),
            None => pool.settings.species[rng.below(pool.settings.species.len())].clone(),
        };
        Birth {
            index: 0,
            operation,
            parents: parents.iter().map(|parent| parent.born.id).collect(),
            species,
            strength: if parents.is_empty() { 1.0 } else { inherited * libm::exp(DRIFT * rng.gaussian()) },
            amount: 1.0,
            candidates: 1,
            seed: 0,
            waited: None,
        }
    }

    fn first(&self, rng: &mut Rng) -> Option<&'a Sheep> {
        self.tournament(|_| true, rng)
    }

    /// Two parents of one species; the second is drawn again once if it is of the first one's niche.
    fn two(&self, rng: &mut Rng) -> Vec<&'a Sheep> {
        let Some(first) = self.first(rng) else { return Vec::new() };
        let suits = |sheep: &Sheep| sheep.born.species == first.born.species && sheep.born.id != first.born.id;
        let mut second = self.tournament(suits, rng);
        if second.is_some_and(|second| self.census.niche(second) == self.census.niche(first)) {
            second = self.tournament(suits, rng);
        }
        [Some(first), second].into_iter().flatten().collect()
    }

    /// The best rated of three that are drawn.
    fn tournament(&self, suits: impl Fn(&Sheep) -> bool, rng: &mut Rng) -> Option<&'a Sheep> {
        let is_free = |sheep: &Sheep| self.children.get(&sheep.born.id).is_none_or(|children| *children < self.most);
        let all: Vec<&Sheep> = self.sheep.iter().copied().filter(|sheep| is_free(sheep) && suits(sheep)).collect();
        if all.is_empty() {
            return None;
        }
        let drawn: [&Sheep; TOURNAMENT] = std::array::from_fn(|_| all[rng.below(all.len())]);
        drawn
            .into_iter()
            .reduce(|best, next| if self.census.rating(next) > self.census.rating(best) { next } else { best })
    }
}

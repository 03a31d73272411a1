//! Voters with a hidden taste, and what rules make of a pool that they see.
//!
//! Owns the trial: a pool of 100 random sheep, of which every living one is shown so many times between two broods, and
//! voted for with a probability that grows with the taste. The pool is bred by the rules of this package, not by a copy of
//! them; beside them by those of Electric Sheep. Never sees a picture.
//!
//! Start at [`Trial::run`].

mod electric;
mod outcome;
mod world;

use breeding::{
    Born, Census, Count, Day, Entry, Event, Id, Order, Origin, Pool, Settings, Stamp, Traits, breed, deaths,
};
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use species::Rng;

pub(crate) use outcome::{Course, Outcome};
pub(crate) use world::{Genes, Meadow, World};

/// Sheep of a pool.
const SHEEP: usize = 100;
/// The last brood.
const BROODS: usize = 40;
/// The unit that shows the pool.
const UNIT: &str = "wall";
/// The chance of a vote for what nobody likes, and how much more it is for what is liked most.
const LEAST_VOTES: f64 = 0.01;
const TASTED_VOTES: f64 = 0.1;
/// The chance of a vote where there is no taste: the mean of the others.
const CHANCE_VOTES: f64 = 0.033;
/// Showings of one unit in a day: every clip is a minute and a half.
const SHOWINGS_A_DAY: u64 = 640;

/// The rules under trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rules {
    /// Ours, with votes that follow no taste.
    Chance,
    /// Votes are counted and forgotten, the lowest count dies.
    Electric,
    /// Ours without niches and without screening.
    Rates,
    /// Ours.
    Ours,
}

/// A trial of rules.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Trial {
    /// The rules.
    pub(crate) rules: Rules,
    /// How often every living sheep is shown between two broods.
    pub(crate) showings: u64,
}

impl Rules {
    /// All of them.
    pub(crate) const ALL: [Rules; 4] = [Rules::Chance, Rules::Electric, Rules::Rates, Rules::Ours];

    /// Their name.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Rules::Chance => "votes by chance",
            Rules::Electric => "Electric Sheep's",
            Rules::Rates => "rates only",
            Rules::Ours => "ours",
        }
    }
}

impl Trial {
    /// What comes of it in so many worlds.
    pub(crate) fn run(self, worlds: u64) -> Outcome {
        let courses = (0..worlds).into_par_iter().map(|seed| self.course(seed)).collect::<Vec<_>>();
        Outcome::of(&courses)
    }

    /// What comes of it in one world.
    pub(crate) fn course(self, seed: u64) -> Course {
        let world = World::new(seed);
        match self.rules {
            Rules::Electric => electric::course(&world, self.showings, seed),
            Rules::Chance | Rules::Rates | Rules::Ours => self.bred(&world, seed),
        }
    }

    fn settings(self, seed: u64) -> Settings {
        let mut settings = Settings::new("simulation", Origin::of_bits(seed), seed, &["simulated"]);
        settings.limit = SHEEP;
        settings.niches = ["mean".to_owned(), "contrast".to_owned()];
        if self.rules == Rules::Rates {
            (settings.bins, settings.screening, settings.rebirths) = (1, 1, 0.0);
        }
        settings
    }

    /// A pool under our rules.
    fn bred(self, world: &World, seed: u64) -> Course {
        let mut meadow = Meadow { world, genes: std::collections::BTreeMap::new() };
        let mut shepherd = Shepherd { pool: Pool::new(self.settings(seed)), day: Day(0), number: 0 };
        let mut rng = Rng::stream(seed, 1);
        let mut course = Course::default();
        let first: Vec<Event> =
            (0..SHEEP).map(|serial| shepherd.founder(serial as u32, &mut meadow, &mut rng)).collect();
        shepherd.tell(vec![Event::Brood { brood: 0, seed }]);
        shepherd.tell(first);
        for brood in 1..=BROODS {
            let votes = self.votes(&shepherd.pool, &meadow, &mut rng);
            shepherd.day.0 += (shepherd.pool.living().count() as u64 * self.showings / SHOWINGS_A_DAY).max(1) as u32;
            shepherd.tell(vec![votes]);
            let census = Census::of(&shepherd.pool, shepherd.day);
            let bred = breed(&shepherd.pool, &census, &Order::default(), &meadow);
            shepherd.tell(bred.events());
            meadow.genes.extend(bred.born.iter().map(|(born, genes)| (born.id, *genes)));
            let dead = deaths(&shepherd.pool, &Census::of(&shepherd.pool, shepherd.day));
            shepherd.tell(dead.ids.into_iter().map(|id| Event::Died { id }).collect());
            let sheep: Vec<(&Genes, &Traits, Id)> = shepherd
                .pool
                .living()
                .map(|sheep| (&meadow.genes[&sheep.born.id], &sheep.born.figures, sheep.family))
                .collect();
            course.note(brood, world, &sheep);
        }
        course
    }

    /// What the unit counts until the next brood.
    fn votes(self, pool: &Pool, meadow: &Meadow<'_>, rng: &mut Rng) -> Event {
        // Totals grow by what is counted now.
        let mut count = |id: &Id| {
            let known = pool.total(UNIT, &id.to_string());
            let chance = vote_chance(meadow.world.taste(&meadow.genes[id]));
            let chance = if self.rules == Rules::Chance { CHANCE_VOTES } else { chance };
            let up = drawn_votes(self.showings, chance, rng);
            Count { shown: known.shown + self.showings, up: known.up + up, down: 0 }
        };
        let sheep = pool.living().map(|sheep| (sheep.born.id.to_string(), count(&sheep.born.id))).collect();
        Event::Votes { unit: UNIT.to_owned(), sheep }
    }
}

/// The chance that a showing of a sheep with this taste is voted for.
fn vote_chance(taste: f64) -> f64 {
    LEAST_VOTES + TASTED_VOTES * taste
}

fn drawn_votes(showings: u64, chance: f64, rng: &mut Rng) -> u64 {
    (0..showings).filter(|_| rng.unit() < chance).count() as u64
}

/// Who tells the pool what happens.
struct Shepherd {
    pool: Pool,
    day: Day,
    number: u64,
}

impl Shepherd {
    fn founder(&self, serial: u32, meadow: &mut Meadow<'_>, rng: &mut Rng) -> Event {
        let genes = World::random(rng);
        let id = Id { brood: 0, serial, origin: self.pool.settings.origin };
        meadow.genes.insert(id, genes);
        Event::Born(Born {
            id,
            parents: Vec::new(),
            operator: "stranger".to_owned(),
            seed: 0,
            species: "simulated".to_owned(),
            figures: meadow.world.figures(&genes),
            licence: "CC0-1.0".to_owned(),
            strength: 1.0,
            waited: None,
        })
    }

    fn tell(&mut self, events: Vec<Event>) {
        for event in events {
            let stamp = Stamp { number: self.number, pool: self.pool.settings.origin };
            let entry = Entry { stamp, day: self.day, event };
            self.pool.apply(&entry).expect("the simulation names only sheep that were born, each once");
            self.number += 1;
        }
    }
}

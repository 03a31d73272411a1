//! Claims on breeding with real genomes.
//!
//! Owns a simulated voter with a taste on figures, who judges small pictures of all species of a pool.

use std::collections::BTreeMap;
use std::path::Path;

use ::breeding::{Birth, Count, Day, Event, Made, Nursery, Order, Origin, Pool, Settings, Traits};
use ::breeding::{Born, Brood, Census, Entry, Stamp, breed, deaths};
use flame::Backend;
use species::{Figures, Genome, Rng, Threads};

use super::nursery::Candidates;
use crate::species as kinds;

/// Showings of each sheep between two broods, and votes of the best.
const SHOWINGS: u64 = 60;
const VOTES: f64 = 12.0;
/// The unit that the voter stands before.
const UNIT: &str = "lobby";

/// A nursery that draws fewer samples than the product: the voter sees few, too.
struct Sketches(Candidates);

impl Nursery for Sketches {
    type Candidate = Box<dyn Genome>;

    fn candidate(&self, birth: &Birth, rng: &mut Rng) -> Option<Made<Self::Candidate>> {
        self.0.candidate(birth, rng)
    }

    fn figures(&self, candidate: &Self::Candidate) -> Result<Traits, Vec<String>> {
        self.0.sketch(candidate)
    }
}

/// What the voter likes: colours, edges and motion, each by its place among the founders.
struct Taste(Vec<(usize, Vec<f64>)>);

impl Taste {
    fn of(founders: &[Traits]) -> Self {
        let liked = ["colourfulness", "edges", "activity"];
        let figure = |name: &&str| {
            let place = Figures::NAMES.iter().position(|known| known == name).unwrap();
            let mut values: Vec<f64> = founders.iter().map(|traits| traits.at(place)).collect();
            values.sort_unstable_by(f64::total_cmp);
            (place, values)
        };
        Self(liked.iter().map(figure).collect())
    }

    /// From 0 to 1.
    fn likes(&self, traits: &Traits) -> f64 {
        let rank = |(place, values): &(usize, Vec<f64>)| {
            values.partition_point(|value| *value < traits.at(*place)) as f64 / values.len() as f64
        };
        self.0.iter().map(rank).sum::<f64>() / self.0.len() as f64
    }
}

fn parse(ending: &str, text: &str) -> Box<dyn Genome> {
    kinds::parse(Path::new(&format!("x.{ending}")), text, &Backend::default()).unwrap()
}

/// A pool in memory, its genomes, and the number of its last event.
struct World {
    pool: Pool,
    genomes: BTreeMap<::breeding::Id, String>,
    species: String,
    last: u64,
}

impl World {
    fn new(species: &str) -> Self {
        let mut settings = Settings::new("world", Origin::of_bits(1), 5, &[species]);
        settings.limit = 30;
        Self { pool: Pool::new(settings), genomes: BTreeMap::new(), species: species.to_owned(), last: 0 }
    }

    fn tell(&mut self, events: Vec<Event>) {
        for event in events {
            self.last += 1;
            let stamp = Stamp { number: self.last, pool: self.pool.settings.origin };
            self.pool.apply(&Entry { stamp, day: Day(20_500), event }).unwrap();
        }
    }

    fn brood(&mut self, births: usize) {
        let parents = self.genomes.iter().map(|(id, text)| (*id, parse(&self.species, text))).collect();
        let census = Census::of(&self.pool, self.pool.last_day());
        let order = Order { births: Some(births), ..Order::default() };
        let threads = Threads::new(0).unwrap();
        let nursery = Sketches(Candidates::new(parents, BTreeMap::new(), None));
        let brood: Brood<Box<dyn Genome>> = threads.run(|| breed(&self.pool, &census, &order, &nursery));
        for (born, genome) in &brood.born {
            self.genomes.insert(born.id, genome.text());
        }
        self.tell(brood.events());
    }

    fn vote(&mut self, taste: &Taste) {
        let count = |born: &Born| {
            let up = (VOTES * taste.likes(&born.figures).powi(3)).round() as u64;
            let known = self.pool.total(UNIT, &born.id.to_string());
            Count { shown: known.shown + SHOWINGS, up: known.up + up, down: 0 }
        };
        let sheep = self.pool.living().map(|sheep| (sheep.born.id.to_string(), count(&sheep.born))).collect();
        self.tell(vec![Event::Votes { unit: UNIT.into(), sheep }]);
        let census = Census::of(&self.pool, self.pool.last_day());
        let died = deaths(&self.pool, &census).ids;
        self.tell(died.into_iter().map(|id| Event::Died { id }).collect());
    }

    /// Mean and standard deviation of what the voter likes, over all that live.
    fn liking(&self, taste: &Taste) -> [f64; 2] {
        let all: Vec<f64> = self.pool.living().map(|sheep| taste.likes(&sheep.born.figures)).collect();
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        let variance = all.iter().map(|liking| (liking - mean).powi(2)).sum::<f64>() / all.len() as f64;
        [mean, variance.sqrt()]
    }
}

/// By how many standard deviations of the founders the mean liking has risen after so many broods of so many births.
fn rise(species: &str, founders: usize, broods: usize, births: usize) -> f64 {
    let mut world = World::new(species);
    world.brood(founders);
    let founders: Vec<Traits> = world.pool.living().map(|sheep| sheep.born.figures.clone()).collect();
    let taste = Taste::of(&founders);
    let [start, spread] = world.liking(&taste);
    for _ in 0..broods {
        world.vote(&taste);
        world.brood(births);
    }
    world.vote(&taste);
    let [end, _] = world.liking(&taste);
    println!("{species}: {start:.3} to {end:.3}, spread {spread:.3}");
    (end - start) / spread
}

/// The species in the variable `TASTES`, with eight broods of twenty; every day a small pool of expressions, which are drawn
/// fast.
#[test]
fn a_pool_learns_a_hidden_taste() {
    let Ok(all) = std::env::var("TASTES") else {
        let rise = rise("expr", 16, 3, 8);
        assert!(rise >= 0.5, "{rise} standard deviations");
        return;
    };
    for species in all.split(',') {
        let rise = rise(species, 30, 8, 20);
        assert!(rise >= 1.0, "{species}: {rise} standard deviations");
    }
}

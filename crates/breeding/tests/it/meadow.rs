//! Pools of simulated sheep, for the claims: how they are begun, and what happens in them.

use std::collections::BTreeMap;

use crate::simulation::{Genes, Meadow, World};
use breeding::{
    Born, Brood, Census, Count, Day, Entry, Event, Id, Ledger, Order, Origin, Pool, Settings, Traits, Waiting, breed,
    deaths,
};
use species::Rng;

/// A pool of `sheep` strangers.
pub(crate) struct Sheep<'a> {
    pub(crate) pool: Pool,
    pub(crate) meadow: Meadow<'a>,
    pub(crate) entries: Vec<Entry>,
    pub(crate) rng: Rng,
}

pub(crate) fn settings(seed: u64) -> Settings {
    let mut settings = Settings::new("meadow", Origin::of_bits(seed), seed, &["simulated"]);
    settings.niches = ["mean".to_owned(), "contrast".to_owned()];
    settings
}

pub(crate) fn born(id: Id, world: &World, genes: &Genes) -> Born {
    Born {
        id,
        parents: Vec::new(),
        operator: "stranger".to_owned(),
        seed: 0,
        species: "simulated".to_owned(),
        figures: world.figures(genes),
        licence: "CC0-1.0".to_owned(),
        strength: 1.0,
        waited: None,
    }
}

/// A genome with these figures that waits to be born.
pub(crate) fn waiting(figures: Traits) -> Waiting {
    let [species, licence, genome] = ["simulated", "CC0-1.0", "a genome"].map(str::to_owned);
    Waiting { species, figures, licence, genome }
}

impl<'a> Sheep<'a> {
    pub(crate) fn new(world: &'a World, seed: u64, sheep: u32) -> Sheep<'a> {
        let mut rng = Rng::stream(seed, 9);
        let meadow = Meadow { world, genes: BTreeMap::new() };
        let pool = Pool::new(settings(seed));
        let origin = pool.settings.origin;
        let mut new = Sheep { pool, meadow, entries: Vec::new(), rng: rng.clone() };
        let mut events = vec![Event::Brood { brood: 0, seed }];
        for serial in 0..sheep {
            let genes = World::random(&mut rng);
            let id = Id { brood: 0, serial, origin };
            new.meadow.genes.insert(id, genes);
            events.push(Event::Born(born(id, world, &genes)));
        }
        new.rng = rng;
        new.tell(events);
        new
    }

    pub(crate) fn tell(&mut self, events: Vec<Event>) {
        let next = self.entries.last().map_or(0, |entry| entry.stamp.number + 1);
        for (number, event) in (next..).zip(events) {
            let stamp = breeding::Stamp { number, pool: self.pool.settings.origin };
            let entry = Entry { stamp, day: Day(number as u32 / 50), event };
            self.pool.apply(&entry).unwrap();
            self.entries.push(entry);
        }
    }

    /// Every living sheep is shown up to 60 times and voted for by chance.
    pub(crate) fn vote(&mut self) {
        let mut count = |sheep: &breeding::Sheep| {
            let shown = (self.rng.unit() * 60.0) as u64;
            let up = (0..shown).filter(|_| self.rng.unit() < 0.06).count() as u64;
            let id = sheep.born.id.to_string();
            let known = self.pool.total("wall", &id);
            (id, Count { shown: known.shown + shown, up: known.up + up, down: 0 })
        };
        let sheep = self.pool.living().map(&mut count).collect();
        self.tell(vec![Event::Votes { unit: "wall".to_owned(), sheep }]);
    }

    pub(crate) fn census(&self) -> Census {
        Census::of(&self.pool, self.pool.last_day())
    }

    pub(crate) fn brood(&self, order: &Order) -> Brood<Genes> {
        breed(&self.pool, &self.census(), order, &self.meadow)
    }

    /// A whole brood: votes, births, deaths.
    pub(crate) fn step(&mut self) {
        self.vote();
        let brood = self.brood(&Order::default());
        self.tell(brood.events());
        self.meadow.genes.extend(brood.born.iter().map(|(born, genes)| (born.id, *genes)));
        let dead = deaths(&self.pool, &self.census());
        self.tell(dead.ids.into_iter().map(|id| Event::Died { id }).collect());
    }
}

/// What the ledger in a folder says.
pub(crate) fn events(folder: &std::path::Path) -> Vec<Entry> {
    Ledger::read(&durable::LocalFolder::new(folder)).unwrap().entries().cloned().collect()
}

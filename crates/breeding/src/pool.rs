//! What a pool is after all that happened in it.
//!
//! Owns the state that follows from settings and events: who lives, who died, whose children they are, what they were
//! given. Never decides anything, and never reads a file.
//!
//! Start at [`Pool::of`].

use std::collections::{BTreeMap, BTreeSet};

use crate::error::BreedingError;
use crate::event::{Born, Day, Entry, Event, Mark, Stamp, Waiting};
use crate::id::Id;
use crate::rating::{Count, Votes};
use crate::settings::Settings;

/// A sheep of the pool, alive or dead.
#[derive(Clone, Debug, PartialEq)]
pub struct Sheep {
    /// Its birth.
    pub born: Born,
    /// Its founding family, by the sheep without parents that began it: that of its first parent.
    pub family: Id,
    /// How many broods the pool had when it was born, or born again.
    pub since: u32,
    /// The artist's mark.
    pub mark: Mark,
    /// The event that it died by.
    pub died: Option<Stamp>,
}

/// The sheep that a unit has, or will have.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Edition {
    /// Its sheep, in the order in which they were chosen.
    pub ids: Vec<Id>,
    unique: usize,
}

/// What came in since the last brood.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct News {
    /// Showings.
    pub showings: u64,
    /// Votes, for and against.
    pub votes: u64,
}

/// A pool.
#[derive(Clone, Debug, PartialEq)]
pub struct Pool {
    /// What it is bred by.
    pub settings: Settings,
    sheep: BTreeMap<Id, Sheep>,
    votes: Votes,
    /// The largest totals that were heard of each unit, by sheep.
    totals: BTreeMap<String, BTreeMap<String, Count>>,
    has_votes: bool,
    editions: BTreeMap<String, Edition>,
    /// By the events since which they wait.
    waiting: BTreeMap<Stamp, Waiting>,
    /// Broods of all pools whose events are here.
    broods: u32,
    /// The number that the next brood has, and the next birth.
    next_brood: u32,
    next_serial: u32,
    news: News,
    last_day: Day,
}

impl Sheep {
    /// Whether it lives.
    pub fn is_alive(&self) -> bool {
        self.died.is_none()
    }

    /// Whether the artist keeps it.
    pub fn is_pinned(&self) -> bool {
        self.mark == Mark::Keep
    }
}

impl Edition {
    /// Those of its sheep that are for no other edition.
    pub fn unique(&self) -> &[Id] {
        &self.ids[self.ids.len().saturating_sub(self.unique)..]
    }
}

impl Pool {
    /// A pool in which nothing happened.
    pub fn new(settings: Settings) -> Pool {
        Pool {
            votes: Votes::new(settings.half_life_days),
            settings,
            sheep: BTreeMap::new(),
            has_votes: false,
            totals: BTreeMap::new(),
            editions: BTreeMap::new(),
            waiting: BTreeMap::new(),
            broods: 0,
            next_brood: 0,
            next_serial: 0,
            news: News::default(),
            last_day: Day::default(),
        }
    }

    /// The pool after these events, in the order of their stamps.
    ///
    /// # Errors
    /// As [`Pool::apply`].
    pub fn of<'a>(settings: Settings, entries: impl IntoIterator<Item = &'a Entry>) -> Result<Pool, BreedingError> {
        let mut pool = Pool::new(settings);
        entries.into_iter().try_for_each(|entry| pool.apply(entry))?;
        Ok(pool)
    }

    /// Lets an event happen.
    ///
    /// # Errors
    /// [`BreedingError::Unborn`], [`BreedingError::Twice`] or [`BreedingError::Traits`]; the pool is as it was.
    pub fn apply(&mut self, entry: &Entry) -> Result<(), BreedingError> {
        let stamp = entry.stamp;
        match &entry.event {
            Event::Born(born) => self.bear(stamp, born)?,
            Event::Brood { brood, .. } => {
                self.broods += 1;
                if stamp.pool == self.settings.origin {
                    self.next_brood = self.next_brood.max(brood.saturating_add(1));
                    self.news = News::default();
                }
            }
            Event::Died { id } => {
                self.known(stamp, id)?.died.get_or_insert(stamp);
            }
            Event::Elected { edition, ids, unique } => {
                ids.iter().try_for_each(|id| self.known(stamp, id).map(|_| ()))?;
                self.editions.insert(edition.clone(), Edition { ids: ids.clone(), unique: *unique });
            }
            Event::Marked { id, mark } => {
                let sheep = self.known(stamp, id)?;
                sheep.mark = *mark;
                if *mark == Mark::Reject {
                    sheep.died.get_or_insert(stamp);
                }
            }
            Event::Reborn { id } => {
                let broods = self.broods;
                let sheep = self.known(stamp, id)?;
                (sheep.died, sheep.since) = (None, broods);
            }
            Event::Votes { unit, sheep } => {
                let known = self.totals.entry(unit.clone()).or_default();
                let mut grown = Vec::with_capacity(sheep.len());
                for (id, count) in sheep {
                    let total = known.entry(id.clone()).or_default();
                    grown.push((id.as_str(), count.since(*total)));
                    *total = total.larger(*count);
                }
                self.votes.add(unit, entry.day, grown.iter().copied());
                self.has_votes = true;
                for (_, count) in grown {
                    self.news.showings = self.news.showings.saturating_add(count.shown);
                    self.news.votes = self.news.votes.saturating_add(count.up).saturating_add(count.down);
                }
            }
            // What waits in another pool is born there.
            Event::Waits(waiting) if stamp.pool == self.settings.origin => {
                self.waiting.insert(stamp, waiting.clone());
            }
            Event::Waits(_) => {}
        }
        self.last_day = self.last_day.max(entry.day);
        Ok(())
    }

    fn bear(&mut self, stamp: Stamp, born: &Born) -> Result<(), BreedingError> {
        if self.sheep.contains_key(&born.id) {
            return Err(BreedingError::Twice { stamp, id: born.id });
        }
        let found = born.figures.values().len();
        let expected = self.sheep.values().next().map_or(found, |other| other.born.figures.values().len());
        if found != expected {
            return Err(BreedingError::Traits { stamp, id: born.id, found, expected });
        }
        let families: Result<Vec<Id>, _> =
            born.parents.iter().map(|parent| self.known(stamp, parent).map(|sheep| sheep.family)).collect();
        let family = families?.first().copied().unwrap_or(born.id);
        let sheep = Sheep { born: born.clone(), family, since: self.broods, mark: Mark::None, died: None };
        self.sheep.insert(born.id, sheep);
        if let Some(since) = &born.waited {
            self.waiting.remove(since);
        }
        if born.id.origin == self.settings.origin {
            self.next_serial = self.next_serial.max(born.id.serial.saturating_add(1));
        }
        Ok(())
    }

    fn known(&mut self, stamp: Stamp, id: &Id) -> Result<&mut Sheep, BreedingError> {
        self.sheep.get_mut(id).ok_or(BreedingError::Unborn { stamp, id: *id })
    }

    /// All sheep, alive and dead, in the order of their ids.
    pub fn sheep(&self) -> impl Iterator<Item = &Sheep> + Clone {
        self.sheep.values()
    }

    /// Those that live, in the order of their ids.
    pub fn living(&self) -> impl Iterator<Item = &Sheep> + Clone {
        self.sheep.values().filter(|sheep| sheep.is_alive())
    }

    /// Those that died, the last one first.
    pub fn dead(&self) -> Vec<&Sheep> {
        let mut dead: Vec<&Sheep> = self.sheep.values().filter(|sheep| !sheep.is_alive()).collect();
        dead.sort_by_key(|sheep| std::cmp::Reverse((sheep.died, sheep.born.id)));
        dead
    }

    /// A sheep.
    pub fn get(&self, id: Id) -> Option<&Sheep> {
        self.sheep.get(&id)
    }

    /// The sheep whose id is `text`, or begins with `text` and a hyphen: `7.00412` in a pool that was never merged.
    ///
    /// # Errors
    /// [`BreedingError::Unknown`] if there is none, or more than one.
    pub fn find(&self, text: &str) -> Result<&Sheep, BreedingError> {
        let start = format!("{text}-");
        let is_meant = |sheep: &&Sheep| {
            let id = sheep.born.id.to_string();
            id == text || id.starts_with(&start)
        };
        let mut found = self.sheep.values().filter(is_meant);
        match (found.next(), found.next()) {
            (Some(sheep), None) => Ok(sheep),
            _ => Err(BreedingError::Unknown { id: text.to_owned(), origin: self.settings.origin }),
        }
    }

    /// The ancestors of a sheep, each once: its parents, theirs, and so on.
    pub fn ancestors(&self, id: Id) -> Vec<&Sheep> {
        let mut seen = BTreeSet::from([id]);
        let mut found = Vec::new();
        let mut next = vec![id];
        while let Some(child) = next.pop() {
            let parents = self.get(child).map(|sheep| sheep.born.parents.as_slice()).unwrap_or_default();
            for parent in parents.iter().filter(|parent| seen.insert(**parent)).copied().collect::<Vec<_>>() {
                found.extend(self.get(parent));
                next.insert(0, parent);
            }
        }
        found
    }

    /// The genomes that wait to be strangers of this pool's broods, in the order in which they came; each with the event
    /// since which it waits.
    pub fn waiting(&self) -> impl Iterator<Item = (Stamp, &Waiting)> {
        self.waiting.iter().map(|(since, waiting)| (*since, waiting))
    }

    /// The children of a sheep.
    pub fn children(&self, id: Id) -> impl Iterator<Item = &Sheep> {
        self.sheep.values().filter(move |sheep| sheep.born.parents.contains(&id))
    }

    /// What units counted.
    pub fn votes(&self) -> &Votes {
        &self.votes
    }

    /// The largest total of a sheep that was heard of a unit.
    pub fn total(&self, unit: &str, id: &str) -> Count {
        self.totals.get(unit).and_then(|sheep| sheep.get(id)).copied().unwrap_or_default()
    }

    /// The editions by name, the last one of each name.
    pub fn editions(&self) -> impl Iterator<Item = (&str, &Edition)> {
        self.editions.iter().map(|(name, edition)| (name.as_str(), edition))
    }

    /// How many broods there were, in this pool and in those that it was merged with.
    pub fn broods(&self) -> u32 {
        self.broods
    }

    /// The number of the next brood of this pool.
    pub fn next_brood(&self) -> u32 {
        self.next_brood
    }

    /// The number of the next birth of this pool.
    pub fn next_serial(&self) -> u32 {
        self.next_serial
    }

    /// What came in since the last brood of this pool.
    pub fn news(&self) -> News {
        self.news
    }

    /// Whether a brood is due: as many showings or votes came in as the settings say.
    pub fn is_due(&self) -> bool {
        self.news.showings >= self.settings.due_showings || self.news.votes >= self.settings.due_votes
    }

    /// The day of the last event.
    pub fn last_day(&self) -> Day {
        self.last_day
    }

    /// How much the artist's marks count in screening, beside the audience's votes.
    pub fn artist_share(&self) -> f64 {
        self.settings.artist.unwrap_or(if self.has_votes { 0.0 } else { 1.0 })
    }
}

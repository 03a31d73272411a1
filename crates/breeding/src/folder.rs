//! The folder of a pool.
//!
//! Owns where its files lie, and the order in which they are written: genomes before the events that name them, so that no
//! event is without its genome. A genome that no event names is what a cut left behind; it means nothing and may be
//! replaced. Never parses a genome.
//!
//! Start at [`Folder::open`].

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use durable::{LocalFolder, Locked};

use crate::brood::Brood;
use crate::error::BreedingError;
use crate::event::{Born, Day, Entry, Event};
use crate::ledger::Ledger;
use crate::pool::Pool;
use crate::settings::{SETTINGS, Settings};

/// The folder of genomes.
const GENOMES: &str = "genomes";

/// A pool on a disk.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    ledger: Ledger,
    pool: Pool,
    /// Held while the pool may be changed.
    lock: Option<Locked>,
}

impl Folder {
    /// Makes a pool in a folder that has none, and opens it for changes.
    ///
    /// # Errors
    /// [`BreedingError::Setting`]; [`BreedingError::Exists`]; [`BreedingError::Io`].
    pub fn create(path: &Path, settings: &Settings) -> Result<Folder, BreedingError> {
        let text = settings.text()?;
        let genomes = path.join(GENOMES);
        fs::create_dir_all(&genomes).map_err(failed("make", &genomes))?;
        let file = path.join(SETTINGS);
        if file.exists() {
            return Err(BreedingError::Exists { folder: path.display().to_string() });
        }
        durable::write(&file, text.as_bytes()).map_err(failed("write", &file))?;
        Folder::open_for_changes(path)
    }

    /// Opens a pool to look at it.
    ///
    /// # Errors
    /// As [`Settings::parse`], [`Ledger::read`] and [`Pool::of`].
    pub fn open(path: &Path) -> Result<Folder, BreedingError> {
        let file = path.join(SETTINGS);
        let text = durable::open_plain(&file).and_then(io::read_to_string).map_err(failed("read", &file))?;
        let settings = Settings::parse(&text, &file.to_string_lossy())?;
        let ledger = Ledger::read(&LocalFolder::new(path))?;
        let pool = Pool::of(settings, ledger.entries())?;
        Ok(Folder { path: path.to_owned(), ledger, pool, lock: None })
    }

    /// Opens a pool to change it. No other program can do so until this is dropped.
    ///
    /// # Errors
    /// As [`Folder::open`]; [`BreedingError::InUse`].
    pub fn open_for_changes(path: &Path) -> Result<Folder, BreedingError> {
        let lock = File::open(path).map_err(failed("open", path))?;
        match lock.try_lock() {
            Ok(()) => Ok(Folder { lock: Some(Locked::new(lock)), ..Folder::open(path)? }),
            Err(fs::TryLockError::WouldBlock) => Err(BreedingError::InUse { folder: path.display().to_string() }),
            Err(fs::TryLockError::Error(error)) => Err(failed("lock", path)(error)),
        }
    }

    /// The pool.
    pub fn pool(&self) -> &Pool {
        &self.pool
    }

    /// The events.
    pub fn ledger(&self) -> &Ledger {
        &self.ledger
    }

    /// The folder of the genomes.
    pub fn genome_folder(&self) -> PathBuf {
        self.path.join(GENOMES)
    }

    /// The file of a sheep's genome.
    pub fn genome(&self, born: &Born) -> PathBuf {
        self.genome_folder().join(format!("{}.{}", born.id, born.species))
    }

    /// The sheep whose genome is not there.
    pub fn missing_genomes(&self) -> impl Iterator<Item = &Born> {
        self.pool.sheep().map(|sheep| &sheep.born).filter(|born| !self.genome(born).is_file())
    }

    /// Lets events happen; returns when the disk has them.
    ///
    /// # Errors
    /// As [`Pool::apply`], and nothing is changed; as [`Ledger::append`]; [`BreedingError::InUse`] if it was not opened for
    /// changes.
    pub fn tell(&mut self, day: Day, events: Vec<Event>) -> Result<(), BreedingError> {
        self.must_be_locked()?;
        let entries = self.ledger.stamped(self.pool.settings.origin, day, events);
        let mut after = self.pool.clone();
        entries.iter().try_for_each(|entry| after.apply(entry))?;
        self.ledger.append(&LocalFolder::new(&self.path), entries)?;
        self.pool = after;
        Ok(())
    }

    /// Takes in a brood, with the texts of its genomes.
    ///
    /// # Errors
    /// As [`Folder::tell`]; [`BreedingError::Io`] for a genome.
    pub fn bear<C>(
        &mut self,
        day: Day,
        brood: &Brood<C>,
        text: impl Fn(&Born, &C) -> String,
    ) -> Result<(), BreedingError> {
        self.write_genomes(&brood.born, text)?;
        self.tell(day, brood.events())
    }

    /// Takes in sheep that were made elsewhere, with the texts of their genomes. They are no brood.
    ///
    /// # Errors
    /// As [`Folder::bear`].
    pub fn bring_in<C>(
        &mut self,
        day: Day,
        born: &[(Born, C)],
        text: impl Fn(&Born, &C) -> String,
    ) -> Result<(), BreedingError> {
        self.write_genomes(born, text)?;
        self.tell(day, born.iter().map(|(born, _)| Event::Born(born.clone())).collect())
    }

    fn write_genomes<C>(&self, born: &[(Born, C)], text: impl Fn(&Born, &C) -> String) -> Result<(), BreedingError> {
        self.must_be_locked()?;
        born.iter().try_for_each(|(born, candidate)| {
            let path = self.genome(born);
            durable::write(&path, text(born, candidate).as_bytes()).map_err(failed("write", &path))
        })
    }

    /// Takes in all that happened in another pool, with its genomes. In whichever order pools are merged, and however often,
    /// the same sheep live, with the same votes.
    ///
    /// # Errors
    /// [`BreedingError::Clash`] or [`BreedingError::NoGenome`], and nothing is told; as [`Folder::tell`].
    pub fn merge(&mut self, other: &Folder) -> Result<(), BreedingError> {
        self.must_be_locked()?;
        let new = self.ledger.missing(&other.ledger)?;
        let mut all: Vec<&Entry> = self.ledger.entries().chain(new.iter().map(|(entry, _)| entry)).collect();
        all.sort_by_key(|entry| entry.stamp);
        let pool = Pool::of(self.pool.settings.clone(), all)?;
        for (entry, _) in &new {
            let Event::Born(born) = &entry.event else { continue };
            let (from, to) = (other.genome(born), self.genome(born));
            if !from.exists() {
                return Err(BreedingError::NoGenome { id: born.id, path: from.display().to_string() });
            }
            durable::copy(&from, &to).map_err(failed("copy", &from))?;
        }
        self.ledger.merge(&LocalFolder::new(&self.path), &other.ledger)?;
        self.pool = pool;
        Ok(())
    }

    fn must_be_locked(&self) -> Result<(), BreedingError> {
        let folder = || self.path.display().to_string();
        self.lock.as_ref().map(|_| ()).ok_or_else(|| BreedingError::InUse { folder: folder() })
    }
}

fn failed<'a>(action: &'static str, path: &'a Path) -> impl Fn(io::Error) -> BreedingError + 'a {
    move |source| BreedingError::Io { action, path: path.display().to_string(), source }
}

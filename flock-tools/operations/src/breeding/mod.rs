//! Pools, in which sheep are bred, and their genomes.
//!
//! Owns how a pool is opened, and with which exit status each error ends; `nursery.rs` has how candidates are made and looked
//! at. The rules of breeding are those of the package `breeding`; the operators are those of each species.

pub mod nursery;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use ::breeding::{Born, BreedingError, Day, Event, Folder, Id, Mark, Stamp, Waiting};
use flame::Backend;
use species::Genome;

use crate::program::{Exit, Fatal, now};
use crate::species::{self as kinds, Refused};

/// A genome of a pool that cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("cannot use the genome `{path}`")]
struct GenomeError {
    path: PathBuf,
    source: Box<dyn std::error::Error>,
}

/// A genome that waits to be born, and cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("cannot use the genome that waits since event {event}")]
struct WaitingError {
    event: u64,
    source: Box<dyn std::error::Error>,
}

/// Opens the pool at `path` to look at it.
pub fn open(path: &Path) -> Result<Folder, Fatal> {
    Ok(Folder::open(path)?)
}

/// Opens the pool at `path` to change it.
pub fn open_for_changes(path: &Path) -> Result<Folder, Fatal> {
    Ok(Folder::open_for_changes(path)?)
}

/// Ends a command because of a pool.
impl From<BreedingError> for Fatal {
    fn from(error: BreedingError) -> Self {
        let exit = match &error {
            BreedingError::Exists { .. } | BreedingError::InUse { .. } => Exit::No,
            BreedingError::Io { .. } | BreedingError::NoGenome { .. } => Exit::Unreadable,
            BreedingError::BadEvent { .. }
            | BreedingError::Clash { .. }
            | BreedingError::Setting { .. }
            | BreedingError::Settings { .. }
            | BreedingError::Traits { .. }
            | BreedingError::Twice { .. }
            | BreedingError::Unborn { .. }
            | BreedingError::Unknown { .. } => Exit::Malformed,
        };
        Self::new(exit, error)
    }
}

/// The genome of a sheep.
pub fn genome(folder: &Folder, born: &Born) -> Result<Box<dyn Genome>, Fatal> {
    read(folder.genome(born))
}

/// The genomes that wait to be born.
pub fn waiting(folder: &Folder) -> Result<BTreeMap<Stamp, Box<dyn Genome>>, Fatal> {
    let genome = |(since, waiting): (Stamp, &Waiting)| {
        // The text tells the species of most, the ending that of all.
        let named = PathBuf::from("genome").with_extension(&waiting.species);
        let parsed = kinds::parse(&named, &waiting.genome, &Backend::default());
        let wrong = |Refused { exit, source, .. }| Fatal::new(exit, WaitingError { event: since.number, source });
        Ok((since, parsed.map_err(wrong)?))
    };
    folder.pool().waiting().map(genome).collect()
}

/// The genome at `path`.
pub fn read(path: PathBuf) -> Result<Box<dyn Genome>, Fatal> {
    kinds::read(&path, &Backend::default()).map_err(|Refused { exit, source, hint }| {
        let fatal = Fatal::new(exit, GenomeError { path, source });
        match hint {
            Some(hint) => fatal.hint(hint),
            None => fatal,
        }
    })
}

/// Marks sheep in the ledger of `folder`, which is open for changes. Who died by the artist's mark lives again without it.
/// Errors: If the ledger cannot be written.
pub fn set_marks(folder: &mut Folder, marks: &[(Id, Mark)]) -> Result<(), Fatal> {
    let mut events: Vec<Event> = marks.iter().map(|(id, mark)| Event::Marked { id: *id, mark: *mark }).collect();
    let was_rejected = |id: Id| folder.pool().get(id).is_some_and(|sheep| sheep.mark == Mark::Reject);
    let reborn = marks.iter().filter(|(id, mark)| *mark != Mark::Reject && was_rejected(*id));
    events.extend(reborn.map(|(id, _)| Event::Reborn { id: *id }));
    Ok(folder.tell(today(), events)?)
}

/// Today.
pub fn today() -> Day {
    Day(now::day())
}

//! The commands on pools, in which sheep are bred.
//!
//! Owns what these commands share: how a pool is opened, and with which exit status each error ends. The rules of breeding
//! are those of the package `breeding`; the operators are those of each species.
//!
//! | file | what is there |
//! |---|---|
//! | `pool.rs`, `add.rs`, `check.rs` | `dreams pool`: new pools, their sheep, the artist's marks, merging; genomes from elsewhere; faults |
//! | `breed.rs`, `nursery.rs` | `dreams breed`: a brood, and how its candidates are made and looked at |
//! | `votes.rs` | `dreams votes`: what units report |
//! | `family.rs` | `dreams family`: ancestors and children of a sheep |
//! | `elect.rs`, `edition.rs` | `dreams elect`: a flock from a pool, and its transitions |
//! | `sheet.rs` | a contact sheet of sheep |

mod add;
pub(crate) mod breed;
mod check;
mod edition;
pub(crate) mod elect;
pub(crate) mod family;
pub(crate) mod nursery;
pub(crate) mod pool;
mod sheet;
#[cfg(test)]
mod tests;
pub(crate) mod votes;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use ::breeding::{Born, BreedingError, Day, Folder, Stamp, Waiting};
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
pub(crate) fn open(path: &Path) -> Result<Folder, Fatal> {
    Folder::open(path).map_err(fatal)
}

/// Opens the pool at `path` to change it.
pub(crate) fn open_for_changes(path: &Path) -> Result<Folder, Fatal> {
    Folder::open_for_changes(path).map_err(fatal)
}

/// Ends a command because of a pool.
pub(crate) fn fatal(error: BreedingError) -> Fatal {
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
    Fatal::new(exit, error)
}

/// The genome of a sheep.
pub(crate) fn genome(folder: &Folder, born: &Born) -> Result<Box<dyn Genome>, Fatal> {
    read(folder.genome(born))
}

/// The genomes that wait to be born.
fn waiting(folder: &Folder) -> Result<BTreeMap<Stamp, Box<dyn Genome>>, Fatal> {
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
fn read(path: PathBuf) -> Result<Box<dyn Genome>, Fatal> {
    kinds::read(&path, &Backend::default()).map_err(|Refused { exit, source, hint }| {
        let fatal = Fatal::new(exit, GenomeError { path, source });
        match hint {
            Some(hint) => fatal.hint(hint),
            None => fatal,
        }
    })
}

/// Today.
pub(crate) fn today() -> Day {
    Day(now::day())
}

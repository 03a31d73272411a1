//! Who made what in a flock, and under which licences it may be shown.
//!
//! Owns the credits of every sheep and transition, put together from `credits.toml`, from the genomes and, for transitions,
//! from the sheep at their ends. `file.rs` reads and edits the file, `entry.rs` has what it says, `licence.rs` the licences.
//! Never judges whether a claim is true.
//!
//! Start at [`FlockCredits::of`].

mod entry;
mod file;
mod flock_credits;
mod licence;

use std::collections::BTreeSet;
use std::path::Path;

pub use entry::{Said, Subject};
pub use file::CreditsFile;
pub use flock_credits::{Credit, FlockCredits, NotForSale};
pub use licence::{Licence, OURS, Sale};

use crate::program::Fatal;
use flock::Draft;

/// Writes down `notes` on sheep and transitions of the flock in `folder` that have no entry yet. Entries that are there
/// stay as they are: the artist may have edited them.
pub fn write_down(folder: &Path, notes: Vec<(Subject, Said)>) -> Result<(), Fatal> {
    // While one command edits the flock, no other edits its credits.
    let draft = Draft::lock(folder)?;
    let manifest = draft.edit.manifest();
    let ids: BTreeSet<_> = manifest.sheep.iter().map(|sheep| &sheep.id).collect();
    let pairs: BTreeSet<_> = manifest.transitions.iter().map(|t| (&t.from, &t.to)).collect();
    let is_there = |subject: &Subject| match subject {
        Subject::Sheep(id) => ids.contains(id),
        Subject::Transition(from, to) => pairs.contains(&(from, to)),
    };
    let mut file = CreditsFile::read(folder)?;
    file.add(notes.into_iter().filter(|(subject, _)| is_there(subject)))?;
    file.save()
}

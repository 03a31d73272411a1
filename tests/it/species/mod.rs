//! What every species promises, tried on genomes by chance and by breeding, and on the transitions between them.
//!
//! Owns the list of species, and how many genomes are tried. A species that is added to the list has to keep all promises.
//!
//! Start at [`SPECIES`].
#![allow(clippy::print_stdout, reason = "what was found is printed for who asks for it")]

use flame::{Backend, Flames};
use species::{Breed, Species};

mod damage;
mod joins;
mod lineage;
mod loops;
mod reference;
mod sheep;
mod texts;
mod transitions;

/// All species.
const SPECIES: &[&dyn Breed] = &[&expression::Expressions, &agents::Agents, &plant::Plants, &FLAMES];

/// The species that are tried: all, or those alone whose files' endings the variable `ONLY` names, with commas between.
fn tried() -> impl Iterator<Item = &'static dyn Breed> {
    let only = std::env::var("ONLY").unwrap_or_default();
    let only: Vec<_> = only.split(',').filter(|ending| !ending.is_empty()).map(str::to_owned).collect();
    for ending in &only {
        assert!(SPECIES.iter().any(|species| species.ending() == ending), "`{ending}` is the ending of no species");
    }
    SPECIES.iter().copied().filter(move |species| only.is_empty() || only.iter().any(|one| one == species.ending()))
}

static FLAMES: Flames = Flames { backend: Backend::PROCESSOR, coloured: Ok };

/// How many genomes of a species are tried. Pictures that have noise take a hundred times as long.
fn genomes(of: &dyn Breed) -> u64 {
    many("GENOMES", if of.ending() == FLAMES.ending() { 2 } else { 8 })
}

/// The number in the variable `name`, or `usual`: little is tried every day, more where the environment says so.
fn many(name: &str, usual: u64) -> u64 {
    std::env::var(name).ok().and_then(|number| number.parse().ok()).unwrap_or(usual)
}

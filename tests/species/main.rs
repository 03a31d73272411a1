//! What every species promises, tried on genomes by chance and by breeding, and on the transitions between them.
//!
//! Owns the list of species, and how many genomes are tried. A species that is added to the list has to keep all promises.
//!
//! Start at [`SPECIES`].
#![forbid(unsafe_code)]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a claim fails by panicking")]
#![allow(clippy::print_stdout, reason = "what was found is told where it is asked for")]

use species::Breed;

mod damage;
mod joins;
mod loops;
mod sheep;
mod texts;
mod transitions;

/// All species that can be bred. Flames cannot yet: those of the demo are tried with the others.
const SPECIES: &[&dyn Breed] = &[&expression::Expressions, &agents::Agents, &plant::Plants];

/// The number in the variable `name`, or `usual`: little is tried every day, more where the environment says so.
fn many(name: &str, usual: u64) -> u64 {
    std::env::var(name).ok().and_then(|number| number.parse().ok()).unwrap_or(usual)
}

//! Breeding.
//!
//! Owns the trait of species whose genomes are made at random, mutated and crossed. Never says which of them are good.
//!
//! Start at [`Breed`].

use crate::contract::{Genome, Species};
use crate::rng::Rng;

/// A species that can be bred. The same random numbers make the same genome on every machine.
pub trait Breed: Species {
    /// A genome at random.
    fn random(&self, rng: &mut Rng) -> Box<dyn Genome>;

    /// A child of one parent, and the name of what was done to it. `strength` 1 is the usual rate of mutation, 0 none. `None`
    /// if the parent is of another species.
    fn mutate(&self, parent: &dyn Genome, strength: f64, rng: &mut Rng) -> Option<(Box<dyn Genome>, &'static str)>;

    /// A child of two parents, and the name of how it was made. `None` if they are not both of this species, or have no
    /// child that can be drawn.
    fn cross(&self, parents: [&dyn Genome; 2], rng: &mut Rng) -> Option<(Box<dyn Genome>, &'static str)>;
}

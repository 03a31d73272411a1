//! Breeding.
//!
//! Owns the trait of species whose genomes are made at random, mutated and crossed, and what an operator says of itself.
//! Never says which children are good.
//!
//! Start at [`Breed`].

use crate::contract::{Genome, Species};
use crate::lineage::Lineage;
use crate::rng::Rng;

/// What made a child that is its parent unchanged.
pub const UNCHANGED: &str = "none";

/// A child, and the name of the operator that made it, or [`UNCHANGED`].
pub type Child = (Box<dyn Genome>, &'static str);

/// A species that can be bred. The same random numbers make the same genome on every machine. A child has no name of its
/// own yet; it says of its origin what its parents say of themselves, and the operator ([`Lineage::of_child`]).
pub trait Breed: Species {
    /// All that can be done to make a child: each name and each alias once.
    fn operators(&self) -> &'static [Operator];

    /// A genome at random.
    fn random(&self, rng: &mut Rng) -> Box<dyn Genome>;

    /// A child of one parent by an operator that chance takes. `strength` 1 is the usual size of a change, 0 none. `None`
    /// if the parent is of another species, or has no child that can be drawn.
    fn mutate(&self, parent: &dyn Genome, strength: f64, rng: &mut Rng) -> Option<Child>;

    /// A child of two parents by an operator that chance takes. `None` if they are not both of this species, or have no
    /// child that can be drawn.
    fn cross(&self, parents: [&dyn Genome; 2], rng: &mut Rng) -> Option<Child>;

    /// A child by the operator that is called `name`, by itself or by an alias: of one parent by a mutation, of two by a
    /// crossing. `None` as [`Breed::mutate`] and [`Breed::cross`], if there is no such operator for so many parents, or if
    /// it has nothing to do with these.
    fn apply(&self, name: &str, parents: &[&dyn Genome], strength: f64, rng: &mut Rng) -> Option<Child>;

    /// The operator that is called `name`, by itself or by an alias.
    fn operator(&self, name: &str) -> Option<&'static Operator> {
        self.operators().iter().find(|operator| operator.name == name || operator.aliases.contains(&name))
    }
}

/// Something that makes a child.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Operator {
    /// What it is called: lower-case words joined by hyphens.
    pub name: &'static str,
    /// What else it is called.
    pub aliases: &'static [&'static str],
    /// What it does, in a sentence without a full stop.
    pub does: &'static str,
    /// Of how many parents it makes a child: 1 for a mutation, 2 for a crossing.
    pub parents: usize,
}

impl Operator {
    /// A mutation.
    pub const fn mutation(name: &'static str, aliases: &'static [&'static str], does: &'static str) -> Operator {
        Operator { name, aliases, does, parents: 1 }
    }

    /// A crossing.
    pub const fn crossing(name: &'static str, aliases: &'static [&'static str], does: &'static str) -> Operator {
        Operator { name, aliases, does, parents: 2 }
    }
}

/// `child` with the lineage of what the operator `name` makes of `parents`.
pub fn descended(child: &dyn Genome, name: &'static str, parents: &[&dyn Genome]) -> Child {
    let lineages: Vec<Lineage> = parents.iter().map(|parent| parent.lineage()).collect();
    (child.with_lineage(&Lineage::of_child(name, &lineages)), name)
}

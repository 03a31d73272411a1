//! The children that a brood is made of: a parent or two, an operator, a size of change, and what must stay.
//!
//! Owns which operators a lock forbids, and how often a candidate is made again that nobody should see. The operators are
//! those of each species. Never touches a file.
//!
//! Start at [`Wish::child`].
//!
//! # Source
//! Sims, *Artificial Evolution for Computer Graphics* (1991): a parent and its mutations in a grid, one or two chosen for
//! each generation.

use operations::breeding::nursery::judged;
use species::{Breed, Figures, Genome, Operator, Rng, UNCHANGED};

/// Candidates that may be refused in a row.
const TRIES: usize = 12;
/// The strength of an operator for a slider at its end; its middle is the usual strength.
const STRONGEST: f64 = 2.0;
/// The part of births of several parents that are crossings.
const CROSSED: f64 = 0.6;

/// What must stay as it is in a parent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Lock {
    /// The colours.
    Palette,
    /// Where one looks from, and how things move past.
    Camera,
    /// The numbers of what is drawn.
    Transforms,
    /// Of which parts it consists.
    Structure,
}

/// What the artist asks of a brood.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub(crate) struct Wish {
    /// How large changes are, from 0 to 1; 0.5 is usual.
    pub(crate) strength: f64,
    /// What must stay.
    pub(crate) locks: Vec<Lock>,
    /// The seed of all of it.
    pub(crate) seed: u64,
}

/// A genome that may be a parent.
pub(crate) struct Parent {
    pub(crate) id: String,
    /// The ending of its species.
    pub(crate) species: String,
    pub(crate) genome: Box<dyn Genome>,
}

/// A child that was made.
#[derive(Debug)]
pub(crate) struct MadeChild {
    pub(crate) genome: Box<dyn Genome>,
    pub(crate) op: String,
    pub(crate) species: String,
    /// The ids of its parents.
    pub(crate) parents: Vec<String>,
}

/// What each operator changes, by species and name. An operator of a name that is not here changes everything.
const CHANGES: [(&str, &str, &[Lock]); 39] = [
    ("agents", "colours", &[Lock::Palette]),
    ("agents", "come", &[Lock::Structure]),
    ("agents", "crossover", &[Lock::Palette, Lock::Camera, Lock::Structure]),
    ("agents", "drift", &[Lock::Camera]),
    ("agents", "glow", &[Lock::Palette]),
    ("agents", "leave", &[Lock::Structure]),
    ("agents", "strings", &[Lock::Transforms]),
    ("expr", "copy", &[Lock::Structure]),
    ("expr", "graft", &[Lock::Structure]),
    ("expr", "new-part", &[Lock::Structure]),
    ("expr", "number", &[Lock::Transforms]),
    ("expr", "other-function", &[Lock::Structure]),
    ("expr", "several", &[Lock::Palette, Lock::Transforms, Lock::Structure]),
    ("expr", "unwrap", &[Lock::Structure]),
    ("expr", "vector", &[Lock::Palette]),
    ("expr", "walk", &[Lock::Palette, Lock::Transforms, Lock::Structure]),
    ("expr", "wrap", &[Lock::Structure]),
    ("flam3", "add", &[Lock::Structure]),
    ("flam3", "affine", &[Lock::Transforms]),
    ("flam3", "affines", &[Lock::Transforms]),
    ("flam3", "alternation", &[Lock::Palette, Lock::Transforms, Lock::Structure]),
    ("flam3", "camera", &[Lock::Camera]),
    ("flam3", "colours", &[Lock::Palette]),
    ("flam3", "delete", &[Lock::Structure]),
    ("flam3", "final", &[Lock::Structure, Lock::Camera]),
    ("flam3", "interpolation", &[Lock::Palette, Lock::Camera, Lock::Transforms]),
    ("flam3", "palette", &[Lock::Palette]),
    ("flam3", "post", &[Lock::Transforms]),
    ("flam3", "recolouring", &[Lock::Palette]),
    ("flam3", "symmetry", &[Lock::Structure]),
    ("flam3", "union", &[Lock::Palette, Lock::Structure]),
    ("flam3", "variations", &[Lock::Structure]),
    ("plant", "chances", &[Lock::Structure]),
    ("plant", "crossover", &[Lock::Transforms, Lock::Structure]),
    ("plant", "dissolve", &[Lock::Transforms]),
    ("plant", "either", &[Lock::Transforms, Lock::Structure]),
    ("plant", "fractions", &[Lock::Transforms]),
    ("plant", "genes", &[Lock::Transforms, Lock::Structure]),
    ("plant", "sky", &[Lock::Palette, Lock::Camera]),
];

impl Wish {
    /// The child at the place `at` of a brood: of `parents`, or by chance of the species `ending` if there are none. The same
    /// wish, parents and place give the same child.
    /// Errors: What was wrong with the last candidate, in a word or two.
    pub(crate) fn child(
        &self,
        all: &[Box<dyn Breed>],
        parents: &[Parent],
        ending: &str,
        at: u64,
    ) -> Result<MadeChild, String> {
        let mut rng = Rng::stream(self.seed, at);
        let mut refused = "no operator is left: everything is locked".to_owned();
        for _ in 0..TRIES {
            let Some(made) = self.candidate(all, parents, ending, &mut rng) else { continue };
            match judged(&*made.genome, Figures::sketched) {
                Ok(_) => return Ok(made),
                Err(faults) => refused = format!("every candidate was {}", faults.join(", ")),
            }
        }
        Err(refused)
    }

    fn candidate(&self, all: &[Box<dyn Breed>], parents: &[Parent], ending: &str, rng: &mut Rng) -> Option<MadeChild> {
        let species = |ending: &str| all.iter().find(|species| species.ending() == ending);
        let Some(first) = parents.get(below(rng, parents.len())) else {
            let genome = species(ending)?.random(rng);
            return Some(MadeChild {
                genome,
                op: "random".to_owned(),
                species: ending.to_owned(),
                parents: Vec::new(),
            });
        };
        let own = species(&first.species)?;
        let mates: Vec<&Parent> =
            parents.iter().filter(|other| other.id != first.id && other.species == first.species).collect();
        let mate = mates.get(below(rng, mates.len())).filter(|_| rng.unit() < CROSSED);
        let crossed = mate.and_then(|mate| {
            let genomes = [&*first.genome, &*mate.genome];
            let (genome, op) = self.made(&**own, &genomes, rng)?;
            Some((genome, op, vec![first.id.clone(), mate.id.clone()]))
        });
        let (genome, op, ids) = crossed.or_else(|| {
            let (genome, op) = self.made(&**own, &[&*first.genome], rng)?;
            Some((genome, op, vec![first.id.clone()]))
        })?;
        Some(MadeChild { genome, op: op.to_owned(), species: first.species.clone(), parents: ids })
    }

    /// A child by an operator that the locks allow.
    fn made(&self, own: &dyn Breed, parents: &[&dyn Genome], rng: &mut Rng) -> Option<(Box<dyn Genome>, &'static str)> {
        let strength = STRONGEST * self.strength.clamp(0.0, 1.0);
        let child = if self.locks.is_empty() {
            match *parents {
                [parent] => own.mutate(parent, strength, rng),
                [first, second] => own.cross([first, second], rng),
                _ => None,
            }
        } else {
            let is_allowed = |it: &&Operator| it.parents == parents.len() && self.allows(own.ending(), it.name);
            let operators: Vec<&Operator> = own.operators().iter().filter(is_allowed).collect();
            let operator = operators.get(below(rng, operators.len()))?;
            own.apply(operator.name, parents, strength, rng)
        };
        child.filter(|(_, op)| *op != UNCHANGED)
    }

    /// Whether the locks leave this operator.
    fn allows(&self, ending: &str, operator: &str) -> bool {
        let known = CHANGES.iter().find(|(species, name, _)| *species == ending && *name == operator);
        known.is_some_and(|(.., changes)| changes.iter().all(|change| !self.locks.contains(change)))
    }
}

/// A number below `count`; 0 if that is 0.
fn below(rng: &mut Rng, count: usize) -> usize {
    ((rng.unit() * count as f64) as usize).min(count.saturating_sub(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use flame::Backend;
    use operations::species::all;
    use std::collections::BTreeSet;

    fn parent(id: &str, species: &str, text: &str) -> Parent {
        let path = std::path::PathBuf::from(format!("x.{species}"));
        let genome = operations::species::parse(&path, text, &Backend::default()).unwrap();
        Parent { id: id.to_owned(), species: species.to_owned(), genome }
    }

    fn demo(id: &str) -> Parent {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../demo/genomes/{id}.flam3"));
        parent(id, "flam3", &std::fs::read_to_string(path).unwrap())
    }

    #[test]
    fn every_operator_of_every_species_says_what_it_changes() {
        let told: BTreeSet<(String, String)> =
            CHANGES.iter().map(|(species, name, _)| ((*species).to_owned(), (*name).to_owned())).collect();
        let species = all(&Backend::default());
        let there = species
            .iter()
            .flat_map(|own| own.operators().iter().map(|operator| (own.ending().to_owned(), operator.name.to_owned())));
        assert_eq!(told, there.collect());
    }

    #[test]
    fn a_locked_palette_is_that_of_the_parent() {
        let all = all(&Backend::default());
        let [orchid, caldera] = [demo("orchid"), demo("caldera")];
        let palette = |genome: &dyn Genome| {
            flame::Genome::parse(&genome.text()).map(|genome| format!("{:?}", genome.palette)).unwrap()
        };
        let parents = [palette(&*orchid.genome), palette(&*caldera.genome)];
        let wish = Wish { strength: 0.5, locks: vec![Lock::Palette], seed: 5 };
        let both = [orchid, caldera];
        for at in 0..12 {
            let mut rng = Rng::stream(5, at);
            let Some(child) = wish.candidate(&all, &both, "flam3", &mut rng) else { continue };
            assert!(parents.contains(&palette(&*child.genome)), "{}", child.op);
        }
    }

    #[test]
    fn the_same_wish_gives_the_same_child_and_another_place_another_one() {
        let all = all(&Backend::default());
        let parents =
            [parent("p", "expr", "(expression 1 (picture (+ .5 (* .4 (sin (+ (* 4 (bw-noise .5 1)) (wave 1 0)))))))")];
        let wish = Wish { strength: 0.5, locks: Vec::new(), seed: 9 };
        let text = |at| wish.child(&all, &parents, "expr", at).map(|child| child.genome.text());
        assert_eq!(text(1), text(1));
        assert_ne!(text(1), text(2));
        assert!(text(1).is_ok());
    }

    #[test]
    fn without_parents_a_child_is_a_stranger_of_the_species_that_is_asked_for() {
        let all = all(&Backend::default());
        let wish = Wish { strength: 0.5, locks: vec![Lock::Structure], seed: 2 };
        let child = wish.candidate(&all, &[], "plant", &mut Rng::stream(2, 0)).unwrap();
        assert_eq!((&*child.op, &*child.species, child.parents.len()), ("random", "plant", 0));
    }
}

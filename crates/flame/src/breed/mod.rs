//! Breeding flames.
//!
//! Owns which flames are shown to those who choose. Genomes are made at random (`random.rs`, `variety.rs`,
//! `palette.rs`), changed (`mutation.rs`) and crossed (`crossing.rs`) within limits (`limits.rs`), then framed and exposed (`framing.rs`).
//! Never says which of them are good.
//!
//! Start at [`Flames`]'s `Breed`; at [`Genome::mutated`] and [`Genome::crossed`] without a picture.
//!
//! # Source
//! Which operators there are follows flam3-genome, whose documentation names them; shares and amounts are ours. Ours add
//! transforms, too.

mod chance;
mod crossing;
mod framing;
mod limits;
mod mutation;
mod palette;
mod random;
mod variety;

pub use crossing::Crossing;
pub use mutation::Mutation;

use species::{Breed, Child, Figures, Operator, Rng, Threads, UNCHANGED, descended};

use crate::animate::Loop;
use crate::genome::Genome;
use crate::render::{Backend, FrameCost, Settings};
use crate::species::{Flame, Flames};
use framing::Exposing;

/// The loop that a candidate is judged by: its frames, and the shape of its pictures.
const FRAMES: f64 = 384.0;
const SIZE: [u32; 2] = [1280, 720];
/// How often another one is made in place of one that may not be shown.
const RANDOM_TRIES: usize = 200;
const TRIES: usize = 40;
/// What a glance has to find before more is drawn: contrast, and the part of the picture that shows something.
const LEAST_CONTRAST: f64 = 0.05;
const LEAST_LIT: f64 = 0.08;

/// All operators: the mutations, then the crossings.
const OPERATORS: [Operator; mutation::TABLE.len() + crossing::TABLE.len()] = {
    let mut all = [mutation::TABLE[0].2; mutation::TABLE.len() + crossing::TABLE.len()];
    let mut at = 0;
    while at < all.len() {
        let mutations = mutation::TABLE.len();
        all[at] = if at < mutations { mutation::TABLE[at].2 } else { crossing::TABLE[at - mutations].2 };
        at += 1;
    }
    all
};

/// Frames, exposes and judges what is bred, by small pictures.
#[derive(Debug)]
pub struct Judge {
    threads: Threads,
}

impl Judge {
    /// A judge with a thread of its own; `None` if the system has none.
    pub fn new() -> Option<Judge> {
        Some(Judge { threads: Threads::new(1).ok()? })
    }

    /// A flame at random with camera and brightness. `None` if there is nothing to see.
    pub fn first_look(&self, genome: &Genome) -> Option<Genome> {
        self.look(&framing::framed(genome)?, Exposing::All)
    }

    /// A child with camera and brightness: the camera stays where the parent's was if only colours have changed. `None` if
    /// there is nothing to see.
    pub fn look_at_child(&self, genome: &Genome, is_of_colours: bool) -> Option<Genome> {
        if !is_of_colours {
            return self.look(&framing::framed(genome)?, Exposing::Extremes);
        }
        let light = crate::light::glance(genome, 0.0, &self.threads).ok()?;
        framing::lit(genome.clone(), &light, Exposing::Extremes, &self.threads).ok()
    }

    fn look(&self, genome: &Genome, whose: Exposing) -> Option<Genome> {
        let (turned, light) = framing::turned_to_the_brightest(genome, &self.threads).ok()?;
        framing::lit(turned, &light, whose, &self.threads).ok()
    }

    /// Whether anybody should see it.
    pub fn shows(&self, genome: &Genome) -> bool {
        let is_worth_a_look = || {
            let light = crate::light::glance(genome, 0.0, &self.threads);
            light.is_ok_and(|light| light.contrast >= LEAST_CONTRAST && light.lit >= LEAST_LIT)
        };
        let can_be_drawn = || FrameCost::of(&Loop::new(genome, FRAMES), 0.0, &Settings::default()).is_ok();
        is_worth_a_look() && can_be_drawn() && self.figures(genome).is_some_and(|figures| figures.faults().is_empty())
    }

    /// The figures of its loop, by few samples. `None` if it cannot be drawn.
    pub fn figures(&self, genome: &Genome) -> Option<Figures> {
        let flame = Flame::new(genome.clone(), Backend::default());
        let turning = ::species::Genome::turning(&flame, SIZE, FRAMES);
        Figures::sketched(&*turning, FRAMES, SIZE, &self.threads).ok()
    }
}

/// A child, and what made it.
type Made = (Genome, &'static str);

impl Flames {
    fn flame(&self, genome: Genome) -> Flame {
        Flame::new(genome, self.backend.clone())
    }

    /// The first child that may be shown, with its lineage; of `tries`.
    fn shown(
        &self,
        parents: &[&dyn ::species::Genome],
        tries: usize,
        mut make: impl FnMut() -> Option<(Made, bool)>,
    ) -> Option<Child> {
        let judge = Judge::new()?;
        let mut children = (0..tries).filter_map(|_| {
            let ((child, name), is_of_colours) = make()?;
            Some((judge.look_at_child(&child, is_of_colours)?, name))
        });
        let (child, name) = children.find(|(child, _)| judge.shows(child))?;
        Some(descended(&self.flame(child), name, parents))
    }

    fn mutant(
        &self,
        parent: &dyn ::species::Genome,
        by: Option<Mutation>,
        strength: f64,
        rng: &mut Rng,
    ) -> Option<Child> {
        let own = parent.as_any().downcast_ref::<Flame>()?.genome();
        if strength <= 0.0 {
            return Some((Box::new(self.flame(own.clone())), UNCHANGED));
        }
        self.shown(&[parent], TRIES, || {
            let (child, mutation) = match by {
                Some(mutation) => (own.mutated_by(mutation, strength, rng)?, mutation),
                None => own.mutated(strength, rng),
            };
            Some(((child, mutation.name()), mutation.is_of_colours()))
        })
    }

    fn crossed(&self, parents: [&dyn ::species::Genome; 2], by: Option<Crossing>, rng: &mut Rng) -> Option<Child> {
        let [a, b] = parents.map(|parent| parent.as_any().downcast_ref::<Flame>().map(Flame::genome));
        let (a, b) = (a?, b?);
        self.shown(&parents, TRIES, || {
            let crossing = by.unwrap_or_else(|| Crossing::drawn(rng));
            let child = a.crossed_by(crossing, b, rng);
            Some(((child, crossing.name()), crossing.is_of_colours()))
        })
    }
}

impl Breed for Flames {
    fn operators(&self) -> &'static [Operator] {
        &OPERATORS
    }

    fn random(&self, rng: &mut Rng) -> Box<dyn ::species::Genome> {
        let Some(judge) = Judge::new() else { return Box::new(self.flame(Genome::random(rng))) };
        let mut flames =
            (0..RANDOM_TRIES).filter_map(|_| judge.first_look(&limits::within_limits(Genome::random(rng))));
        let flame = flames.find(|flame| judge.shows(flame));
        Box::new(self.flame(flame.unwrap_or_else(|| Genome::random(rng))))
    }

    fn mutate(&self, parent: &dyn ::species::Genome, strength: f64, rng: &mut Rng) -> Option<Child> {
        self.mutant(parent, None, strength, rng)
    }

    fn cross(&self, parents: [&dyn ::species::Genome; 2], rng: &mut Rng) -> Option<Child> {
        self.crossed(parents, None, rng)
    }

    fn apply(&self, name: &str, parents: &[&dyn ::species::Genome], strength: f64, rng: &mut Rng) -> Option<Child> {
        let operator = self.operator(name)?;
        match *parents {
            [a, b] => self.crossed([a, b], Some(Crossing::named(operator.name)?), rng),
            [parent] => self.mutant(parent, Some(Mutation::named(operator.name)?), strength, rng),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chance_takes_operators_by_their_shares() {
        let mut rng = Rng::stream(5, 0);
        let flame = loop {
            let flame = Genome::random(&mut rng);
            if (3..8).contains(&flame.xforms.len()) {
                break flame;
            }
        };
        let draws = 10_000;
        let mut counts = std::collections::BTreeMap::<&str, f64>::new();
        for _ in 0..draws {
            *counts.entry(Mutation::drawn(&flame, &mut rng).name()).or_default() += 1.0;
            *counts.entry(Crossing::drawn(&mut rng).name()).or_default() += 1.0;
        }
        let possible = mutation::TABLE.iter().filter(|(mutation, ..)| mutation.fits(&flame));
        let mutations = possible.map(|(_, share, operator)| (*share, operator.name));
        let crossings = crossing::TABLE.iter().map(|(_, share, operator)| (*share, operator.name));
        for sum in
            [mutations.clone().map(|(share, _)| share).sum::<u32>(), crossings.clone().map(|(share, _)| share).sum()]
        {
            assert_eq!(sum, 100);
        }
        for (share, name) in mutations.chain(crossings) {
            let (found, wanted) = (counts[name] / f64::from(draws), f64::from(share) / 100.0);
            // Four standard deviations.
            assert!((found - wanted).abs() < 4.0 * (wanted / f64::from(draws)).sqrt(), "{name}: {found}, {wanted}");
        }
        for (number, (mutation, ..)) in mutation::TABLE.iter().enumerate() {
            assert_eq!((*mutation as usize, Mutation::named(mutation.name())), (number, Some(*mutation)));
        }
        for (number, (crossing, ..)) in crossing::TABLE.iter().enumerate() {
            assert_eq!((*crossing as usize, Crossing::named(crossing.name())), (number, Some(*crossing)));
        }
    }
}

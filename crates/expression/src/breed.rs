//! Which expressions are shown to those who choose.
//!
//! Owns the limits of a candidate: it is fast, and by small pictures neither dull nor wild. Never makes one: `random.rs`,
//! `mutate.rs` and `cross.rs` do.
//!
//! Start at [`Expressions`]'s `Breed`.

use ::species::{Breed, Child, Figures, Operator, Rng, Threads, UNCHANGED, descended};

use crate::cross::Mating;
use crate::genome::Genome;
use crate::motion::Loop;
use crate::mutate::Mutation;
use crate::node::Node;
use crate::picture::{Settings, render};
use crate::species::Expressions;
use crate::tile::Samples;

/// The most nanoseconds a sample of a candidate, of which many are drawn at once: Sims's rule.
pub const FASTEST_NS: f32 = 150.0;

/// The loop that a candidate is judged by: its frames, and the shape of its pictures.
const FRAMES: f64 = 384.0;
const SIZE: [u32; 2] = [1280, 720];

/// How often another one is made in place of one that may not be shown.
const RANDOM_TRIES: usize = 2000;
const TRIES: usize = 40;
/// How many children are made until one comes by the operator that was asked for.
const SEARCHED: usize = 300;

/// A glance at a candidate before its figures: a small picture at two moments.
const GLANCE: Settings = Settings { size: [32, 18], samples: Samples::One, is_blurred: false };
const MOMENTS: [f64; 2] = [0.0, 80.0];
/// Less between the darkest and the brightest channel of a picture is flat.
const LEAST_RANGE: f32 = 0.1;

/// Judges candidates, on a thread of its own.
struct Judge {
    /// None if the system has none: then candidates are taken unseen.
    threads: Option<Threads>,
}

impl Judge {
    fn new() -> Judge {
        Judge { threads: Threads::new(1).ok() }
    }

    fn shows(&self, genome: &Genome) -> bool {
        genome.ns_per_sample().is_ok_and(|ns| ns <= FASTEST_NS)
            && self.threads.as_ref().is_none_or(|threads| has_no_fault(genome, threads))
    }
}

fn has_no_fault(genome: &Genome, threads: &Threads) -> bool {
    let turning = Loop::new(genome, FRAMES);
    is_worth_a_look(&turning, threads)
        && Figures::sketched(&turning, FRAMES, SIZE, threads).is_ok_and(|figures| figures.faults().is_empty())
}

/// Whether anything is seen, and moves: most of what chance makes is told by this already.
fn is_worth_a_look(turning: &Loop, threads: &Threads) -> bool {
    let [Ok((first, _)), Ok((later, _))] = MOMENTS.map(|frame| render(turning, frame, &GLANCE, threads)) else {
        return false;
    };
    let lights = first.pixels.as_flattened();
    let (low, high) =
        lights.iter().fold((1.0, 0.0), |(low, high): (f32, f32), light| (low.min(*light), high.max(*light)));
    high - low >= LEAST_RANGE && first != later
}

/// Several mutations of one parent.
const SEVERAL: &str = "several";

/// All operators.
const OPERATORS: &[Operator] = &[
    Operator::mutation(Mutation::New.name(), &[], "replaces a part by a new one at random"),
    Operator::mutation(
        Mutation::Adjusted.name(),
        &[],
        "changes a number a little, or turns one position into the other",
    ),
    Operator::mutation(Mutation::AdjustedVector.name(), &[], "changes the numbers of a vector a little"),
    Operator::mutation(
        Mutation::OtherFunction.name(),
        &[],
        "replaces a function by another one that keeps its arguments",
    ),
    Operator::mutation(Mutation::Wrapped.name(), &[], "makes a part the argument of a new function"),
    Operator::mutation(Mutation::Unwrapped.name(), &[], "replaces a function by one of its arguments"),
    Operator::mutation(Mutation::Copied.name(), &[], "replaces a part by a copy of another one"),
    Operator::mutation(SEVERAL, &[], "does several of the other mutations"),
    Operator::crossing(Mating::Walked.name(), &[], "walks along both trees and takes either side where they differ"),
    Operator::crossing(Mating::Grafted.name(), &[], "replaces a part of one parent by a part of the other"),
];

/// What a child with these mutations came by.
fn action(mutations: &[Mutation]) -> &'static str {
    match mutations {
        [] => UNCHANGED,
        [mutation] => mutation.name(),
        _ => SEVERAL,
    }
}

/// A child with mutations that may be shown, by the operator `name` if one is named.
fn mutant(parent: &Genome, name: Option<&str>, strength: f64, rng: &mut Rng) -> Option<(Genome, &'static str)> {
    let judge = Judge::new();
    let tries = if strength > 0.0 { TRIES } else { 0 };
    let mut children = (0..tries).filter_map(|_| match name {
        None => Some(parent.mutated(strength, rng)),
        Some(name) => (0..SEARCHED).map(|_| parent.mutated(strength, rng)).find(|(_, done)| action(done) == name),
    });
    let is_shown = |(child, _): &(Genome, Vec<Mutation>)| child.picture != parent.picture && judge.shows(child);
    let (child, mutations) = children.find(is_shown)?;
    Some((Genome { name: None, ..child }, action(&mutations)))
}

/// A child of two parents that may be shown, by the operator `name` if one is named.
fn crossed([a, b]: [&Genome; 2], name: Option<&str>, rng: &mut Rng) -> Option<(Genome, &'static str)> {
    let judge = Judge::new();
    let is_named = |(_, mating): &(Genome, Mating)| name.is_none_or(|name| mating.name() == name);
    let mut children =
        (0..TRIES).filter_map(|_| (0..SEARCHED).filter_map(|_| a.crossed(b, rng)).find(|child| is_named(child)));
    let is_new = |child: &Genome| child.picture != a.picture && child.picture != b.picture;
    let (child, mating) = children.find(|(child, _)| is_new(child) && judge.shows(child))?;
    Some((Genome { name: None, ..child }, mating.name()))
}

impl Breed for Expressions {
    fn operators(&self) -> &'static [Operator] {
        OPERATORS
    }

    fn random(&self, rng: &mut Rng) -> Box<dyn ::species::Genome> {
        let judge = Judge::new();
        let genome = (0..RANDOM_TRIES).map(|_| Genome::random(rng)).find(|genome| judge.shows(genome));
        Box::new(genome.unwrap_or_else(known))
    }

    fn mutate(&self, parent: &dyn ::species::Genome, strength: f64, rng: &mut Rng) -> Option<Child> {
        let own: &Genome = parent.as_any().downcast_ref()?;
        Some(match mutant(own, None, strength, rng) {
            Some((child, name)) => descended(&child, name, &[parent]),
            None => (Box::new(own.clone()), UNCHANGED),
        })
    }

    fn cross(&self, parents: [&dyn ::species::Genome; 2], rng: &mut Rng) -> Option<Child> {
        let [a, b] = parents.map(|parent| parent.as_any().downcast_ref());
        let (child, name) = crossed([a?, b?], None, rng)?;
        Some(descended(&child, name, &parents))
    }

    fn apply(&self, name: &str, parents: &[&dyn ::species::Genome], strength: f64, rng: &mut Rng) -> Option<Child> {
        let operator = self.operator(name).filter(|operator| operator.parents == parents.len())?;
        let own: Option<Vec<&Genome>> = parents.iter().map(|parent| parent.as_any().downcast_ref()).collect();
        let (child, name) = match own?[..] {
            [a, b] => crossed([a, b], Some(operator.name), rng)?,
            [parent] => mutant(parent, Some(operator.name), strength, rng)?,
            _ => return None,
        };
        Some(descended(&child, name, parents))
    }
}

impl Mutation {
    /// What it is called.
    pub const fn name(self) -> &'static str {
        match self {
            Mutation::New => "new-part",
            Mutation::Adjusted => "number",
            Mutation::AdjustedVector => "vector",
            Mutation::OtherFunction => "other-function",
            Mutation::Wrapped => "wrap",
            Mutation::Unwrapped => "unwrap",
            Mutation::Copied => "copy",
        }
    }
}

impl Mating {
    /// What it is called.
    pub const fn name(self) -> &'static str {
        match self {
            Mating::Walked => "walk",
            Mating::Grafted => "graft",
        }
    }
}

/// What may be shown if chance makes nothing else: waves in a noise.
fn known() -> Genome {
    let picture = Node::parse("(+ .5 (* .4 (sin (+ (* 4 (bw-noise .5 1)) (wave 1 0)))))");
    Genome::from(picture.unwrap_or(Node::X))
}

//! Which expressions are shown to those who choose.
//!
//! Owns the limits of a candidate: it is fast, and by small pictures neither dull nor wild. Never makes one: `random.rs`,
//! `mutate.rs` and `cross.rs` do.
//!
//! Start at [`Expressions`]'s `Breed`.

use ::species::{Breed, Figures, Rng, Threads};

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

impl Breed for Expressions {
    fn random(&self, rng: &mut Rng) -> Box<dyn ::species::Genome> {
        let judge = Judge::new();
        let genome = (0..RANDOM_TRIES).map(|_| Genome::random(rng)).find(|genome| judge.shows(genome));
        Box::new(genome.unwrap_or_else(known))
    }

    fn mutate(
        &self,
        parent: &dyn ::species::Genome,
        strength: f64,
        rng: &mut Rng,
    ) -> Option<(Box<dyn ::species::Genome>, &'static str)> {
        let parent: &Genome = parent.as_any().downcast_ref()?;
        let judge = Judge::new();
        let mut children = (0..if strength > 0.0 { TRIES } else { 0 }).map(|_| parent.mutated(strength, rng));
        let is_shown = |(child, _): &(Genome, Vec<Mutation>)| child.picture != parent.picture && judge.shows(child);
        let (child, mutations) = children.find(is_shown).unwrap_or_else(|| (parent.clone(), Vec::new()));
        let action = match mutations[..] {
            [] => "none",
            [mutation] => mutation.name(),
            _ => "several mutations",
        };
        Some((Box::new(child), action))
    }

    fn cross(
        &self,
        parents: [&dyn ::species::Genome; 2],
        rng: &mut Rng,
    ) -> Option<(Box<dyn ::species::Genome>, &'static str)> {
        let [first, second] = parents.map(|parent| parent.as_any().downcast_ref::<Genome>());
        let (first, second) = first.zip(second)?;
        let judge = Judge::new();
        let mut children = (0..TRIES).filter_map(|_| first.crossed(second, rng));
        let (child, mating) = children.find(|(child, _)| judge.shows(child))?;
        Some((Box::new(child), mating.name()))
    }
}

impl Mutation {
    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Mutation::New => "a new part",
            Mutation::Adjusted => "adjusted",
            Mutation::OtherFunction => "another function",
            Mutation::Wrapped => "wrapped",
            Mutation::Unwrapped => "unwrapped",
            Mutation::Copied => "a copied part",
        }
    }
}

impl Mating {
    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Mating::Walked => "walked together",
            Mating::Grafted => "grafted",
        }
    }
}

/// What may be shown if chance makes nothing else: waves in a noise.
fn known() -> Genome {
    let picture = Node::parse("(+ .5 (* .4 (sin (+ (* 4 (bw-noise .5 1)) (wave 1 0)))))");
    Genome::from(picture.unwrap_or(Node::X))
}

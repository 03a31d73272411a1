//! What a trial showed.
//!
//! Owns the figures that rules are compared by. Never runs a trial.
//!
//! Start at [`Outcome`].

use std::collections::BTreeSet;

use breeding::{Id, Traits};
use serde::Serialize;

use super::world::{Genes, World};

/// The broods after which the taste is noted.
const NOTED: [usize; 3] = [10, 20, 40];

/// What happened in one world.
#[derive(Clone, Debug, Default)]
pub(crate) struct Course {
    /// The mean percentile of the living among random genomes after 10, 20 and 40 broods.
    pub(crate) percentiles: [f64; 3],
    /// The mean distance of the living from each other after 40 broods, as a part of that of random sheep.
    pub(crate) diversity: f64,
    /// Founding families after 40 broods.
    pub(crate) families: usize,
    /// The living after 40 broods.
    pub(crate) living: usize,
}

/// What happened in many worlds.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Outcome {
    /// The mean of the worlds' percentiles after 10, 20 and 40 broods.
    pub(crate) percentiles: [f64; 3],
    /// The least of them after 20 broods.
    pub(crate) worst: f64,
    /// The mean diversity after 40 broods.
    pub(crate) diversity: f64,
    /// The mean of founding families after 40 broods.
    pub(crate) families: f64,
    /// The mean of the living after 40 broods.
    pub(crate) living: f64,
}

impl Course {
    pub(super) fn note(&mut self, brood: usize, world: &World, sheep: &[(&Genes, &Traits, Id)]) {
        let Some(at) = NOTED.iter().position(|noted| *noted == brood) else { return };
        let sum: f64 = sheep.iter().map(|(genes, ..)| world.percentile(genes)).sum();
        self.percentiles[at] = sum / sheep.len().max(1) as f64;
        self.diversity = world.diversity(&sheep.iter().map(|(_, figures, _)| *figures).collect::<Vec<_>>());
        self.families = sheep.iter().map(|(_, _, family)| family).collect::<BTreeSet<_>>().len();
        self.living = sheep.len();
    }
}

impl Outcome {
    pub(super) fn of(courses: &[Course]) -> Outcome {
        let mean =
            |value: &dyn Fn(&Course) -> f64| courses.iter().map(value).sum::<f64>() / courses.len().max(1) as f64;
        Outcome {
            percentiles: [0, 1, 2].map(|at| mean(&|course| course.percentiles[at])),
            worst: courses.iter().map(|course| course.percentiles[1]).fold(1.0, f64::min),
            diversity: mean(&|course| course.diversity),
            families: mean(&|course| course.families as f64),
            living: mean(&|course| course.living as f64),
        }
    }
}

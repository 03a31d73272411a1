//! What is wanted of each sheep, in the measure of a balance and in visits.
//!
//! Owns the conversion: a sheep whose loop is shown for twice as long needs half of the visits for the same time. A sheep
//! without a loop has no time: any number of visits is fine.
//!
//! Start at [`Wants::of`].

use crate::flock::{Flock, Measure, time_want};
use crate::graph::{Graph, SheepIx};
use crate::manifest::Sheep;

/// No want counts for less than this part of the largest: a visit in millions of years.
const MIN_WANT: f64 = 1e-12;

/// The wants of the sheep of a graph, by their ordinals.
#[derive(Clone, Debug)]
pub(super) struct Wants {
    /// In the measure of the balance; they sum to 1. 0 where nothing is wanted.
    pub(super) shares: Vec<f64>,
    /// The visits that this amounts to, relative to each other, above 0; a mean one where nothing is wanted.
    pub(super) visits: Vec<f64>,
}

impl Wants {
    /// What `flock` wants of the sheep of `graph`, its own or a part of it, in `measure`.
    pub(super) fn of(flock: &Flock, graph: &Graph, measure: Measure) -> Self {
        let written = |at: SheepIx| &flock.manifest().sheep[graph.sheep_in_manifest(at)];
        if measure == Measure::Visits {
            let shares = parts(&graph.sheep().map(|at| written(at).want).collect::<Vec<_>>());
            return Self { visits: shares.clone(), shares };
        }
        let (timed, free): (Vec<SheepIx>, Vec<SheepIx>) = graph.sheep().partition(|&at| time_want(written(at)) > 0.0);
        let most = timed.iter().map(|&at| time_want(written(at))).fold(0.0, f64::max);
        let each = timed.iter().map(|&at| time_want(written(at)) / most / visit_frames(written(at)));
        let visits = parts(&each.collect::<Vec<_>>());
        let all: f64 = visits.iter().zip(&timed).map(|(visits, &at)| visits * visit_frames(written(at))).sum();
        let mut wants = Self { shares: vec![0.0; graph.len()], visits: vec![0.0; graph.len()] };
        for (&at, visits) in timed.iter().zip(visits) {
            wants.shares[at.index()] = visits * visit_frames(written(at)) / all;
            wants.visits[at.index()] = visits;
        }
        for at in free {
            wants.visits[at.index()] = 1.0 / graph.len() as f64;
        }
        wants
    }

    /// The wants of the sheep `at` these places alone.
    pub(super) fn only(&self, at: &[usize]) -> Self {
        let total: f64 = at.iter().map(|&at| self.shares[at]).sum();
        let shares = at.iter().map(|&at| if total > 0.0 { self.shares[at] / total } else { 0.0 }).collect();
        Self { shares, visits: at.iter().map(|&at| self.visits[at]).collect() }
    }

    /// The visits that are wanted of the sheep `at`: 0 if nothing is.
    pub(super) fn wanted_visits(&self, at: usize) -> f64 {
        if self.shares[at] > 0.0 { self.visits[at] } else { 0.0 }
    }
}

/// How many frames a visit of `sheep` shows of its loop; 0 without one.
pub(super) fn visit_frames(sheep: &Sheep) -> f64 {
    sheep.clip.as_ref().map_or(0.0, |clip| f64::from(clip.frames.0) * f64::from(sheep.repeat))
}

/// The positive `figures` as parts of their sum, which may be infinite.
pub(super) fn parts(figures: &[f64]) -> Vec<f64> {
    let most = figures.iter().copied().fold(0.0, f64::max);
    let parts: Vec<f64> = figures.iter().map(|figure| (figure / most).max(MIN_WANT)).collect();
    let total: f64 = parts.iter().sum();
    parts.into_iter().map(|part| part / total).collect()
}

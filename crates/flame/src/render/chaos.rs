//! The chaos game.
//!
//! Owns the orbits: numbered batches of samples, each a pure function of the plan, the seed and its number. Threads
//! share no counter: `histogram.rs` collects.
//!
//! Start at [`Batches::run`].

use super::histogram::Tile;
use super::plan::{Plan, has_escaped};
use crate::rng::Rng;

/// Samples in a batch. Each batch starts a new orbit, so that all parts of a flame with several attractors are drawn.
const BATCH: u64 = 10_000;

/// Steps before an orbit is on the attractor; they are not seen.
const FUSE: u32 = 20;

/// How often in a row an escaped orbit is restarted before its point counts as a sample.
const MAX_RESTARTS: u32 = 5;

/// All samples of a frame, cut into numbered batches.
#[derive(Debug)]
pub(crate) struct Batches<'a> {
    plans: &'a [Plan],
    /// Samples of one plan; the last batch of a plan is shorter.
    each: u64,
    /// Batches of one plan.
    per_plan: u64,
    seed: u64,
}

impl<'a> Batches<'a> {
    /// Cuts `total` samples, shared evenly by `plans`, into batches.
    pub(crate) fn new(plans: &'a [Plan], total: u64, seed: u64) -> Batches<'a> {
        let each = total.div_ceil(plans.len() as u64);
        Batches { plans, each, per_plan: each.div_ceil(BATCH), seed }
    }

    /// How many batches there are.
    pub(crate) fn count(&self) -> u64 {
        self.per_plan * self.plans.len() as u64
    }

    /// How many samples all of them have.
    pub(crate) fn samples(&self) -> u64 {
        self.each * self.plans.len() as u64
    }

    /// How many samples a batch has at most.
    pub(crate) fn max_samples(&self) -> u64 {
        BATCH.min(self.each)
    }

    /// Draws batch `number` into `tile`.
    pub(crate) fn run(&self, number: u64, tile: &mut Tile) {
        let within = number % self.per_plan;
        let samples = BATCH.min(self.each - within * BATCH);
        let plan = &self.plans[(number / self.per_plan) as usize];
        Orbit::new(Rng::stream(self.seed, number)).run(plan, samples, tile);
    }
}

/// A point on its way.
#[derive(Clone, Debug)]
struct Orbit {
    x: f64,
    y: f64,
    colour: f64,
    last: usize,
    rng: Rng,
}

impl Orbit {
    fn new(mut rng: Rng) -> Orbit {
        Orbit { x: rng.signed(), y: rng.signed(), colour: rng.unit(), last: 0, rng }
    }

    fn run(mut self, plan: &Plan, samples: u64, tile: &mut Tile) {
        self.last = plan.next(0, &mut self.rng);
        for _ in 0..FUSE {
            self.step(plan);
        }
        for _ in 0..samples {
            self.step(plan);
            self.plot(plan, tile);
        }
    }

    /// One step of the game. An orbit that escapes is restarted at a random point.
    #[inline]
    fn step(&mut self, plan: &Plan) {
        for throw in 1.. {
            let next = plan.next(self.last, &mut self.rng);
            let chosen = &plan.moves[next];
            (self.x, self.y) = chosen.point(self.x, self.y, &mut self.rng);
            self.colour = chosen.colour(self.colour);
            if has_escaped(self.x, self.y) {
                (self.x, self.y) = (self.rng.signed(), self.rng.signed());
                if throw < MAX_RESTARTS {
                    continue;
                }
            }
            self.last = next;
            return;
        }
    }

    #[inline]
    fn plot(&mut self, plan: &Plan, tile: &mut Tile) {
        let visibility = plan.moves[self.last].visibility;
        let (mut x, mut y, mut colour) = (self.x, self.y, self.colour);
        if let Some(lens) = &plan.lens
            && (lens.opacity == 1.0 || self.rng.unit() < lens.opacity)
        {
            (x, y) = lens.point(x, y, &mut self.rng);
            colour = lens.colour(colour);
            if has_escaped(x, y) {
                (x, y) = (self.rng.signed(), self.rng.signed());
            }
        }
        let (across, down) = plan.view.to_cells.apply(x, y);
        let [width, height] = plan.view.cells;
        if !(across >= 0.0 && down >= 0.0 && across < width as f64 && down < height as f64) {
            return;
        }
        let cell = down as usize * width + across as usize;
        let entry = (colour * plan.colours.len() as f64) as usize;
        let light = plan.colours[entry.min(plan.colours.len() - 1)];
        if visibility == 1.0 {
            tile.add(cell, light);
        } else if visibility > 0.0 {
            let round = self.rng.unit();
            tile.add(cell, light.map(|channel| (f64::from(channel) * visibility + round) as u32));
        }
    }
}

//! The chaos game with one orbit in `f64`.
//!
//! Owns the reference that `pool.rs` is compared with. It also draws what is so deep in a flame that `f32` does not tell
//! neighbouring cells apart.
//!
//! Start at [`Reference`].

use std::sync::atomic::{AtomicBool, Ordering};

use super::bins::Bins;
use super::draw::Game;
use super::plan::{CompiledXform, Plan};
use super::pool::ORBITS;
use super::shot::{ENTRIES, FUSE, Shot};
use crate::variations::{Compiled, Formula, Visitor};
use species::Rng;

/// Steps of a shot that an orbit takes part in: 8,192 samples.
const STEPS: u64 = 4;

/// A point on its way.
#[derive(Clone, Debug)]
struct Orbit {
    x: f64,
    y: f64,
    colour: f64,
    last: usize,
    rng: Rng,
}

/// The game with one orbit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reference;

impl Game for Reference {
    fn play(&mut self, shot: &Shot, number: u64, bins: &mut Bins, stop: &AtomicBool) -> u64 {
        let mut orbit = Orbit::new(Rng::stream(shot.seed, number));
        let mut samples = 0;
        let steps = shot.steps(number);
        for step in steps.clone() {
            let plan = shot.plan(step);
            if (step - steps.start).is_multiple_of(STEPS) {
                orbit = Orbit::new(orbit.rng);
                for _ in 0..FUSE {
                    orbit.step(plan);
                }
            }
            for _ in 0..ORBITS {
                if orbit.step(plan) {
                    samples += 1;
                    orbit.plot(plan, bins);
                }
            }
            if stop.load(Ordering::Relaxed) {
                break;
            }
        }
        samples
    }
}

impl Orbit {
    fn new(mut rng: Rng) -> Orbit {
        Orbit { x: rng.signed(), y: rng.signed(), colour: rng.unit(), last: 0, rng }
    }

    /// One step of the game. An orbit that escapes goes on at a random point: there is no sample of it.
    #[inline]
    fn step(&mut self, plan: &Plan) -> bool {
        let drawn = (self.rng.bits() >> 32) as u32;
        self.last = plan.thresholds(self.last).iter().map(|threshold| usize::from(drawn >= *threshold)).sum();
        let chosen = &plan.moves[self.last];
        (self.x, self.y) = image(chosen, self.x, self.y, &mut self.rng);
        self.colour = chosen.keep * self.colour + chosen.pull;
        let escapes = has_escaped(self.x, self.y);
        if escapes {
            (self.x, self.y) = (self.rng.signed(), self.rng.signed());
        }
        !escapes
    }

    /// Where the point is seen, and its colour; none if this sample is not drawn.
    #[inline]
    fn seen(&mut self, plan: &Plan) -> Option<(f64, f64, f64)> {
        let chosen = &plan.moves[self.last];
        if chosen.part < 1.0 && self.rng.unit() >= chosen.part {
            return None;
        }
        let (mut x, mut y, mut colour) = (self.x, self.y, self.colour);
        if let Some(lens) = &plan.lens
            && (lens.opacity == 1.0 || self.rng.unit() < lens.opacity)
        {
            (x, y) = image(lens, x, y, &mut self.rng);
            colour = lens.keep * colour + lens.pull;
            if has_escaped(x, y) {
                (x, y) = (self.rng.signed(), self.rng.signed());
            }
        }
        Some((x, y, colour))
    }

    #[inline]
    fn plot(&mut self, plan: &Plan, bins: &mut Bins) {
        let Some((x, y, colour)) = self.seen(plan) else { return };
        let (across, down) = plan.to_cells.apply(x, y);
        let [width, height] = plan.cells;
        if !(across >= 0.0 && down >= 0.0 && across < width as f64 && down < height as f64) {
            return;
        }
        let cell = down as usize * width + across as usize;
        let entry = ((colour * ENTRIES as f64) as usize).min(ENTRIES - 1);
        bins.add(cell as u32, plan.first_entry(self.last) + entry as u32);
    }
}

/// At most `count` points that are seen, of orbits that are as short as those of a shot.
pub(crate) fn points(plan: &Plan, count: usize, seed: u64) -> Vec<[f64; 2]> {
    let mut orbit = Orbit::new(Rng::stream(seed, 0));
    let mut found = Vec::with_capacity(count);
    for step in 0..count {
        if (step as u64).is_multiple_of(STEPS * ORBITS as u64) {
            orbit = Orbit::new(orbit.rng);
            for _ in 0..FUSE {
                orbit.step(plan);
            }
        }
        if orbit.step(plan)
            && let Some((x, y, _)) = orbit.seen(plan)
        {
            found.push([x, y]);
        }
    }
    found
}

/// The image of a point; it may be anything, see [`has_escaped`].
#[inline]
fn image(xform: &CompiledXform, x: f64, y: f64, rng: &mut Rng) -> (f64, f64) {
    let (x, y) = xform.affine.apply(x, y);
    let added = sum(&xform.before, x, y, rng);
    let sum = sum(&xform.variations, x + added.0, y + added.1, rng);
    xform.post.map_or(sum, |post| post.apply(sum.0, sum.1))
}

/// What `variations` make of a point together.
#[inline]
fn sum(variations: &[Compiled], x: f64, y: f64, rng: &mut Rng) -> (f64, f64) {
    let mut sum = (0.0, 0.0);
    for variation in variations {
        let apply = variation.kind.visit(ForOnePoint);
        let part = apply(variation, x, y, rng);
        sum = (sum.0 + part.0, sum.1 + part.1);
    }
    sum
}

/// Whether a point has left the plane.
#[inline]
fn has_escaped(x: f64, y: f64) -> bool {
    let is_out_of_range = |value: f64| value.is_nan() || value.abs() > 1e10;
    is_out_of_range(x) || is_out_of_range(y)
}

/// A formula for one point.
///
/// It is called through a pointer and never inlined: in a loop over variations the compiler would move every sine that
/// any formula might want out in front of it (measured: three times slower).
type Apply = fn(&Compiled, f64, f64, &mut Rng) -> (f64, f64);

/// Asks a formula for its [`Apply`].
struct ForOnePoint;

impl Visitor for ForOnePoint {
    type Out = Apply;

    #[inline]
    fn visit<F: Formula>(self) -> Apply {
        F::at::<f64, Rng>
    }
}

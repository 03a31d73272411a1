//! The chaos game with one orbit in `f64`.
//!
//! Owns the reference that `pool.rs` is compared with. It also draws what is so deep in a flame that `f32` does not tell
//! neighbouring cells apart.
//!
//! Start at [`Reference`].

use std::sync::atomic::{AtomicBool, Ordering};

use super::bins::Bins;
use super::draw::Game;
use super::escape::{LIMIT, ROUND};
use super::plan::{CompiledXform, MOST_COLOUR, Passed, Plan, Summand};
use super::pool::ORBITS;
use super::shot::{FUSE, Shot};
use species::Rng;
use variations::{Coloured, Compiled, Formula, Visitor};

/// Steps of a shot that an orbit takes part in: 8,192 samples.
const STEPS: u64 = 4;

/// A point on its way.
#[derive(Clone, Debug)]
struct Orbit {
    point: [f64; 3],
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
                orbit.begin(plan, shot.fuse);
            }
            for sample in 0..ORBITS as u64 {
                let looks = plan.begins_again < 1.0 && (step * ORBITS as u64 + sample).is_multiple_of(ROUND);
                if looks && !has_place(orbit.point) {
                    orbit.begin(plan, shot.fuse);
                }
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
        Orbit { point: [rng.signed(), rng.signed(), 0.0], colour: rng.unit(), last: 0, rng }
    }

    /// Begins again at a random point, with steps that are not seen.
    fn begin(&mut self, plan: &Plan, fuse: u64) {
        *self = Orbit::new(self.rng.clone());
        for _ in 0..fuse {
            self.step(plan);
        }
    }

    /// One step of the game. Returns whether it makes a sample: an orbit that escapes makes none, see `escape.rs`.
    #[inline]
    fn step(&mut self, plan: &Plan) -> bool {
        let drawn = (self.rng.bits() >> 32) as u32;
        self.last = plan.thresholds(self.last).iter().map(|threshold| usize::from(drawn >= *threshold)).sum();
        let chosen = &plan.moves[self.last];
        (self.point, self.colour) = image(chosen, self.point, self.colour, plan.has_z, &mut self.rng);
        let begins = self.begins_again(plan, self.point);
        if begins {
            self.point = self.random_point();
        }
        !begins && has_place(self.point)
    }

    /// Whether the orbit, at `point`, has escaped and begins again.
    #[inline]
    fn begins_again(&mut self, plan: &Plan, point: [f64; 3]) -> bool {
        has_escaped(point) && (plan.begins_again == 1.0 || self.rng.unit() < plan.begins_again)
    }

    fn random_point(&mut self) -> [f64; 3] {
        [self.rng.signed(), self.rng.signed(), 0.0]
    }

    /// Where the point is seen, and its colour; none if this sample is not drawn.
    #[inline]
    fn seen(&mut self, plan: &Plan) -> Option<(f64, f64, f64)> {
        let chosen = &plan.moves[self.last];
        if chosen.part < 1.0 && self.rng.unit() >= chosen.part {
            return None;
        }
        let (mut point, mut colour) = (self.point, self.colour);
        for lens in &plan.lenses {
            if lens.opacity == 1.0 || self.rng.unit() < lens.opacity {
                (point, colour) = image(lens, point, colour, plan.has_z, &mut self.rng);
                if self.begins_again(plan, point) {
                    point = self.random_point();
                }
            }
        }
        let [x, y, _] = point;
        let (x, y) = plan.projection.map_or((x, y), |projection| projection.apply(point, &mut self.rng));
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
        let entry = ((colour * f64::from(plan.entries)) as u32).min(plan.entries - 1);
        bins.add(cell as u32, plan.first_entry(self.last) + entry);
    }
}

/// At most `count` points that are seen, of orbits that are as short as those of a shot.
pub(crate) fn points(plan: &Plan, count: usize, seed: u64) -> Vec<[f64; 2]> {
    let mut orbit = Orbit::new(Rng::stream(seed, 0));
    let mut found = Vec::with_capacity(count);
    for step in 0..count {
        if (step as u64).is_multiple_of(STEPS * ORBITS as u64) {
            orbit.begin(plan, FUSE);
        }
        if orbit.step(plan)
            && let Some((x, y, _)) = orbit.seen(plan)
        {
            found.push([x, y]);
        }
    }
    found
}

/// The image of a point, and its colour; it may be anything, see [`has_escaped`].
#[inline]
pub(super) fn image(
    xform: &CompiledXform,
    [x, y, z]: [f64; 3],
    colour: f64,
    has_z: bool,
    rng: &mut Rng,
) -> ([f64; 3], f64) {
    let (x, y) = xform.affine.apply(x, y);
    let mut point = tilted(xform.tilt.as_ref(), [x, y, z]);
    let mut way = Way { colour: xform.keep * colour + xform.pull, has_z, rng };
    for passed in &xform.before {
        point = way.passed_on(passed, point);
    }
    let mut sum = [0.0; 3];
    for summand in &xform.variations {
        sum = match summand {
            Summand::Plain(variation) => added(sum, way.part(variation, 1.0, point, sum)),
            Summand::Part { variation, presence } => {
                added(sum, way.part(variation, *presence, point, sum).map(|axis| axis * presence))
            }
            Summand::Running(passed) => way.passed_on(passed, sum),
            Summand::Carried(share) => added(sum, [0.0, 0.0, share * point[2]]),
        };
    }
    for passed in &xform.after {
        sum = way.passed_on(passed, sum);
    }
    let [x, y, z] = sum;
    let (x, y) = xform.post.map_or((x, y), |post| post.apply(x, y));
    (tilted(xform.post_tilt.as_ref(), [x, y, z]), way.colour)
}

/// The image of a point under an affine map of space, if there is one.
#[inline]
fn tilted(rows: Option<&[[f64; 4]; 3]>, [x, y, z]: [f64; 3]) -> [f64; 3] {
    rows.map_or([x, y, z], |rows| rows.map(|[a, b, c, d]| a * x + b * y + c * z + d))
}

/// A point on its way through a transform.
struct Way<'a> {
    colour: f64,
    has_z: bool,
    rng: &'a mut Rng,
}

impl Way<'_> {
    /// What becomes of `point` by a variation that replaces it, or is added to it.
    #[inline]
    fn passed_on(&mut self, passed: &Passed, point: [f64; 3]) -> [f64; 3] {
        let share = passed.presence.unwrap_or(1.0);
        let mut result = self.part(&passed.variation, share, point, [0.0; 3]);
        let Some(presence) = passed.presence else { return added(point, result) };
        for axis in 0..3 {
            result[axis] = point[axis] + (result[axis] - point[axis]) * presence;
        }
        if let Some(factor) = passed.depth_factor {
            result[2] = point[2] * factor;
        }
        result
    }

    /// What a variation makes of a point, after what others gave. The colour becomes its own by `presence`.
    #[inline]
    fn part(&mut self, variation: &Compiled, presence: f64, point: [f64; 3], sum: [f64; 3]) -> [f64; 3] {
        if variation.is_in_colour {
            let from = Coloured { point, sum, colour: self.colour };
            let ([x, y, z], colour) = variation.kind.visit(ForOnePointInColour)(variation, from, self.rng);
            // An orbit that is lost keeps its colour.
            if colour.abs() < MOST_COLOUR {
                self.colour += (colour - self.colour) * presence;
            }
            return if self.has_z { [x, y, z] } else { [x, y, 0.0] };
        }
        if self.has_z {
            return variation.kind.visit(ForOnePointInSpace)(variation, point, self.rng);
        }
        let (x, y) = variation.kind.visit(ForOnePoint)(variation, point[0], point[1], self.rng);
        [x, y, 0.0]
    }
}

fn added(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|axis| a[axis] + b[axis])
}

/// Whether a point has left the space.
#[inline]
fn has_escaped(point: [f64; 3]) -> bool {
    point.into_iter().any(|value| value.is_nan() || value.abs() > LIMIT)
}

/// Whether a point is anywhere.
#[inline]
fn has_place(point: [f64; 3]) -> bool {
    point.into_iter().all(f64::is_finite)
}

/// A formula for one point.
///
/// It is called through a pointer and never inlined: in a loop over variations the compiler would move every sine that
/// any formula might want out in front of it (measured: three times slower).
type Apply = fn(&Compiled, f64, f64, &mut Rng) -> (f64, f64);

/// The same in space.
type ApplyInSpace = fn(&Compiled, [f64; 3], &mut Rng) -> [f64; 3];

/// The same in colour.
type ApplyInColour = fn(&Compiled, Coloured<f64>, &mut Rng) -> ([f64; 3], f64);

/// Asks a formula for its [`Apply`].
struct ForOnePoint;

impl Visitor for ForOnePoint {
    type Out = Apply;

    #[inline]
    fn visit<F: Formula>(self) -> Apply {
        F::at::<f64, Rng>
    }
}

/// Asks a formula for its [`ApplyInSpace`].
struct ForOnePointInSpace;

impl Visitor for ForOnePointInSpace {
    type Out = ApplyInSpace;

    #[inline]
    fn visit<F: Formula>(self) -> ApplyInSpace {
        F::in_space::<f64, Rng>
    }
}

/// Asks a formula for its [`ApplyInColour`].
struct ForOnePointInColour;

impl Visitor for ForOnePointInColour {
    type Out = ApplyInColour;

    #[inline]
    fn visit<F: Formula>(self) -> ApplyInColour {
        F::in_colour::<f64, Rng>
    }
}

//! The chaos game with many orbits at a time.
//!
//! Owns a pool of orbits, kept as arrays of coordinates. In each step every orbit draws its next transform; orbits are
//! then put in order by it, so that each transform runs over a group of neighbours, sixteen at once. What a pool draws
//! is a pure function of the shot, the seed and the pool's number, the same bits for every instruction set.
//!
//! Start at [`Pool`]; `stages.rs` sends a group through a transform, `escape.rs` has what becomes of orbits that leave the
//! space. `chaos.rs` plays the same game with one orbit in `f64`.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask, f32x16, mask32x16, u32x16};

use super::bins::Bins;
use super::draw::Game;
use super::escape::ROUND;
use super::plan::{CompiledXform, Plan};
use super::shot::Shot;
use crate::genome::{Affine, Genome};
use species::Rng;
use variations::number::{LANES, LaneRng, Lanes, Number, Random};

/// Orbits of a pool.
pub(crate) const ORBITS: usize = 2048;

/// Vectors of a pool: each group begins a new one.
const VECTORS: usize = ORBITS / LANES + Genome::MAX_XFORMS;

/// What the arrays of a pool take in memory.
pub(crate) const BYTES: u64 = (19 * size_of::<[[f32; LANES]; VECTORS]>() + 2 * size_of::<[f32; ORBITS]>()) as u64;

/// A number for each place of a pool.
pub(super) type Places<T> = Box<[[T; LANES]; VECTORS]>;

/// Orbits on their way.
pub(crate) struct Pool<S: Simd> {
    pub(super) simd: S,
    pub(super) random: LaneRng<S>,
    /// What `f64` draws where `f32` has no room.
    pub(super) scalar: Rng,
    /// Where they are, in groups by the transform that they went through last.
    pub(super) now: Orbits,
    /// Where they are, in groups by the transform that they go through next.
    pub(super) next: Orbits,
    groups: Vec<Group>,
    /// The number of the next transform, for orbits in groups one after the other.
    choices: Places<u32>,
    /// Which places of each vector escaped in this step.
    escaped: Box<[u16; VECTORS]>,
    /// What a transform's variations read, and what they add up to.
    pub(super) points: [Places<f32>; 3],
    pub(super) sums: [Places<f32>; 3],
    /// The points, while a variation is applied to the sums.
    pub(super) held: [Places<f32>; 3],
    /// The colours, while variations change them.
    pub(super) colours: Places<f32>,
    /// What was plotted in a step: cells and palette entries.
    plotted: [Vec<u32>; 2],
    /// Samples drawn so far.
    samples: u64,
    /// The part of orbits that begin again where they escape.
    pub(super) begins_again: f64,
}

/// Coordinates and colours of a pool's orbits. Where points have no z, it is 0.
pub(super) struct Orbits {
    pub(super) x: Places<f32>,
    pub(super) y: Places<f32>,
    pub(super) z: Places<f32>,
    pub(super) colour: Places<f32>,
}

/// Orbits that went through the same transform: some vectors, of which the last may be filled in part.
#[derive(Clone, Copy, Debug)]
pub(super) struct Group {
    first: usize,
    orbits: usize,
}

impl Group {
    pub(super) fn vectors(self) -> Range<usize> {
        self.first..self.first + self.orbits.div_ceil(LANES)
    }

    /// Which places of `vector` belong to the group, a bit for each.
    #[inline(always)]
    fn live(self, vector: usize) -> u64 {
        let left = self.orbits - (vector - self.first) * LANES;
        if left >= LANES { (1 << LANES) - 1 } else { (1 << left) - 1 }
    }
}

#[expect(clippy::unnecessary_box_returns, reason = "an array of this size does not belong on the stack")]
fn places<T: Copy + Default>() -> Places<T> {
    let vectors = vec![[T::default(); LANES]; VECTORS].into_boxed_slice();
    vectors.try_into().unwrap_or_else(|_| unreachable!("it has as many vectors as a pool"))
}

impl Orbits {
    fn new() -> Orbits {
        Orbits { x: places(), y: places(), z: places(), colour: places() }
    }
}

impl<S: Simd> Pool<S> {
    /// A pool whose orbits have not begun.
    pub(crate) fn new(simd: S) -> Pool<S> {
        Pool {
            simd,
            random: LaneRng::stream(simd, 0, 0),
            now: Orbits::new(),
            next: Orbits::new(),
            groups: Vec::new(),
            choices: places(),
            escaped: Box::new([0; VECTORS]),
            points: [places(), places(), places()],
            sums: [places(), places(), places()],
            held: [places(), places(), places()],
            colours: places(),
            plotted: [vec![0; ORBITS + LANES], vec![0; ORBITS + LANES]],
            samples: 0,
            scalar: Rng::stream(0, 0),
            begins_again: 1.0,
        }
    }

    /// Puts all orbits at random points.
    #[inline(always)]
    fn begin(&mut self, seed: u64, number: u64) {
        self.random = LaneRng::stream(self.simd, seed, number);
        self.scalar = Rng::stream(!seed, number);
        // What lies between groups is calculated, too: it must not depend on what this pool did before.
        for orbits in [&mut self.now, &mut self.next] {
            for places in [&mut orbits.x, &mut orbits.y, &mut orbits.z, &mut orbits.colour] {
                places.as_flattened_mut().fill(0.0);
            }
        }
        self.groups.clear();
        self.groups.push(Group { first: 0, orbits: ORBITS });
        for vector in 0..ORBITS / LANES {
            let (x, y) = (signed(&mut self.random), signed(&mut self.random));
            let colour: Lanes<S> = self.random.unit();
            x.0.store_array(&mut self.now.x[vector]);
            y.0.store_array(&mut self.now.y[vector]);
            colour.0.store_array(&mut self.now.colour[vector]);
        }
    }

    /// Every orbit goes through a transform.
    #[inline(always)]
    fn step<const HAS_Z: bool>(&mut self, plan: &Plan) {
        self.begins_again = plan.begins_again;
        self.choose::<HAS_Z>(plan);
        for number in 0..self.groups.len() {
            if self.groups[number].orbits > 0 {
                self.transform::<HAS_Z>(&plan.moves[number], self.groups[number]);
            }
        }
    }

    /// Draws the next transform of each orbit, and puts orbits in order by it.
    #[inline(always)]
    fn choose<const HAS_Z: bool>(&mut self, plan: &Plan) {
        let simd = self.simd;
        let moves = plan.moves.len();
        // How many orbits drew this transform or one after it.
        let mut at_least = [0_usize; Genome::MAX_XFORMS + 1];
        at_least[0] = ORBITS;
        let mut to = 0;
        for (from, group) in self.groups.iter().enumerate() {
            let thresholds = plan.thresholds(from);
            for vector in group.vectors() {
                let live = group.live(vector);
                let drawn = self.random.bits();
                let mut choice = u32x16::splat(simd, 0);
                for (threshold, at_least) in thresholds.iter().zip(&mut at_least[1..]) {
                    let beyond = drawn.simd_ge(u32x16::splat(simd, *threshold));
                    *at_least += (beyond.to_bitmask() & live).count_ones() as usize;
                    choice = beyond.select(choice + 1, choice);
                }
                choice.store_array(&mut self.choices[to]);
                to += 1;
            }
        }
        let mut place = [0_usize; Genome::MAX_XFORMS];
        let mut first = 0;
        let mut groups = std::mem::take(&mut self.groups);
        let sources = groups.clone();
        groups.clear();
        for number in 0..moves {
            let orbits = at_least[number] - at_least[number + 1];
            groups.push(Group { first, orbits });
            place[number] = first * LANES;
            first += orbits.div_ceil(LANES);
        }
        self.groups = groups;
        self.move_to::<HAS_Z>(&sources, &mut place);
    }

    /// Moves every orbit to the next place of its transform.
    #[inline(always)]
    fn move_to<const HAS_Z: bool>(&mut self, sources: &[Group], place: &mut [usize; Genome::MAX_XFORMS]) {
        let Orbits { x, y, z, colour } = &mut self.next;
        let [x, y, z, colour] = [x, y, z, colour].map(|places| places.as_flattened_mut());
        let mut from = 0;
        for group in sources {
            for vector in group.vectors() {
                let lanes = (group.orbits - (vector - group.first) * LANES).min(LANES);
                let choices = &self.choices[from];
                from += 1;
                for lane in 0..lanes {
                    let to = &mut place[choices[lane] as usize & (Genome::MAX_XFORMS - 1)];
                    x[*to] = self.now.x[vector][lane];
                    y[*to] = self.now.y[vector][lane];
                    if HAS_Z {
                        z[*to] = self.now.z[vector][lane];
                    }
                    colour[*to] = self.now.colour[vector][lane];
                    *to += 1;
                }
            }
        }
    }

    /// Sends a group through its transform.
    #[inline(always)]
    fn transform<const HAS_Z: bool>(&mut self, chosen: &CompiledXform, group: Group) {
        self.enter::<HAS_Z>(chosen, group);
        for vector in group.vectors() {
            let (x, y) = self.leave::<HAS_Z>(chosen, vector);
            let ([x, y], escaped) = self.kept::<HAS_Z>(chosen, [x, y], vector);
            if HAS_Z {
                self.now.z[vector] = self.sums[2][vector];
            }
            let escaped = escaped.to_bitmask();
            self.escaped[vector] = escaped as u16;
            self.samples += u64::from((group.live(vector) & !escaped).count_ones());
            let colour = self.coloured(chosen, vector);
            x.0.store_array(&mut self.now.x[vector]);
            y.0.store_array(&mut self.now.y[vector]);
            colour.0.store_array(&mut self.now.colour[vector]);
        }
    }

    /// The colours after a transform.
    #[inline(always)]
    fn coloured(&self, chosen: &CompiledXform, vector: usize) -> Lanes<S> {
        if chosen.is_in_colour {
            return Lanes(f32x16::load_array_ref(self.simd, &self.colours[vector]));
        }
        self.pulled(chosen, vector)
    }

    /// The colours after a transform whose variations do not change them.
    #[inline(always)]
    pub(super) fn pulled(&self, chosen: &CompiledXform, vector: usize) -> Lanes<S> {
        let colour = Lanes(f32x16::load_array_ref(self.simd, &self.next.colour[vector]));
        colour.mul_add(colour.like(chosen.keep), colour.like(chosen.pull))
    }

    /// The affine part after the variations.
    #[inline(always)]
    fn leave<const HAS_Z: bool>(&mut self, chosen: &CompiledXform, vector: usize) -> (Lanes<S>, Lanes<S>) {
        let x = Lanes(f32x16::load_array_ref(self.simd, &self.sums[0][vector]));
        let y = Lanes(f32x16::load_array_ref(self.simd, &self.sums[1][vector]));
        let (mut x, mut y) = chosen.post.as_ref().map_or((x, y), |post| image(post, x, y));
        if HAS_Z && let Some(rows) = &chosen.post_tilt {
            let mut z = Lanes(f32x16::load_array_ref(self.simd, &self.sums[2][vector]));
            [x, y, z] = image_in_space(rows, [x, y, z]);
            z.0.store_array(&mut self.sums[2][vector]);
        }
        (x, y)
    }

    /// Plots every orbit that is in view.
    #[inline(always)]
    fn plot<const HAS_Z: bool>(&mut self, plan: &Plan, bins: &mut Bins) {
        let mut plotted = 0;
        for number in 0..self.groups.len() {
            let (chosen, group) = (&plan.moves[number], self.groups[number]);
            if group.orbits == 0 || chosen.brightness == 0.0 {
                continue;
            }
            if !plan.lenses.is_empty() {
                self.copy::<HAS_Z>(group);
            }
            for lens in &plan.lenses {
                self.see_through::<HAS_Z>(lens, group);
            }
            for vector in group.vectors() {
                plotted = self.place::<HAS_Z>(plan, number, group, vector, plotted);
            }
        }
        let [cells, entries] = &self.plotted;
        for (cell, entry) in cells[..plotted].iter().zip(&entries[..plotted]) {
            bins.add(*cell, *entry);
        }
    }

    /// Copies a group into `next`.
    #[inline(always)]
    fn copy<const HAS_Z: bool>(&mut self, group: Group) {
        for vector in group.vectors() {
            self.next.x[vector] = self.now.x[vector];
            self.next.y[vector] = self.now.y[vector];
            self.next.colour[vector] = self.now.colour[vector];
            if HAS_Z {
                self.next.z[vector] = self.now.z[vector];
            }
        }
    }

    /// Sends the copies of a group through a final transform.
    #[inline(always)]
    fn see_through<const HAS_Z: bool>(&mut self, lens: &CompiledXform, group: Group) {
        self.enter::<HAS_Z>(lens, group);
        for vector in group.vectors() {
            let (x, y) = self.leave::<HAS_Z>(lens, vector);
            let ([mut x, mut y], _) = self.kept::<HAS_Z>(lens, [x, y], vector);
            let before = Lanes(f32x16::load_array_ref(self.simd, &self.next.colour[vector]));
            let mut colour = self.coloured(lens, vector);
            let mut z = Lanes(f32x16::load_array_ref(self.simd, &self.sums[2][vector]));
            if lens.opacity < 1.0 {
                let taken = self.random.unit().less(x.like(lens.opacity));
                x = Lanes::select(taken, x, Lanes(f32x16::load_array_ref(self.simd, &self.next.x[vector])));
                y = Lanes::select(taken, y, Lanes(f32x16::load_array_ref(self.simd, &self.next.y[vector])));
                colour = Lanes::select(taken, colour, before);
                if HAS_Z {
                    z = Lanes::select(taken, z, Lanes(f32x16::load_array_ref(self.simd, &self.next.z[vector])));
                }
            }
            x.0.store_array(&mut self.next.x[vector]);
            y.0.store_array(&mut self.next.y[vector]);
            colour.0.store_array(&mut self.next.colour[vector]);
            if HAS_Z {
                z.0.store_array(&mut self.next.z[vector]);
            }
        }
    }

    /// Writes down in which cells the orbits of a vector are, after the first `plotted` of this step.
    #[inline(always)]
    fn place<const HAS_Z: bool>(
        &mut self,
        plan: &Plan,
        number: usize,
        group: Group,
        vector: usize,
        plotted: usize,
    ) -> usize {
        let simd = self.simd;
        let seen = if plan.lenses.is_empty() { &self.now } else { &self.next };
        let x = Lanes(f32x16::load_array_ref(simd, &seen.x[vector]));
        let y = Lanes(f32x16::load_array_ref(simd, &seen.y[vector]));
        let colour = f32x16::load_array_ref(simd, &seen.colour[vector]);
        let (mut x, mut y) = (x, y);
        if HAS_Z && let Some(projection) = &plan.projection {
            let z = Lanes(f32x16::load_array_ref(simd, &seen.z[vector]));
            (x, y) = projection.apply([x, y, z], &mut self.random);
        }
        let (across, down) = image(&plan.to_cells, x, y);
        let [width, height] = plan.cells;
        let zero = f32x16::splat(simd, 0.0);
        let mut seen = across.0.simd_ge(zero)
            & down.0.simd_ge(zero)
            & across.0.simd_lt(f32x16::splat(simd, width as f32))
            & down.0.simd_lt(f32x16::splat(simd, height as f32));
        let chosen = &plan.moves[number];
        if chosen.part < 1.0 {
            seen &= self.random.unit().less(x.like(chosen.part)).0;
        }
        let bits = seen.to_bitmask() & group.live(vector) & !u64::from(self.escaped[vector]);
        if bits == 0 {
            return plotted;
        }
        let column: u32x16<S> = seen.select(across.0, zero).to_int();
        let row: u32x16<S> = seen.select(down.0, zero).to_int();
        let cell = row * (width as u32) + column;
        let steps = Lanes(colour * plan.entries as f32);
        let steps = steps.max(steps.like(0.0)).min(steps.like(f64::from(plan.entries - 1)));
        let entry: u32x16<S> = steps.0.to_int();
        let entry = entry + plan.first_entry(number);
        let mask = mask32x16::from_bitmask(simd, bits);
        cell.compress(mask).store_slice(&mut self.plotted[0][plotted..plotted + LANES]);
        entry.compress(mask).store_slice(&mut self.plotted[1][plotted..plotted + LANES]);
        plotted + bits.count_ones() as usize
    }
}

impl<S: Simd> Pool<S> {
    /// Draws part `number` of `shot`.
    #[inline(always)]
    fn draw<const HAS_Z: bool>(&mut self, shot: &Shot, number: u64, bins: &mut Bins, stop: &AtomicBool) {
        let steps = shot.steps(number);
        self.begin(shot.seed, number);
        self.settle::<HAS_Z>(shot, steps.start);
        self.samples = 0;
        for step in steps.clone() {
            let plan = shot.plan(step);
            let looks = plan.begins_again < 1.0 && step > steps.start && (step - steps.start).is_multiple_of(ROUND);
            if looks && self.begin_lost() {
                let samples = self.samples;
                self.settle::<HAS_Z>(shot, step);
                self.samples = samples;
            }
            self.step::<HAS_Z>(plan);
            self.plot::<HAS_Z>(plan, bins);
            if stop.load(Ordering::Relaxed) {
                break;
            }
        }
    }

    /// Steps that are not seen, until orbits that have just begun are on the attractor.
    #[inline(always)]
    fn settle<const HAS_Z: bool>(&mut self, shot: &Shot, step: u64) {
        for _ in 0..shot.fuse {
            self.step::<HAS_Z>(shot.plan(step));
        }
    }
}

impl<S: Simd> Game for Pool<S> {
    fn play(&mut self, shot: &Shot, number: u64, bins: &mut Bins, stop: &AtomicBool) -> u64 {
        let simd = self.simd;
        // Two functions: only one of them carries z.
        if shot.has_z {
            simd.vectorize(
                #[inline(always)]
                || self.draw::<true>(shot, number, bins, stop),
            );
        } else {
            simd.vectorize(
                #[inline(always)]
                || self.draw::<false>(shot, number, bins, stop),
            );
        }
        self.samples
    }
}

/// The image of points.
#[inline(always)]
pub(super) fn image<S: Simd>(affine: &Affine, x: Lanes<S>, y: Lanes<S>) -> (Lanes<S>, Lanes<S>) {
    let part = |a: f64, b: f64, c: f64| x.mul_add(x.like(a), y.mul_add(y.like(b), y.like(c)));
    (part(affine.a, affine.b, affine.c), part(affine.d, affine.e, affine.f))
}

/// The image of points under an affine map of space.
#[inline(always)]
pub(super) fn image_in_space<S: Simd>(rows: &[[f64; 4]; 3], [x, y, z]: [Lanes<S>; 3]) -> [Lanes<S>; 3] {
    rows.map(|[a, b, c, d]| x.mul_add(x.like(a), y.mul_add(y.like(b), z.mul_add(z.like(c), z.like(d)))))
}

/// Numbers in `-1.0..1.0`.
#[inline(always)]
pub(super) fn signed<S: Simd>(random: &mut LaneRng<S>) -> Lanes<S> {
    random.unit() * 2.0 - 1.0
}

//! A group of orbits on its way through a transform.
//!
//! Owns the order of its stages: the affine part, what comes before the sum, the sum, what comes after. Never knows where a
//! group came from or where it is plotted.
//!
//! Start at `Pool::enter`.

use fearless_simd::{Simd, SimdBase, f32x16};
use variations::number::{LANES, LaneRng, Lanes, Number};
use variations::{Coloured, Compiled, Depth, Formula, Visitor};

use super::plan::{CompiledXform, MOST_COLOUR, Passed, Summand};
use super::pool::{Group, Places, Pool, image, image_in_space};

impl<S: Simd> Pool<S> {
    /// The affine part before the variations, what these add up to, and what becomes of the sum.
    #[inline(always)]
    pub(super) fn enter<const HAS_Z: bool>(&mut self, chosen: &CompiledXform, group: Group) {
        self.map::<HAS_Z>(chosen, group);
        if chosen.is_in_colour {
            for vector in group.vectors() {
                self.pulled(chosen, vector).0.store_array(&mut self.colours[vector]);
            }
        }
        for passed in &chosen.before {
            self.pass::<HAS_Z>(passed, group);
            std::mem::swap(&mut self.points, &mut self.sums);
            self.clear::<HAS_Z>(group);
        }
        for summand in &chosen.variations {
            match summand {
                Summand::Plain(variation) => self.vary::<HAS_Z>(variation, 1.0, group),
                Summand::Part { variation, presence } => self.vary_in_part::<HAS_Z>(variation, *presence, group),
                Summand::Running(passed) => self.pass_sum::<HAS_Z>(passed, group),
                Summand::Carried(share) => self.carry(*share, group),
            }
        }
        for passed in &chosen.after {
            self.pass_sum::<HAS_Z>(passed, group);
        }
    }

    /// The affine parts, with nothing added up yet.
    #[inline(always)]
    fn map<const HAS_Z: bool>(&mut self, chosen: &CompiledXform, group: Group) {
        let (simd, tilt) = (self.simd, chosen.tilt.as_ref());
        for vector in group.vectors() {
            let x = Lanes(f32x16::load_array_ref(simd, &self.next.x[vector]));
            let y = Lanes(f32x16::load_array_ref(simd, &self.next.y[vector]));
            let (mut x, mut y) = image(&chosen.affine, x, y);
            if HAS_Z {
                let mut z = Lanes(f32x16::load_array_ref(simd, &self.next.z[vector]));
                if let Some(rows) = tilt {
                    [x, y, z] = image_in_space(rows, [x, y, z]);
                }
                z.0.store_array(&mut self.points[2][vector]);
                self.sums[2][vector] = [0.0; LANES];
            }
            x.0.store_array(&mut self.points[0][vector]);
            y.0.store_array(&mut self.points[1][vector]);
            self.sums[0][vector] = [0.0; LANES];
            self.sums[1][vector] = [0.0; LANES];
        }
    }

    /// Empties the sums.
    #[inline(always)]
    fn clear<const HAS_Z: bool>(&mut self, group: Group) {
        for sums in &mut self.sums[..axes::<HAS_Z>()] {
            sums[group.vectors()].fill([0.0; LANES]);
        }
    }

    /// Adds a part of what a variation gives.
    #[inline(always)]
    fn vary_in_part<const HAS_Z: bool>(&mut self, variation: &Compiled, presence: f64, group: Group) {
        if variation.is_in_colour {
            // It reads the sum so far.
            let share = presence;
            return variation.kind.visit(VaryInColour::<_, HAS_Z> { pool: self, variation, presence, share, group });
        }
        std::mem::swap(&mut self.held, &mut self.sums);
        self.clear::<HAS_Z>(group);
        self.vary::<HAS_Z>(variation, presence, group);
        for axis in 0..axes::<HAS_Z>() {
            for vector in group.vectors() {
                let before = Lanes(f32x16::load_array_ref(self.simd, &self.held[axis][vector]));
                let part = Lanes(f32x16::load_array_ref(self.simd, &self.sums[axis][vector]));
                part.mul_add(part.like(presence), before).0.store_array(&mut self.sums[axis][vector]);
            }
        }
    }

    /// Adds so much of z.
    #[inline(always)]
    fn carry(&mut self, share: f64, group: Group) {
        for vector in group.vectors() {
            let z = Lanes(f32x16::load_array_ref(self.simd, &self.points[2][vector]));
            let sum = Lanes(f32x16::load_array_ref(self.simd, &self.sums[2][vector]));
            z.mul_add(z.like(share), sum).0.store_array(&mut self.sums[2][vector]);
        }
    }

    /// Applies a variation to the sums.
    #[inline(always)]
    fn pass_sum<const HAS_Z: bool>(&mut self, passed: &Passed, group: Group) {
        std::mem::swap(&mut self.held, &mut self.points);
        std::mem::swap(&mut self.points, &mut self.sums);
        self.clear::<HAS_Z>(group);
        self.pass::<HAS_Z>(passed, group);
        std::mem::swap(&mut self.points, &mut self.held);
    }

    /// Makes of empty sums what becomes of the points by a variation that replaces them or is added to them.
    #[inline(always)]
    fn pass<const HAS_Z: bool>(&mut self, passed: &Passed, group: Group) {
        self.vary::<HAS_Z>(&passed.variation, passed.presence.unwrap_or(1.0), group);
        for axis in 0..axes::<HAS_Z>() {
            for vector in group.vectors() {
                let point = Lanes(f32x16::load_array_ref(self.simd, &self.points[axis][vector]));
                let result = Lanes(f32x16::load_array_ref(self.simd, &self.sums[axis][vector]));
                let passed = match (passed.presence, passed.depth_factor) {
                    (None, _) => point + result,
                    (Some(_), Some(factor)) if axis == 2 => point * point.like(factor),
                    (Some(1.0), _) => result,
                    (Some(presence), _) => (result - point).mul_add(point.like(presence), point),
                };
                passed.0.store_array(&mut self.sums[axis][vector]);
            }
        }
    }

    /// Adds what a variation gives. A colour becomes its own by `presence`.
    #[inline(always)]
    fn vary<const HAS_Z: bool>(&mut self, variation: &Compiled, presence: f64, group: Group) {
        if variation.is_in_colour {
            return variation.kind.visit(VaryInColour::<_, HAS_Z> {
                pool: self,
                variation,
                presence,
                share: 1.0,
                group,
            });
        }
        let vectors = group.vectors();
        let [x, y, z] = self.points.each_ref().map(|places| &places[vectors.clone()]);
        let [sum_x, sum_y, sum_z] = self.sums.each_mut().map(|places| &mut places[vectors.clone()]);
        let (simd, random) = (self.simd, &mut self.random);
        let flat = Vary { simd, variation, points: (x, y), sums: (sum_x, sum_y), random };
        if HAS_Z {
            variation.kind.visit(VaryInSpace { flat, z, sum_z });
        } else {
            variation.kind.visit(flat);
        }
    }
}

/// How many coordinates a point has.
const fn axes<const HAS_Z: bool>() -> usize {
    if HAS_Z { 3 } else { 2 }
}

/// A variation over the vectors of a group.
struct Vary<'a, S: Simd> {
    simd: S,
    variation: &'a Compiled,
    points: (&'a [[f32; LANES]], &'a [[f32; LANES]]),
    sums: (&'a mut [[f32; LANES]], &'a mut [[f32; LANES]]),
    random: &'a mut LaneRng<S>,
}

impl<S: Simd> Visitor for Vary<'_, S> {
    type Out = ();

    #[inline(always)]
    fn visit<F: Formula>(self) {
        let Vary { simd, variation, points, sums, random } = self;
        // A function of its own for each formula: otherwise all of them would be one.
        simd.vectorize(
            #[inline(always)]
            || {
                // A copy, so that the generators stay in registers.
                let mut own = *random;
                let points = points.0.iter().zip(points.1);
                for ((x, y), (sum_x, sum_y)) in points.zip(sums.0.iter_mut().zip(sums.1)) {
                    let (x, y) = (Lanes(f32x16::load_array_ref(simd, x)), Lanes(f32x16::load_array_ref(simd, y)));
                    let (x, y) = F::at(variation, x, y, &mut own);
                    (f32x16::load_array_ref(simd, sum_x) + x.0).store_array(sum_x);
                    (f32x16::load_array_ref(simd, sum_y) + y.0).store_array(sum_y);
                }
                *random = own;
            },
        );
    }
}

/// A variation in space over the vectors of a group.
struct VaryInSpace<'a, S: Simd> {
    flat: Vary<'a, S>,
    z: &'a [[f32; LANES]],
    sum_z: &'a mut [[f32; LANES]],
}

impl<S: Simd> Visitor for VaryInSpace<'_, S> {
    type Out = ();

    #[inline(always)]
    fn visit<F: Formula>(self) {
        if F::DEPTH == Depth::None {
            // It gives no z.
            return self.flat.visit::<F>();
        }
        let VaryInSpace { flat: Vary { simd, variation, points, sums, random }, z, sum_z } = self;
        simd.vectorize(
            #[inline(always)]
            || {
                let mut own = *random;
                let points = points.0.iter().zip(points.1).zip(z);
                let sums = sums.0.iter_mut().zip(sums.1).zip(sum_z);
                for (((x, y), z), ((sum_x, sum_y), sum_z)) in points.zip(sums) {
                    let point = [x, y, z].map(|places| Lanes(f32x16::load_array_ref(simd, places)));
                    let part = F::in_space(variation, point, &mut own);
                    for (sum, part) in [sum_x, sum_y, sum_z].into_iter().zip(part) {
                        (f32x16::load_array_ref(simd, sum) + part.0).store_array(sum);
                    }
                }
                *random = own;
            },
        );
    }
}

/// A variation in colour over the vectors of a group.
struct VaryInColour<'a, S: Simd, const HAS_Z: bool> {
    pool: &'a mut Pool<S>,
    variation: &'a Compiled,
    /// How far the colour becomes its own.
    presence: f64,
    /// What its part of the sum is multiplied with.
    share: f64,
    group: Group,
}

impl<S: Simd, const HAS_Z: bool> Visitor for VaryInColour<'_, S, HAS_Z> {
    type Out = ();

    #[inline(always)]
    fn visit<F: Formula>(self) {
        let VaryInColour { pool, variation, presence, share, group } = self;
        if !F::IS_IN_COLOUR {
            return;
        }
        let simd = pool.simd;
        simd.vectorize(
            #[inline(always)]
            || {
                let mut own = pool.random;
                for vector in group.vectors() {
                    let mut all = Lanes(f32x16::load_array_ref(simd, &pool.colours[vector]));
                    let load = |places: &[Places<f32>; 3], axis: usize| {
                        if axis < axes::<HAS_Z>() {
                            Lanes(f32x16::load_array_ref(simd, &places[axis][vector]))
                        } else {
                            all.like(0.0)
                        }
                    };
                    let point = [0, 1, 2].map(|axis| load(&pool.points, axis));
                    let sum = [0, 1, 2].map(|axis| load(&pool.sums, axis));
                    let (part, colour) = F::in_colour(variation, Coloured { point, sum, colour: all }, &mut own);
                    // An orbit that is lost keeps its colour.
                    let colour = Lanes::select(colour.abs().less(all.like(MOST_COLOUR)), colour, all);
                    all = (colour - all).mul_add(all.like(presence), all);
                    all.0.store_array(&mut pool.colours[vector]);
                    for axis in 0..axes::<HAS_Z>() {
                        part[axis]
                            .mul_add(part[axis].like(share), sum[axis])
                            .0
                            .store_array(&mut pool.sums[axis][vector]);
                    }
                }
                pool.random = own;
            },
        );
    }
}

//! What a formula is, and what it precomputes per transform.
//!
//! Owns the traits between the formulas and the renderer, and the values that do not depend on the point. The mathematics
//! is in the other files. Never chooses a transform or sums weights over an orbit: `flame` does.
//!
//! Start at [`Formula`].

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::precomputed::of_others;
use super::{Kind, MAX_PARAMETERS, Variation};
use crate::Affine;
use crate::number::{Number, Random};

/// Keeps divisors away from zero, as in flam3.
pub const TINY: f64 = 1e-10;

/// The formula of a variation.
pub trait Formula {
    /// What it does with z.
    const DEPTH: Depth = Depth::None;
    /// Whether it changes the colour.
    const IS_IN_COLOUR: bool = false;

    /// The variation's part of the result for the point `(x, y)` after the affine part, weight included.
    fn at<N: Number, R: Random<N>>(v: &Compiled, x: N, y: N, random: &mut R) -> (N, N);

    /// The same for the point `(x, y, z)`. Its x and y are those of [`Formula::at`] where z is 0.
    #[inline(always)]
    fn in_space<N: Number, R: Random<N>>(v: &Compiled, [x, y, _]: [N; 3], random: &mut R) -> [N; 3] {
        let (x, y) = Self::at(v, x, y, random);
        [x, y, x.like(0.0)]
    }

    /// The same with the point's colour coordinate, of which it makes another: a formula that is in colour is asked for this
    /// alone.
    #[inline(always)]
    fn in_colour<N: Number, R: Random<N>>(v: &Compiled, from: Coloured<N>, random: &mut R) -> ([N; 3], N) {
        (Self::in_space(v, from.point, random), from.colour)
    }
}

/// What a formula in colour reads.
#[derive(Clone, Copy, Debug)]
pub struct Coloured<N> {
    /// The point.
    pub point: [N; 3],
    /// The sum of what other formulas gave so far.
    pub sum: [N; 3],
    /// The colour coordinate.
    pub colour: N,
}

/// What a formula does with z.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// It gives 0, whatever z is.
    None,
    /// It gives a z; x and y do not depend on z.
    Makes,
    /// Its x and y depend on z.
    Reads,
}

/// What is done with a formula that is known only at run time; [`Kind::visit`] finds it.
pub trait Visitor {
    /// What comes of it.
    type Out;
    /// Does it with `F`.
    fn visit<F: Formula>(self) -> Self::Out;
}

/// A variation with everything precomputed that does not depend on the point.
#[derive(Clone, Copy, Debug)]
pub struct Compiled {
    /// Which formula.
    pub kind: Kind,
    /// The weight.
    pub w: f64,
    /// Values precomputed from the parameters.
    pub p: [f64; MAX_PARAMETERS],
    /// What keeps its divisors away from zero where it could lead as far as one likes: [`TINY`] in flam3.
    pub floor: f64,
    /// Whether it changes the colour: [`Formula::in_colour`] says to what.
    pub is_in_colour: bool,
}

impl Compiled {
    /// Precomputes `variation` for a transform whose affine part is `affine`.
    #[expect(clippy::wildcard_enum_match_arm, reason = "most variations take their parameters as they are")]
    pub fn new(variation: &Variation, affine: &Affine) -> Compiled {
        let Variation { kind, weight, params: q, .. } = *variation;
        let p = match kind {
            Kind::Waves => values([affine.b, over_square(affine.c), affine.e, over_square(affine.f)]),
            Kind::Popcorn => values([affine.c, affine.f]),
            Kind::Rings => values([affine.c * affine.c + TINY]),
            Kind::Fan => values([PI * (affine.c * affine.c + TINY), affine.f]),
            Kind::Blob => values([q[0], q[1] - q[0], q[2]]),
            Kind::Fan2 => values([PI * (q[0] * q[0] + TINY), q[1]]),
            Kind::Rings2 => values([q[0] * q[0] + TINY]),
            Kind::Perspective => {
                let (sin, cos) = libm::sincos(q[0] * FRAC_PI_2);
                values([q[1], sin, q[1] * cos])
            }
            Kind::Julian | Kind::Juliascope => values([q[0].abs(), q[0], q[1] / q[0] / 2.0]),
            Kind::RadialBlur => {
                let (sin, cos) = libm::sincos(q[0] * FRAC_PI_2);
                values([sin, cos])
            }
            Kind::Ngon => values([q[0] / 2.0, TAU / q[1], q[2], q[3]]),
            Kind::Disc2 => {
                let (sin, cos) = libm::sincos(q[1]);
                // More than a whole turn stretches what it adds.
                let stretch = 1.0 + (q[1].abs() - TAU).max(0.0).copysign(q[1]);
                values([PI * q[0], stretch * sin, stretch * (cos - 1.0)])
            }
            Kind::Escher => {
                let (sin, cos) = libm::sincos(q[0]);
                values([f64::midpoint(1.0, cos), sin / 2.0])
            }
            _ => of_others(kind, weight, &q),
        };
        Compiled { kind, w: weight, p, floor: TINY, is_in_colour: variation.changes_colour() }
    }
}

/// The first of the precomputed values; the rest is 0.
pub(super) fn values<const COUNT: usize>(first: [f64; COUNT]) -> [f64; MAX_PARAMETERS] {
    let mut all = [0.0; MAX_PARAMETERS];
    all[..COUNT].copy_from_slice(&first);
    all
}

fn over_square(length: f64) -> f64 {
    1.0 / (length * length + TINY)
}

/// Makes a type for each formula. The arguments are those of [`Formula::at`], the random numbers where they are used;
/// `N` is the type of `x` and `y`.
macro_rules! formulas {
    ($($kind:ident($v:ident, $x:tt, $y:tt $(, $random:ident)?) $body:block)*) => {$(
        pub(super) struct $kind;

        impl $crate::formulas::Formula for $kind {
            #[inline(always)]
            fn at<N: $crate::number::Number, R: $crate::number::Random<N>>(
                $v: &$crate::formulas::Compiled,
                $x: N,
                $y: N,
                _unused: &mut R,
            ) -> (N, N) {
                $(let $random = _unused;)?
                $body
            }
        }
    )*};
}

pub(super) use formulas;

/// The formula in the plane of a formula that knows z: that of the points whose z is 0.
macro_rules! in_plane {
    () => {
        #[inline(always)]
        fn at<N: $crate::number::Number, R: $crate::number::Random<N>>(
            v: &$crate::formulas::Compiled,
            x: N,
            y: N,
            random: &mut R,
        ) -> (N, N) {
            let [x, y, _] = Self::in_space(v, [x, y, x.like(0.0)], random);
            (x, y)
        }
    };
}

pub(super) use in_plane;

/// As [`formulas`], for formulas in space: each says what it does with z, and gives x, y and z.
macro_rules! solids {
    ($($kind:ident $depth:ident($v:ident, $x:tt, $y:tt, $z:tt $(, $random:ident)?) $body:block)*) => {$(
        pub(super) struct $kind;

        impl $crate::formulas::Formula for $kind {
            const DEPTH: $crate::formulas::Depth = $crate::formulas::Depth::$depth;

            $crate::formulas::in_plane!();

            #[inline(always)]
            fn in_space<N: $crate::number::Number, R: $crate::number::Random<N>>(
                $v: &$crate::formulas::Compiled,
                [$x, $y, $z]: [N; 3],
                _unused: &mut R,
            ) -> [N; 3] {
                $(let $random = _unused;)?
                $body
            }
        }
    )*};
}

pub(super) use solids;

/// As [`solids`], for formulas in colour: each gives x, y and z, and the colour after them.
macro_rules! colours {
    ($($kind:ident $depth:ident($v:ident, $from:ident, $random:ident) $body:block)*) => {$(
        pub(super) struct $kind;

        impl $crate::formulas::Formula for $kind {
            const DEPTH: $crate::formulas::Depth = $crate::formulas::Depth::$depth;
            const IS_IN_COLOUR: bool = true;

            $crate::formulas::in_plane!();

            #[inline(always)]
            fn in_space<N: $crate::number::Number, R: $crate::number::Random<N>>(
                v: &$crate::formulas::Compiled,
                point: [N; 3],
                random: &mut R,
            ) -> [N; 3] {
                let none = point[0].like(0.0);
                Self::in_colour(v, $crate::formulas::Coloured { point, sum: [none; 3], colour: none }, random).0
            }

            #[inline(always)]
            fn in_colour<N: $crate::number::Number, R: $crate::number::Random<N>>(
                $v: &$crate::formulas::Compiled,
                $from: $crate::formulas::Coloured<N>,
                $random: &mut R,
            ) -> ([N; 3], N) {
                $body
            }
        }
    )*};
}

pub(super) use colours;

/// r² = x² + y².
#[inline(always)]
pub(super) fn square_of_radius<N: Number>(x: N, y: N) -> N {
    x * x + y * y
}

/// r, the distance from the origin.
#[inline(always)]
pub(super) fn radius<N: Number>(x: N, y: N) -> N {
    square_of_radius(x, y).sqrt()
}

/// `value / divisor`.
#[inline(always)]
pub(super) fn over<N: Number>(value: f64, divisor: N) -> N {
    divisor.like(value) / divisor
}

/// What is left of `value` by division by `divisor`; it has the sign of `value`.
#[inline(always)]
pub(super) fn remainder<N: Number>(value: N, divisor: f64) -> N {
    (-(value / divisor).trunc()).mul_add(value.like(divisor), value)
}

/// The point at `angle` and `radius`.
#[inline(always)]
pub(super) fn at_angle<N: Number>(angle: N, radius: N) -> (N, N) {
    let (sin, cos) = angle.sin_cos();
    (radius * cos, radius * sin)
}

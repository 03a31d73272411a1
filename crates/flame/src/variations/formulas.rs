//! The mathematics of V0 to V48.
//!
//! Owns the formulas and what they precompute per transform. Never chooses a transform or sums weights
//! over an orbit: `render/chaos.rs` does.
//!
//! Start at [`Compiled::apply`]. With `x`, `y` the point after the affine part: `r² = x² + y²`,
//! θ = atan2(x, y), φ = atan2(y, x), ψ a fresh random number in 0..1 and `w` the variation's weight.
//!
//! # Source
//! Draves & Reckase, *The Fractal Flame Algorithm* (2008), appendix. Where the paper leaves a choice (the
//! guard against division by zero, axes of blob and rings2) the pictures of `flam3-render` decide.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::{Kind, Variation, chance, plain};
use crate::genome::Affine;
use crate::rng::Rng;

/// Keeps divisors away from zero.
pub(super) const TINY: f64 = 1e-10;

/// What the variations of one transform ask of [`Point::new`].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Needs {
    /// Whether θ is read.
    pub(crate) theta: bool,
    /// Whether φ is read.
    pub(crate) phi: bool,
}

/// A point and what several variations need of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Point {
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) r2: f64,
    pub(super) r: f64,
    pub(super) theta: f64,
    pub(super) phi: f64,
}

impl Point {
    /// Prepares `(x, y)`; angles that are not needed stay 0.
    #[inline]
    pub(crate) fn new(x: f64, y: f64, needs: Needs) -> Point {
        let r2 = x * x + y * y;
        let theta = if needs.theta { x.atan2(y) } else { 0.0 };
        let phi = if needs.phi { y.atan2(x) } else { 0.0 };
        Point { x, y, r2, r: r2.sqrt(), theta, phi }
    }

    /// sin θ.
    #[inline]
    pub(super) fn sin(&self) -> f64 {
        self.x / self.r
    }

    /// cos θ.
    #[inline]
    pub(super) fn cos(&self) -> f64 {
        self.y / self.r
    }
}

/// From a point and a random generator to the variation's part of the result.
type Formula = fn(&Compiled, &Point, &mut Rng) -> (f64, f64);

/// A variation with everything precomputed that does not depend on the point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Compiled {
    formula: Formula,
    /// The weight.
    pub(super) w: f64,
    /// Values precomputed from the parameters.
    pub(super) p: [f64; 4],
}

impl Compiled {
    /// Precomputes `variation` for a transform whose affine part is `affine`.
    #[expect(clippy::wildcard_enum_match_arm, reason = "most variations take their parameters as they are")]
    pub(crate) fn new(variation: &Variation, affine: &Affine) -> Compiled {
        let q = variation.params;
        let w = variation.weight;
        let p = match variation.kind {
            Kind::Waves => [affine.b, 1.0 / (affine.c * affine.c + TINY), affine.e, 1.0 / (affine.f * affine.f + TINY)],
            Kind::Popcorn => [affine.c, affine.f, 0.0, 0.0],
            Kind::Rings => [affine.c * affine.c + TINY, 0.0, 0.0, 0.0],
            Kind::Fan => [PI * (affine.c * affine.c + TINY), affine.f, 0.0, 0.0],
            Kind::Blob => [q[0], q[1] - q[0], q[2], 0.0],
            Kind::Fan2 => [PI * (q[0] * q[0] + TINY), q[1], 0.0, 0.0],
            Kind::Rings2 => [q[0] * q[0] + TINY, 0.0, 0.0, 0.0],
            Kind::Perspective => {
                let (sin, cos) = (q[0] * FRAC_PI_2).sin_cos();
                [q[1], sin, q[1] * cos, 0.0]
            }
            Kind::Julian | Kind::Juliascope => [q[0].abs(), q[0], q[1] / q[0] / 2.0, 0.0],
            Kind::RadialBlur => {
                let (sin, cos) = (q[0] * FRAC_PI_2).sin_cos();
                [sin, cos, 0.0, 0.0]
            }
            Kind::Ngon => [q[0] / 2.0, TAU / q[1], q[2], q[3]],
            _ => q,
        };
        Compiled { formula: formula(variation.kind), w, p }
    }

    /// The variation's part of the transform's result, weight included.
    ///
    /// A call through a pointer, never inlined: in a loop over variations the compiler would move every sine
    /// that any formula might want out in front of it (measured: three times slower).
    #[inline]
    pub(crate) fn apply(&self, at: &Point, rng: &mut Rng) -> (f64, f64) {
        (self.formula)(self, at, rng)
    }
}

/// The formula of a variation.
fn formula(kind: Kind) -> Formula {
    match kind {
        Kind::Linear => plain::linear,
        Kind::Sinusoidal => plain::sinusoidal,
        Kind::Spherical => plain::spherical,
        Kind::Swirl => plain::swirl,
        Kind::Horseshoe => plain::horseshoe,
        Kind::Polar => plain::polar,
        Kind::Handkerchief => plain::handkerchief,
        Kind::Heart => plain::heart,
        Kind::Disc => plain::disc,
        Kind::Spiral => plain::spiral,
        Kind::Hyperbolic => plain::hyperbolic,
        Kind::Diamond => plain::diamond,
        Kind::Ex => plain::ex,
        Kind::Julia => chance::julia,
        Kind::Bent => plain::bent,
        Kind::Waves => plain::waves,
        Kind::Fisheye => plain::fisheye,
        Kind::Popcorn => plain::popcorn,
        Kind::Exponential => plain::exponential,
        Kind::Power => plain::power,
        Kind::Cosine => plain::cosine,
        Kind::Rings => plain::rings,
        Kind::Fan => plain::fan,
        Kind::Blob => plain::blob,
        Kind::Pdj => plain::pdj,
        Kind::Fan2 => plain::fan2,
        Kind::Rings2 => plain::rings2,
        Kind::Eyefish => plain::eyefish,
        Kind::Bubble => plain::bubble,
        Kind::Cylinder => plain::cylinder,
        Kind::Perspective => plain::perspective,
        Kind::Noise => chance::noise,
        Kind::Julian => chance::julian,
        Kind::Juliascope => chance::juliascope,
        Kind::Blur => chance::blur,
        Kind::GaussianBlur => chance::gaussian_blur,
        Kind::RadialBlur => chance::radial_blur,
        Kind::Pie => chance::pie,
        Kind::Ngon => plain::ngon,
        Kind::Curl => plain::curl,
        Kind::Rectangles => plain::rectangles,
        Kind::Arch => chance::arch,
        Kind::Tangent => plain::tangent,
        Kind::Square => chance::square,
        Kind::Rays => chance::rays,
        Kind::Blade => chance::blade,
        Kind::Secant2 => plain::secant2,
        Kind::Twintrian => chance::twintrian,
        Kind::Cross => plain::cross,
    }
}

/// Whether a coordinate is so large, or not a number, that the orbit has escaped.
#[inline]
pub(crate) fn is_out_of_range(value: f64) -> bool {
    value.is_nan() || value.abs() > 1e10
}

/// Which angles the formula of `kind` reads.
pub(crate) fn needs(kind: Kind) -> Needs {
    let theta = matches!(
        kind,
        Kind::Polar
            | Kind::Handkerchief
            | Kind::Heart
            | Kind::Disc
            | Kind::Ex
            | Kind::Julia
            | Kind::Fan
            | Kind::Blob
            | Kind::Fan2
    );
    let phi = matches!(kind, Kind::Julian | Kind::Juliascope | Kind::RadialBlur | Kind::Ngon);
    Needs { theta, phi }
}

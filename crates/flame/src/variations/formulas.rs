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

use super::{Kind, Variation};
use crate::genome::Affine;
use crate::rng::Rng;

/// Keeps divisors away from zero.
const TINY: f64 = 1e-10;

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
    x: f64,
    y: f64,
    r2: f64,
    r: f64,
    theta: f64,
    phi: f64,
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
    fn sin(&self) -> f64 {
        self.x / self.r
    }

    /// cos θ.
    #[inline]
    fn cos(&self) -> f64 {
        self.y / self.r
    }
}

/// A variation with everything precomputed that does not depend on the point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Compiled {
    kind: Kind,
    w: f64,
    p: [f64; 4],
}

impl Compiled {
    /// Precomputes `variation` for a transform whose affine part is `affine`.
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
        Compiled { kind: variation.kind, w, p }
    }

    /// Which angles the formula reads.
    pub(crate) fn needs(&self) -> Needs {
        let theta = matches!(
            self.kind,
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
        let phi = matches!(self.kind, Kind::Julian | Kind::Juliascope | Kind::RadialBlur | Kind::Ngon);
        Needs { theta, phi }
    }

    /// The variation's part of the transform's result, weight included.
    #[inline]
    #[expect(clippy::too_many_lines, reason = "one table of 49 formulas, two to six lines each")]
    pub(crate) fn apply(&self, at: &Point, rng: &mut Rng) -> (f64, f64) {
        let Compiled { kind, w, p } = *self;
        let Point { x, y, r2, r, theta, phi } = *at;
        match kind {
            Kind::Linear => (w * x, w * y),
            Kind::Sinusoidal => (w * x.sin(), w * y.sin()),
            Kind::Spherical => {
                let s = w / (r2 + TINY);
                (s * x, s * y)
            }
            Kind::Swirl => {
                let (s, c) = r2.sin_cos();
                (w * (s * x - c * y), w * (c * x + s * y))
            }
            Kind::Horseshoe => {
                let s = w / (r + TINY);
                (s * (x - y) * (x + y), s * 2.0 * x * y)
            }
            Kind::Polar => (w * theta / PI, w * (r - 1.0)),
            Kind::Handkerchief => (w * r * (theta + r).sin(), w * r * (theta - r).cos()),
            Kind::Heart => {
                let (s, c) = (theta * r).sin_cos();
                (w * r * s, -w * r * c)
            }
            Kind::Disc => {
                let (s, c) = (PI * r).sin_cos();
                (w * theta / PI * s, w * theta / PI * c)
            }
            Kind::Spiral => {
                let (s, c) = r.sin_cos();
                let k = w / (r + TINY);
                (k * (at.cos() + s), k * (at.sin() - c))
            }
            Kind::Hyperbolic => (w * at.sin() / (r + TINY), w * at.cos() * r),
            Kind::Diamond => {
                let (s, c) = r.sin_cos();
                (w * at.sin() * c, w * at.cos() * s)
            }
            Kind::Ex => {
                let (m, n) = ((theta + r).sin().powi(3) * r, (theta - r).cos().powi(3) * r);
                (w * (m + n), w * (m - n))
            }
            Kind::Julia => {
                let half = theta / 2.0 + if rng.bits() >> 63 == 1 { PI } else { 0.0 };
                let (s, c) = half.sin_cos();
                (w * r.sqrt() * c, w * r.sqrt() * s)
            }
            Kind::Bent => (w * if x < 0.0 { x * 2.0 } else { x }, w * if y < 0.0 { y / 2.0 } else { y }),
            Kind::Waves => (w * (x + p[0] * (y * p[1]).sin()), w * (y + p[2] * (x * p[3]).sin())),
            Kind::Fisheye => {
                let s = 2.0 * w / (r + 1.0);
                (s * y, s * x)
            }
            Kind::Popcorn => (w * (x + p[0] * (3.0 * y).tan().sin()), w * (y + p[1] * (3.0 * x).tan().sin())),
            Kind::Exponential => {
                let (s, c) = (PI * y).sin_cos();
                let e = w * (x - 1.0).exp();
                (e * c, e * s)
            }
            Kind::Power => {
                let s = w * r.powf(at.sin());
                (s * at.cos(), s * at.sin())
            }
            Kind::Cosine => {
                let (s, c) = (PI * x).sin_cos();
                (w * c * y.cosh(), -w * s * y.sinh())
            }
            Kind::Rings => {
                let d = p[0];
                let s = w * ((r + d) % (2.0 * d) - d + r * (1.0 - d));
                (s * at.cos(), s * at.sin())
            }
            Kind::Fan => {
                let half = p[0] / 2.0;
                let turned = if (theta + p[1]) % p[0] > half { theta - half } else { theta + half };
                let (s, c) = turned.sin_cos();
                (w * r * c, w * r * s)
            }
            Kind::Blob => {
                let s = w * r * (p[0] + p[1] * (0.5 + 0.5 * (p[2] * theta).sin()));
                (s * at.sin(), s * at.cos())
            }
            Kind::Pdj => (w * ((p[0] * y).sin() - (p[1] * x).cos()), w * ((p[2] * x).sin() - (p[3] * y).cos())),
            Kind::Fan2 => {
                let (d, half) = (p[0], p[0] / 2.0);
                let t = theta + p[1] - d * ((theta + p[1]) / d).trunc();
                let (s, c) = if t > half { theta - half } else { theta + half }.sin_cos();
                (w * r * s, w * r * c)
            }
            Kind::Rings2 => {
                let d = p[0];
                let s = w * (r - 2.0 * d * ((r + d) / (2.0 * d)).trunc() + r * (1.0 - d));
                (s * at.sin(), s * at.cos())
            }
            Kind::Eyefish => {
                let s = 2.0 * w / (r + 1.0);
                (s * x, s * y)
            }
            Kind::Bubble => {
                let s = w / (r2 / 4.0 + 1.0);
                (s * x, s * y)
            }
            Kind::Cylinder => (w * x.sin(), w * y),
            Kind::Perspective => {
                let t = w / (p[0] - y * p[1]);
                (t * p[0] * x, t * p[2] * y)
            }
            Kind::Noise => {
                let (s, c) = (TAU * rng.unit()).sin_cos();
                let k = w * rng.unit();
                (k * x * c, k * y * s)
            }
            Kind::Julian => {
                let (s, c) = ((phi + TAU * (p[0] * rng.unit()).trunc()) / p[1]).sin_cos();
                let k = w * r2.powf(p[2]);
                (k * c, k * s)
            }
            Kind::Juliascope => {
                let root = (p[0] * rng.unit()).trunc();
                let mirrored = if root as i64 & 1 == 0 { phi } else { -phi };
                let (s, c) = ((TAU * root + mirrored) / p[1]).sin_cos();
                let k = w * r2.powf(p[2]);
                (k * c, k * s)
            }
            Kind::Blur => {
                let (s, c) = (TAU * rng.unit()).sin_cos();
                let k = w * rng.unit();
                (k * c, k * s)
            }
            Kind::GaussianBlur => {
                let (s, c) = (TAU * rng.unit()).sin_cos();
                let k = w * bell(rng);
                (k * c, k * s)
            }
            Kind::RadialBlur => {
                let k = w * bell(rng);
                let (s, c) = (phi + p[0] * k).sin_cos();
                let z = p[1] * k - 1.0;
                (r * c + z * x, r * s + z * y)
            }
            Kind::Pie => {
                let slice = (rng.unit() * p[0] + 0.5).trunc();
                let (s, c) = (p[1] + TAU * (slice + rng.unit() * p[2]) / p[0]).sin_cos();
                let k = w * rng.unit();
                (k * c, k * s)
            }
            Kind::Ngon => {
                let mut t = phi - p[1] * (phi / p[1]).floor();
                if t > p[1] / 2.0 {
                    t -= p[1];
                }
                let k = w * (p[2] * (1.0 / (t.cos() + TINY) - 1.0) + p[3]) / (r2.powf(p[0]) + TINY);
                (k * x, k * y)
            }
            Kind::Curl => {
                let (re, im) = (1.0 + p[0] * x + p[1] * (x * x - y * y), p[0] * y + 2.0 * p[1] * x * y);
                let k = w / (re * re + im * im);
                (k * (x * re + y * im), k * (y * re - x * im))
            }
            Kind::Rectangles => (w * fold(x, p[0]), w * fold(y, p[1])),
            Kind::Arch => {
                let (s, c) = (rng.unit() * w * PI).sin_cos();
                (w * s, w * s * s / c)
            }
            Kind::Tangent => (w * x.sin() / y.cos(), w * y.tan()),
            Kind::Square => (w * (rng.unit() - 0.5), w * (rng.unit() - 0.5)),
            Kind::Rays => {
                let k = w * (w * rng.unit() * PI).tan() * w / (r2 + TINY);
                (k * x.cos(), k * y.sin())
            }
            Kind::Blade => {
                let (s, c) = (rng.unit() * w * r).sin_cos();
                (w * x * (c + s), w * x * (c - s))
            }
            Kind::Secant2 => {
                let c = (w * r).cos();
                (w * x, w * if c < 0.0 { 1.0 / c + 1.0 } else { 1.0 / c - 1.0 })
            }
            Kind::Twintrian => {
                let (s, c) = (rng.unit() * w * r).sin_cos();
                let lobe = (s * s).log10() + c;
                let lobe = if bad(lobe) { -30.0 } else { lobe };
                (w * x * lobe, w * x * (lobe - s * PI))
            }
            Kind::Cross => {
                let s = x * x - y * y;
                let k = w * (1.0 / (s * s + TINY)).sqrt();
                (k * x, k * y)
            }
        }
    }
}

/// Whether a coordinate has left the range in which orbits live.
#[inline]
pub(crate) fn bad(value: f64) -> bool {
    !(value.abs() <= 1e10)
}

/// The sum of four random numbers, centred: nearly Gaussian, in -2..2.
#[inline]
fn bell(rng: &mut Rng) -> f64 {
    rng.unit() + rng.unit() + rng.unit() + rng.unit() - 2.0
}

/// Folds a coordinate about the middle of its cell.
#[inline]
fn fold(value: f64, cell: f64) -> f64 {
    if cell == 0.0 { value } else { (2.0 * (value / cell).floor() + 1.0) * cell - value }
}

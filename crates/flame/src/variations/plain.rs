//! The deterministic formulas.
//!
//! Owns 36 of the 49. The random ones are in `chance.rs`. The letters are those of `formulas.rs`; a reader with the
//! paper open finds each by its name.
//!
//! Start at any of them: each returns the variation's part of the result, weight included.

use std::f64::consts::PI;

use super::formulas::{Compiled, Point, TINY};
use crate::rng::Rng;

pub(super) fn linear(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { x, y, .. } = *at;
    (v.w * x, v.w * y)
}

pub(super) fn sinusoidal(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { x, y, .. } = *at;
    (v.w * x.sin(), v.w * y.sin())
}

pub(super) fn spherical(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { x, y, r2, .. } = *at;
    let s = v.w / (r2 + TINY);
    (s * x, s * y)
}

pub(super) fn swirl(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { x, y, r2, .. } = *at;
    let (s, c) = r2.sin_cos();
    (v.w * (s * x - c * y), v.w * (c * x + s * y))
}

pub(super) fn horseshoe(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { x, y, r, .. } = *at;
    let s = v.w / (r + TINY);
    (s * (x - y) * (x + y), s * 2.0 * x * y)
}

pub(super) fn polar(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { r, theta, .. } = *at;
    (v.w * theta / PI, v.w * (r - 1.0))
}

pub(super) fn handkerchief(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { r, theta, .. } = *at;
    (v.w * r * (theta + r).sin(), v.w * r * (theta - r).cos())
}

pub(super) fn heart(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { r, theta, .. } = *at;
    let (s, c) = (theta * r).sin_cos();
    (v.w * r * s, -v.w * r * c)
}

pub(super) fn disc(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { r, theta, .. } = *at;
    let (s, c) = (PI * r).sin_cos();
    (v.w * theta / PI * s, v.w * theta / PI * c)
}

pub(super) fn spiral(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { r, .. } = *at;
    let (s, c) = r.sin_cos();
    let k = v.w / (r + TINY);
    (k * (at.cos() + s), k * (at.sin() - c))
}

pub(super) fn hyperbolic(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { r, .. } = *at;
    (v.w * at.sin() / (r + TINY), v.w * at.cos() * r)
}

pub(super) fn diamond(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { r, .. } = *at;
    let (s, c) = r.sin_cos();
    (v.w * at.sin() * c, v.w * at.cos() * s)
}

pub(super) fn ex(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { r, theta, .. } = *at;
    let (m, n) = ((theta + r).sin().powi(3) * r, (theta - r).cos().powi(3) * r);
    (v.w * (m + n), v.w * (m - n))
}

pub(super) fn bent(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { x, y, .. } = *at;
    (v.w * if x < 0.0 { x * 2.0 } else { x }, v.w * if y < 0.0 { y / 2.0 } else { y })
}

pub(super) fn waves(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { x, y, .. } = *at;
    (v.w * (x + v.p[0] * (y * v.p[1]).sin()), v.w * (y + v.p[2] * (x * v.p[3]).sin()))
}

pub(super) fn fisheye(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { x, y, r, .. } = *at;
    let s = 2.0 * v.w / (r + 1.0);
    (s * y, s * x)
}

pub(super) fn popcorn(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { x, y, .. } = *at;
    (v.w * (x + v.p[0] * (3.0 * y).tan().sin()), v.w * (y + v.p[1] * (3.0 * x).tan().sin()))
}

pub(super) fn exponential(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { x, y, .. } = *at;
    let (s, c) = (PI * y).sin_cos();
    let e = v.w * (x - 1.0).exp();
    (e * c, e * s)
}

pub(super) fn power(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { r, .. } = *at;
    let s = v.w * r.powf(at.sin());
    (s * at.cos(), s * at.sin())
}

pub(super) fn cosine(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { x, y, .. } = *at;
    let (s, c) = (PI * x).sin_cos();
    (v.w * c * y.cosh(), -v.w * s * y.sinh())
}

pub(super) fn rings(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { r, .. } = *at;
    let d = v.p[0];
    let s = v.w * ((r + d) % (2.0 * d) - d + r * (1.0 - d));
    (s * at.cos(), s * at.sin())
}

pub(super) fn fan(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { r, theta, .. } = *at;
    let half = v.p[0] / 2.0;
    let turned = if (theta + v.p[1]) % v.p[0] > half { theta - half } else { theta + half };
    let (s, c) = turned.sin_cos();
    (v.w * r * c, v.w * r * s)
}

pub(super) fn blob(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { r, theta, .. } = *at;
    let s = v.w * r * (v.p[0] + v.p[1] * (0.5 + 0.5 * (v.p[2] * theta).sin()));
    (s * at.sin(), s * at.cos())
}

pub(super) fn pdj(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { x, y, .. } = *at;
    (v.w * ((v.p[0] * y).sin() - (v.p[1] * x).cos()), v.w * ((v.p[2] * x).sin() - (v.p[3] * y).cos()))
}

pub(super) fn fan2(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { r, theta, .. } = *at;
    let (d, half) = (v.p[0], v.p[0] / 2.0);
    let t = theta + v.p[1] - d * ((theta + v.p[1]) / d).trunc();
    let (s, c) = if t > half { theta - half } else { theta + half }.sin_cos();
    (v.w * r * s, v.w * r * c)
}

pub(super) fn rings2(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { r, .. } = *at;
    let d = v.p[0];
    let s = v.w * (r - 2.0 * d * ((r + d) / (2.0 * d)).trunc() + r * (1.0 - d));
    (s * at.sin(), s * at.cos())
}

pub(super) fn eyefish(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { x, y, r, .. } = *at;
    let s = 2.0 * v.w / (r + 1.0);
    (s * x, s * y)
}

pub(super) fn bubble(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { x, y, r2, .. } = *at;
    let s = v.w / (r2 / 4.0 + 1.0);
    (s * x, s * y)
}

pub(super) fn cylinder(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { x, y, .. } = *at;
    (v.w * x.sin(), v.w * y)
}

pub(super) fn perspective(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { x, y, .. } = *at;
    let t = v.w / (v.p[0] - y * v.p[1]);
    (t * v.p[0] * x, t * v.p[2] * y)
}

pub(super) fn ngon(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { x, y, r2, phi, .. } = *at;
    let mut t = phi - v.p[1] * (phi / v.p[1]).floor();
    if t > v.p[1] / 2.0 {
        t -= v.p[1];
    }
    let k = v.w * (v.p[2] * (1.0 / (t.cos() + TINY) - 1.0) + v.p[3]) / (r2.powf(v.p[0]) + TINY);
    (k * x, k * y)
}

pub(super) fn curl(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { x, y, .. } = *at;
    let (re, im) = (1.0 + v.p[0] * x + v.p[1] * (x * x - y * y), v.p[0] * y + 2.0 * v.p[1] * x * y);
    let k = v.w / (re * re + im * im);
    (k * (x * re + y * im), k * (y * re - x * im))
}

pub(super) fn rectangles(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { x, y, .. } = *at;
    (v.w * fold(x, v.p[0]), v.w * fold(y, v.p[1]))
}

pub(super) fn tangent(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { x, y, .. } = *at;
    (v.w * x.sin() / y.cos(), v.w * y.tan())
}

pub(super) fn secant2(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { x, r, .. } = *at;
    let c = (v.w * r).cos();
    (v.w * x, v.w * if c < 0.0 { 1.0 / c + 1.0 } else { 1.0 / c - 1.0 })
}

pub(super) fn cross(v: &Compiled, at: &Point, _: &mut Rng) -> (f64, f64) {
    let Point { x, y, .. } = *at;
    let s = x * x - y * y;
    let k = v.w * (1.0 / (s * s + TINY)).sqrt();
    (k * x, k * y)
}

/// Folds a coordinate about the middle of its cell.
fn fold(value: f64, cell: f64) -> f64 {
    if cell == 0.0 { value } else { (2.0 * (value / cell).floor() + 1.0) * cell - value }
}

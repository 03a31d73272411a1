//! The random formulas: each call may send the same point elsewhere.
//!
//! Owns 13 of the 49. The random generator is an argument. The letters are those of `formulas.rs`.
//!
//! Start at any of them: each returns the variation's part of the result, weight included.

use std::f64::consts::{PI, TAU};

use super::formulas::{Compiled, Point, TINY, is_out_of_range};
use crate::rng::Rng;

pub(super) fn julia(v: &Compiled, at: &Point, rng: &mut Rng) -> (f64, f64) {
    let Point { r, theta, .. } = *at;
    let half = theta / 2.0 + if rng.bits() >> 63 == 1 { PI } else { 0.0 };
    let (s, c) = half.sin_cos();
    (v.w * r.sqrt() * c, v.w * r.sqrt() * s)
}

pub(super) fn noise(v: &Compiled, at: &Point, rng: &mut Rng) -> (f64, f64) {
    let Point { x, y, .. } = *at;
    let (s, c) = (TAU * rng.unit()).sin_cos();
    let k = v.w * rng.unit();
    (k * x * c, k * y * s)
}

pub(super) fn julian(v: &Compiled, at: &Point, rng: &mut Rng) -> (f64, f64) {
    let Point { r2, phi, .. } = *at;
    let (s, c) = ((phi + TAU * (v.p[0] * rng.unit()).trunc()) / v.p[1]).sin_cos();
    let k = v.w * r2.powf(v.p[2]);
    (k * c, k * s)
}

pub(super) fn juliascope(v: &Compiled, at: &Point, rng: &mut Rng) -> (f64, f64) {
    let Point { r2, phi, .. } = *at;
    let root = (v.p[0] * rng.unit()).trunc();
    let mirrored = if root as i64 & 1 == 0 { phi } else { -phi };
    let (s, c) = ((TAU * root + mirrored) / v.p[1]).sin_cos();
    let k = v.w * r2.powf(v.p[2]);
    (k * c, k * s)
}

pub(super) fn blur(v: &Compiled, _: &Point, rng: &mut Rng) -> (f64, f64) {
    let (s, c) = (TAU * rng.unit()).sin_cos();
    let k = v.w * rng.unit();
    (k * c, k * s)
}

pub(super) fn gaussian_blur(v: &Compiled, _: &Point, rng: &mut Rng) -> (f64, f64) {
    let (s, c) = (TAU * rng.unit()).sin_cos();
    let k = v.w * bell(rng);
    (k * c, k * s)
}

pub(super) fn radial_blur(v: &Compiled, at: &Point, rng: &mut Rng) -> (f64, f64) {
    let Point { x, y, r, phi, .. } = *at;
    let k = v.w * bell(rng);
    let (s, c) = (phi + v.p[0] * k).sin_cos();
    let z = v.p[1] * k - 1.0;
    (r * c + z * x, r * s + z * y)
}

pub(super) fn pie(v: &Compiled, _: &Point, rng: &mut Rng) -> (f64, f64) {
    let slice = (rng.unit() * v.p[0] + 0.5).trunc();
    let (s, c) = (v.p[1] + TAU * (slice + rng.unit() * v.p[2]) / v.p[0]).sin_cos();
    let k = v.w * rng.unit();
    (k * c, k * s)
}

pub(super) fn arch(v: &Compiled, _: &Point, rng: &mut Rng) -> (f64, f64) {
    let (s, c) = (rng.unit() * v.w * PI).sin_cos();
    (v.w * s, v.w * s * s / c)
}

pub(super) fn square(v: &Compiled, _: &Point, rng: &mut Rng) -> (f64, f64) {
    (v.w * (rng.unit() - 0.5), v.w * (rng.unit() - 0.5))
}

pub(super) fn rays(v: &Compiled, at: &Point, rng: &mut Rng) -> (f64, f64) {
    let Point { x, y, r2, .. } = *at;
    let k = v.w * (v.w * rng.unit() * PI).tan() * v.w / (r2 + TINY);
    (k * x.cos(), k * y.sin())
}

pub(super) fn blade(v: &Compiled, at: &Point, rng: &mut Rng) -> (f64, f64) {
    let Point { x, r, .. } = *at;
    let (s, c) = (rng.unit() * v.w * r).sin_cos();
    (v.w * x * (c + s), v.w * x * (c - s))
}

pub(super) fn twintrian(v: &Compiled, at: &Point, rng: &mut Rng) -> (f64, f64) {
    let Point { x, r, .. } = *at;
    let (s, c) = (rng.unit() * v.w * r).sin_cos();
    let lobe = (s * s).log10() + c;
    let lobe = if is_out_of_range(lobe) { -30.0 } else { lobe };
    (v.w * x * lobe, v.w * x * (lobe - s * PI))
}

/// The sum of four random numbers, centred: nearly Gaussian, in -2..2.
#[inline]
fn bell(rng: &mut Rng) -> f64 {
    rng.unit() + rng.unit() + rng.unit() + rng.unit() - 2.0
}

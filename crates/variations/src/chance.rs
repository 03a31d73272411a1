//! The random formulas: each call may send the same point elsewhere.
//!
//! Owns all that draw random numbers, 13 of V0 to V48 among them. The letters and the source are those of `plain.rs`, and for
//! what was added after the paper those of `later.rs`.
//!
//! # Source
//! `SuperShape`: Gielis, *A generic geometric transformation that unifies a wide range of natural and abstract shapes*
//! (2003). `Conic`: the polar equation of a conic about its focus.

use std::f64::consts::{PI, TAU};

use super::formulas::{at_angle, formulas, radius, square_of_radius};
use super::later::wedged;
use crate::number::{Number, Random};

formulas! {
    Julia(v, x, y, random) {
        let half = x.atan2(y) * 0.5;
        let half = N::select(random.coin(), half + PI, half);
        at_angle(half, radius(x, y).sqrt() * v.w)
    }

    Noise(v, x, y, random) {
        let (c, s) = on_disc(random);
        (c * x * v.w, s * y * v.w)
    }

    Julian(v, x, y, random) {
        let root = (random.unit() * v.p[0]).trunc();
        at_angle((y.atan2(x) + root * TAU) / v.p[1], square_of_radius(x, y).pow(x.like(v.p[2])) * v.w)
    }

    Juliascope(v, x, y, random) {
        let root = (random.unit() * v.p[0]).trunc();
        let half = root * 0.5;
        let is_even = (half - half.trunc()).less(half.like(0.25));
        let phi = y.atan2(x);
        let mirrored = N::select(is_even, phi, -phi);
        at_angle((root * TAU + mirrored) / v.p[1], square_of_radius(x, y).pow(x.like(v.p[2])) * v.w)
    }

    Blur(v, _, _, random) {
        let (c, s) = on_disc(random);
        (c * v.w, s * v.w)
    }

    GaussianBlur(v, _, _, random) {
        let angle = random.unit() * TAU;
        at_angle(angle, bell(random) * v.w)
    }

    RadialBlur(v, x, y, random) {
        let k = bell(random) * v.w;
        let (turned_x, turned_y) = at_angle(y.atan2(x) + k * v.p[0], radius(x, y));
        let z = k * v.p[1] - 1.0;
        (turned_x + z * x, turned_y + z * y)
    }

    Pie(v, _, _, random) {
        let slice = (random.unit() * v.p[0] + 0.5).trunc();
        let angle = (slice + random.unit() * v.p[2]) * (TAU / v.p[0]) + v.p[1];
        at_angle(angle, random.unit() * v.w)
    }

    Arch(v, _, _, random) {
        let (s, c) = (random.unit() * (v.w * PI)).sin_cos();
        (s * v.w, s * s / c * v.w)
    }

    Square(v, _, _, random) {
        ((random.unit() - 0.5) * v.w, (random.unit() - 0.5) * v.w)
    }

    Rays(v, x, y, random) {
        let k = (random.unit() * (v.w * PI)).tan() * (v.w * v.w) / (square_of_radius(x, y) + v.floor);
        (k * x.cos(), k * y.sin())
    }

    Blade(v, x, y, random) {
        let (s, c) = (random.unit() * v.w * radius(x, y)).sin_cos();
        (x * (c + s) * v.w, x * (c - s) * v.w)
    }

    Twintrian(v, x, y, random) {
        let (s, c) = (random.unit() * v.w * radius(x, y)).sin_cos();
        let lobe = (s * s).ln() * std::f64::consts::LOG10_E + c;
        let lobe = N::select(lobe.abs().less(lobe.like(1e10)), lobe, lobe.like(-30.0));
        (x * lobe * v.w, x * (lobe - s * PI) * v.w)
    }

    SuperShape(v, x, y, random) {
        let [chance, m, n1, n2, n3, holes, ..] = v.p;
        let r = radius(x, y);
        let (s, c) = (y.atan2(x) * (m / 4.0) + PI / 4.0).sin_cos();
        let shape = (c.abs().pow(r.like(n2)) + s.abs().pow(r.like(n3))).pow(r.like(-1.0 / n1));
        let k = (random.unit() * chance + r * (1.0 - chance) - holes) * shape / r * v.w;
        (k * x, k * y)
    }

    Flower(v, x, y, random) {
        let k = (random.unit() - v.p[0]) * (y.atan2(x) * v.p[1]).cos() / radius(x, y) * v.w;
        (k * x, k * y)
    }

    Conic(v, x, y, random) {
        let [holes, eccentricity, ..] = v.p;
        let r = radius(x, y);
        let k = (random.unit() - holes) * (v.w * eccentricity) / (x * eccentricity + r);
        (k * x, k * y)
    }

    Parabola(v, x, y, random) {
        let (s, c) = radius(x, y).sin_cos();
        (s * s * random.unit() * (v.w * v.p[0]), c * random.unit() * (v.w * v.p[1]))
    }

    Boarders(v, x, y, random) {
        let (middle_x, middle_y) = (x.round(), y.round());
        let (off_x, off_y) = (x - middle_x, y - middle_y);
        let outwards = off_x.like(0.25) / off_x.abs().max(off_y.abs());
        let unit = random.unit();
        let moved = N::select(unit.less(unit.like(0.75)), outwards, unit.like(0.0)) + 0.5;
        ((moved * off_x + middle_x) * v.w, (moved * off_y + middle_y) * v.w)
    }

    Cpow(v, x, y, random) {
        let [re, im, power, ..] = v.p;
        let (phi, ln_r) = (y.atan2(x), square_of_radius(x, y).ln() * 0.5);
        let root = (random.unit() * power).floor();
        at_angle(
            phi * (re / power) + ln_r * (im / power) + root * (TAU / power),
            (ln_r * (re / power) - phi * (im / power)).exp() * v.w,
        )
    }

    PreBlur(v, _, _, random) {
        let strength = bell(random) * v.w;
        at_angle(random.unit() * TAU, strength)
    }

    WedgeJulia(v, x, y, random) {
        let [angle, count, power, dist, ..] = v.p;
        let root = (random.unit() * power.abs()).trunc();
        let phi = (y.atan2(x) + root * TAU) / power;
        at_angle(wedged(phi, angle, count), square_of_radius(x, y).pow(x.like(dist / power / 2.0)) * v.w)
    }
}

/// A point in the unit circle, denser towards its centre.
#[inline(always)]
fn on_disc<N: Number, R: Random<N>>(random: &mut R) -> (N, N) {
    let angle = random.unit() * TAU;
    at_angle(angle, random.unit())
}

/// The sum of four random numbers, centred: nearly Gaussian, in -2..2.
#[inline(always)]
pub(super) fn bell<N: Number, R: Random<N>>(random: &mut R) -> N {
    random.unit() + random.unit() + random.unit() + random.unit() - 2.0
}

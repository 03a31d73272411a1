//! Formulas of other programs that choose among several images: roots, and tiles of a hyperbolic plane.
//!
//! Owns roots of a complex number, in polar, elliptic and bipolar coordinates, and the Möbius maps of hypertiles. The letters
//! are those of `plain.rs`; the point is x + iy.
//!
//! # Source
//! What `JWildfire`, Fractorium and Apophysis plugins of these names compute, in their authors' descriptions. `Acosech` and
//! `Acosh`: Abramowitz & Stegun, *Handbook of Mathematical Functions* (1964), 4.6.

use std::f64::consts::{FRAC_2_PI, PI, TAU};

use super::complex::{Ellipse, near, square_root};
use super::formulas::{at_angle, formulas, over, square_of_radius};
use crate::number::{Number, Random};

/// Keeps logarithms and powers of squares finite, in `f32` too.
pub(super) const NEAREST: f64 = 1e-30;

formulas! {
    Juliac(v, x, y, random) {
        let [count, re, im, dist, turn, ..] = v.p;
        let a = y.atan2(x) + (random.unit() * count).trunc() * turn;
        let l = square_of_radius(x, y).max(x.like(NEAREST)).ln() * (dist / 2.0);
        at_angle(a * re + l * im, (l * re - a * im).exp() * v.w)
    }

    Juliaq(v, x, y, random) {
        let [count, share, exponent, turn, ..] = v.p;
        let a = y.atan2(x) * share + (random.unit() * count).trunc() * turn;
        at_angle(a, square_of_radius(x, y).max(x.like(NEAREST)).pow(x.like(exponent)) * v.w)
    }

    EJulia(v, x, y, random) {
        let [count, turn, ..] = v.p;
        let k = if turn < 0.0 { over(1.0, square_of_radius(x, y)) } else { x.like(1.0) };
        let (x, y) = (k * x, k * y);
        let Ellipse { longest, beyond, across } = Ellipse::of(x, y);
        let mu = (longest + (beyond * (longest + 1.0)).sqrt()).ln();
        let nu = across.copysign(y).atan2(x);
        let (s, c) = root(nu, count, turn, random).sin_cos();
        let (sinh, cosh) = near(mu / turn).sinh_cosh();
        (cosh * c * v.w, sinh * s * v.w)
    }

    BTransform(v, x, y, random) {
        let [count, turn, rotation, shift, split, ..] = v.p;
        let shift = N::select(x.less(x.like(0.0)), x.like(shift - split), x.like(shift + split));
        let tau = (square_of_radius(x + 1.0, y) / square_of_radius(x - 1.0, y)).ln() * 0.5;
        let sigma = -(y.atan2(x + 1.0) + y.atan2(-(x - 1.0))) + (PI + rotation);
        let (s, c) = (root(sigma, count, turn, random) * 0.5).sin_cos();
        let (sinh, cosh) = near((tau / turn + shift) * 0.5).sinh_cosh();
        let k = over(v.w, square_of_radius(sinh, s));
        (k * sinh * cosh, k * s * c)
    }

    Acosech(v, x, y, random) {
        let r2 = square_of_radius(x, y);
        let (re, im) = area_cosine(x / r2, -y / r2);
        let k = of_random_sign(v.w * FRAC_2_PI, x, random);
        (k * im, k * re)
    }

    Acosh(v, x, y, random) {
        let (re, im) = area_cosine(x, y);
        let k = of_random_sign(v.w * FRAC_2_PI, x, random);
        (k * re, k * im)
    }

    Julian2(v, x, y, random) {
        let [count, turn, exponent, a, b, c, d, e, f, ..] = v.p;
        let (x, y) = (x * a + y * b + e, x * c + y * d + f);
        let k = square_of_radius(x, y).max(x.like(NEAREST)).pow(x.like(exponent)) * v.w;
        at_angle(root(y.atan2(x), count, turn, random), k)
    }

    PowBlock(v, x, y, random) {
        let [share, turn, exponent, count, ..] = v.p;
        let k = square_of_radius(x, y).max(x.like(NEAREST)).pow(x.like(exponent)) * v.w;
        at_angle(y.atan2(x) * share + (random.unit() * count).floor() * turn, k)
    }

    Hypertile(v, x, y) {
        tile(x, y, x.like(v.p[0]), x.like(v.p[1]), v.w)
    }

    Hypertile1(v, x, y, random) {
        let [rho, count, ..] = v.p;
        let (re, im) = at_angle((random.unit() * count).trunc() * (TAU / count), x.like(rho));
        tile(x, y, re, im, v.w)
    }

    Hypertile2(v, x, y, random) {
        let [rho, count, ..] = v.p;
        let (x, y) = tile(x, y, x.like(rho), x.like(0.0), v.w);
        let (s, c) = ((random.unit() * count).trunc() * (TAU / count)).sin_cos();
        (x * c - y * s, x * s + y * c)
    }
}

/// The area hyperbolic cosine of x + iy, whose real part is not negative.
#[inline(always)]
fn area_cosine<N: Number>(x: N, y: N) -> (N, N) {
    // √(z² - 1), on the side of z: what is on the other side has the other sign.
    let (re, im) = square_root((x - 1.0) * (x + 1.0) - y * y, x * y * 2.0);
    let is_left = x.less(x.like(0.0));
    let (re, im) = (x + N::select(is_left, -re, re), y + N::select(is_left, -im, im));
    (square_of_radius(re, im).ln() * 0.5, im.atan2(re))
}

/// `weight`, or what is as far below 0.
#[inline(always)]
fn of_random_sign<N: Number, R: Random<N>>(weight: f64, like: N, random: &mut R) -> N {
    N::select(random.coin(), like.like(weight), like.like(-weight))
}

/// One of `count` angles whose `turn`-th multiple is `angle`.
#[inline(always)]
pub(super) fn root<N: Number, R: Random<N>>(angle: N, count: f64, turn: f64, random: &mut R) -> N {
    (angle + (random.unit() * count).trunc() * TAU) / turn
}

/// (ζ + s̄) / (s ζ + 1), times `weight`, where ζ = x + iy and s = re + i im.
#[inline(always)]
fn tile<N: Number>(x: N, y: N, re: N, im: N, weight: f64) -> (N, N) {
    let (a, b) = (x + re, y - im);
    let (c, d) = (x * re - y * im + 1.0, x * im + y * re);
    let k = over(weight, square_of_radius(c, d));
    (k * (a * c + b * d), k * (b * c - a * d))
}

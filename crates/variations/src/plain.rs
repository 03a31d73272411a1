//! The paper's formulas that draw no random numbers.
//!
//! Owns 36 of V0 to V48; the other 13 are in `chance.rs`. A reader with the paper open finds each by its name. With `x`
//! and `y` the point after the affine part: `r2` is x² + y², `theta` is atan2(x, y), `phi` is atan2(y, x), `v.w` is the
//! variation's weight, and `v.p` holds what [`Compiled::new`](super::Compiled::new) made of its parameters.
//!
//! # Source
//! Draves & Reckase, *The Fractal Flame Algorithm* (2008), appendix. Where the paper leaves a choice (the guard against
//! division by zero, axes of blob and rings2) the pictures of `flam3-render` decide.

use std::f64::consts::PI;

use super::formulas::{TINY, at_angle, formulas, over, radius, remainder, square_of_radius};
use crate::number::Number;

formulas! {
    Linear(v, x, y) {
        (x * v.w, y * v.w)
    }

    Sinusoidal(v, x, y) {
        (x.sin() * v.w, y.sin() * v.w)
    }

    Spherical(v, x, y) {
        let s = over(v.w, square_of_radius(x, y) + v.floor);
        (s * x, s * y)
    }

    Swirl(v, x, y) {
        let (s, c) = square_of_radius(x, y).sin_cos();
        ((s * x - c * y) * v.w, (c * x + s * y) * v.w)
    }

    Horseshoe(v, x, y) {
        let s = over(v.w, radius(x, y) + TINY);
        (s * (x - y) * (x + y), s * x * y * 2.0)
    }

    Polar(v, x, y) {
        (x.atan2(y) * (v.w / PI), (radius(x, y) - 1.0) * v.w)
    }

    Handkerchief(v, x, y) {
        let (r, theta) = (radius(x, y), x.atan2(y));
        (r * (theta + r).sin() * v.w, r * (theta - r).cos() * v.w)
    }

    Heart(v, x, y) {
        let r = radius(x, y);
        let (s, c) = (x.atan2(y) * r).sin_cos();
        (r * s * v.w, r * c * -v.w)
    }

    Disc(v, x, y) {
        let (c, s) = at_angle(radius(x, y) * PI, x.atan2(y) * (v.w / PI));
        (s, c)
    }

    Spiral(v, x, y) {
        let r = radius(x, y);
        let (s, c) = r.sin_cos();
        let k = over(v.w, r + v.floor);
        (k * (y / r + s), k * (x / r - c))
    }

    Hyperbolic(v, x, y) {
        let r = radius(x, y);
        (x / r / (r + v.floor) * v.w, y / r * r * v.w)
    }

    Diamond(v, x, y) {
        let r = radius(x, y);
        let (s, c) = r.sin_cos();
        (x / r * c * v.w, y / r * s * v.w)
    }

    Ex(v, x, y) {
        let (r, theta) = (radius(x, y), x.atan2(y));
        let (s, c) = ((theta + r).sin(), (theta - r).cos());
        let (m, n) = (s * s * s * r, c * c * c * r);
        ((m + n) * v.w, (m - n) * v.w)
    }

    Bent(v, x, y) {
        (bent(x, 2.0) * v.w, bent(y, 0.5) * v.w)
    }

    Waves(v, x, y) {
        ((x + (y * v.p[1]).sin() * v.p[0]) * v.w, (y + (x * v.p[3]).sin() * v.p[2]) * v.w)
    }

    Fisheye(v, x, y) {
        let s = over(2.0 * v.w, radius(x, y) + 1.0);
        (s * y, s * x)
    }

    Popcorn(v, x, y) {
        ((x + (y * 3.0).tan().sin() * v.p[0]) * v.w, (y + (x * 3.0).tan().sin() * v.p[1]) * v.w)
    }

    Exponential(v, x, y) {
        at_angle(y * PI, (x - 1.0).exp() * v.w)
    }

    Power(v, x, y) {
        let r = radius(x, y);
        let (sin, cos) = (x / r, y / r);
        let s = r.pow(sin) * v.w;
        (s * cos, s * sin)
    }

    Cosine(v, x, y) {
        let (s, c) = (x * PI).sin_cos();
        let (sinh, cosh) = y.sinh_cosh();
        (c * cosh * v.w, s * sinh * -v.w)
    }

    Rings(v, x, y) {
        let (r, d) = (radius(x, y), v.p[0]);
        let s = (remainder(r + d, 2.0 * d) - d + r * (1.0 - d)) * v.w;
        (s * (y / r), s * (x / r))
    }

    Fan(v, x, y) {
        let theta = x.atan2(y);
        let half = v.p[0] / 2.0;
        let is_beyond = theta.like(half).less(remainder(theta + v.p[1], v.p[0]));
        at_angle(N::select(is_beyond, theta - half, theta + half), radius(x, y) * v.w)
    }

    Blob(v, x, y) {
        let wave = (x.atan2(y) * v.p[2]).sin() * 0.5 + 0.5;
        let s = (wave * v.p[1] + v.p[0]) * v.w;
        (s * x, s * y)
    }

    Pdj(v, x, y) {
        (((y * v.p[0]).sin() - (x * v.p[1]).cos()) * v.w, ((x * v.p[2]).sin() - (y * v.p[3]).cos()) * v.w)
    }

    Fan2(v, x, y) {
        let theta = x.atan2(y);
        let half = v.p[0] / 2.0;
        let is_beyond = theta.like(half).less(remainder(theta + v.p[1], v.p[0]));
        let (c, s) = at_angle(N::select(is_beyond, theta - half, theta + half), radius(x, y) * v.w);
        (s, c)
    }

    Rings2(v, x, y) {
        let (r, d) = (radius(x, y), v.p[0]);
        let s = (r - ((r + d) / (2.0 * d)).trunc() * (2.0 * d) + r * (1.0 - d)) * v.w;
        (s * (x / r), s * (y / r))
    }

    Eyefish(v, x, y) {
        let s = over(2.0 * v.w, radius(x, y) + 1.0);
        (s * x, s * y)
    }

    Perspective(v, x, y) {
        let t = over(v.w, -(y * v.p[1] - v.p[0]));
        (t * x * v.p[0], t * y * v.p[2])
    }

    Ngon(v, x, y) {
        let (phi, side) = (y.atan2(x), v.p[1]);
        let t = phi - (phi / side).floor() * side;
        let t = N::select(t.like(side / 2.0).less(t), t - side, t);
        let corner = (over(1.0, t.cos() + TINY) - 1.0) * v.p[2] + v.p[3];
        let k = corner * v.w / (square_of_radius(x, y).pow(x.like(v.p[0])) + TINY);
        (k * x, k * y)
    }

    Curl(v, x, y) {
        let re = x * v.p[0] + (x - y) * (x + y) * v.p[1] + 1.0;
        let im = y * v.p[0] + x * y * (2.0 * v.p[1]);
        let k = over(v.w, square_of_radius(re, im));
        (k * (x * re + y * im), k * (y * re - x * im))
    }

    Rectangles(v, x, y) {
        (fold(x, v.p[0]) * v.w, fold(y, v.p[1]) * v.w)
    }

    Tangent(v, x, y) {
        let (s, c) = y.sin_cos();
        (x.sin() / c * v.w, s / c * v.w)
    }

    Secant2(v, x, y) {
        let c = (radius(x, y) * v.w).cos();
        let one = c.like(1.0).copysign(c);
        (x * v.w, (over(1.0, c) - one) * v.w)
    }

    Cross(v, x, y) {
        let s = (x - y) * (x + y);
        let k = over(v.w, (s * s + v.floor).sqrt());
        (k * x, k * y)
    }
}

/// `value`, times `factor` where it is negative.
#[inline(always)]
fn bent<N: Number>(value: N, factor: f64) -> N {
    N::select(value.less(value.like(0.0)), value * factor, value)
}

/// Folds a coordinate about the middle of its cell.
#[inline(always)]
fn fold<N: Number>(value: N, cell: f64) -> N {
    if cell == 0.0 { value } else { ((value / cell).floor() * 2.0 + 1.0) * cell - value }
}

//! Formulas that were added after the paper and draw no random numbers.
//!
//! Owns those of V49 to V97 that are neither in `chance.rs` nor in `complex.rs`. The letters are those of `plain.rs`.
//!
//! # Source
//! What is published of each variation's geometry. Signs, guards and the order of axes, the pictures of `flam3-render`
//! decide.

use std::f64::consts::{FRAC_1_PI, PI, TAU};

use super::formulas::{TINY, at_angle, formulas, over, radius, remainder, square_of_radius};
use crate::number::Number;

formulas! {
    Disc2(v, x, y) {
        let [turns, sin, cos, ..] = v.p;
        let (s, c) = ((x + y) * turns).sin_cos();
        let k = x.atan2(y) * (v.w * FRAC_1_PI);
        (k * (s + cos), k * (c + sin))
    }

    Bent2(v, x, y) {
        let zero = x.like(0.0);
        (
            N::select(x.less(zero), x * v.p[0], x) * v.w,
            N::select(y.less(zero), y * v.p[1], y) * v.w,
        )
    }

    Butterfly(v, x, y) {
        let wing = y * 2.0;
        // 4 / √(3 π)
        let k = ((x * y).abs() / (square_of_radius(x, wing) + TINY)).sqrt() * (v.w * 1.302_940_031_741_119_8);
        (k * x, k * wing)
    }

    Cell(v, x, y) {
        let size = v.p[0];
        let (column, row) = ((x / size).floor(), (y / size).floor());
        let (left_x, left_y) = (x - column * size, y - row * size);
        ((left_x + interleaved(column) * size) * v.w, (left_y + interleaved(row) * size) * -v.w)
    }

    Curve(v, x, y) {
        let [x_height, y_height, x_length, y_length, ..] = v.p;
        let bump = |at: N, length: f64| (at * at / -(length * length).max(1e-20)).exp();
        ((x + bump(y, x_length) * x_height) * v.w, (y + bump(x, y_length) * y_height) * v.w)
    }

    Lazysusan(v, x, y) {
        let [spin, space, twist, centre_x, centre_y, ..] = v.p;
        let (x, y) = (x - centre_x, y + centre_y);
        let r = radius(x, y);
        let is_inside = r.less(r.like(v.w));
        let (turned_x, turned_y) = at_angle(y.atan2(x) + spin - (r - v.w) * twist, r);
        let k = over(space, r) + 1.0;
        (
            N::select(is_inside, turned_x, k * x) * v.w + centre_x,
            N::select(is_inside, turned_y, k * y) * v.w - centre_y,
        )
    }

    Loonie(v, x, y) {
        let r2 = square_of_radius(x, y);
        let w2 = r2.like(v.w * v.w);
        let k = N::select(r2.less(w2), ((w2 - r2) / r2).sqrt(), r2.like(1.0)) * v.w;
        (k * x, k * y)
    }

    Modulus(v, x, y) {
        (wrapped(x, v.p[0]) * v.w, wrapped(y, v.p[1]) * v.w)
    }

    Oscilloscope(v, x, y) {
        let [separation, frequency, amplitude, damping, ..] = v.p;
        let wave = (x * (TAU * frequency)).cos() * amplitude;
        let wave = if damping == 0.0 { wave } else { wave * (x.abs() * -damping).exp() };
        let is_outside = (wave + separation).less(y.abs());
        (x * v.w, N::select(is_outside, y, -y) * v.w)
    }

    Polar2(v, x, y) {
        (x.atan2(y) * (v.w * FRAC_1_PI), square_of_radius(x, y).ln() * (v.w * FRAC_1_PI / 2.0))
    }

    Popcorn2(v, x, y) {
        let [x_height, y_height, stretch, ..] = v.p;
        (
            (x + (y * stretch).tan().sin() * x_height) * v.w,
            (y + (x * stretch).tan().sin() * y_height) * v.w,
        )
    }

    Scry(v, x, y) {
        let r2 = square_of_radius(x, y);
        let k = over(1.0, r2.sqrt() * (r2 + 1.0 / (v.w + TINY)));
        (k * x, k * y)
    }

    Separation(v, x, y) {
        (separated(x, v.p[0], v.p[1]) * v.w, separated(y, v.p[2], v.p[3]) * v.w)
    }

    Split(v, x, y) {
        let zero = x.like(0.0);
        let turns_y = (x * (v.p[0] * PI)).cos().less(zero);
        let turns_x = (y * (v.p[1] * PI)).cos().less(zero);
        (N::select(turns_x, -x, x) * v.w, N::select(turns_y, -y, y) * v.w)
    }

    Splits(v, x, y) {
        let zero = x.like(0.0);
        (
            N::select(x.less(zero), x - v.p[0], x + v.p[0]) * v.w,
            N::select(y.less(zero), y - v.p[1], y + v.p[1]) * v.w,
        )
    }

    Stripes(v, x, y) {
        let middle = (x + 0.5).floor();
        let offset = x - middle;
        ((offset * (1.0 - v.p[0]) + middle) * v.w, (y + offset * offset * v.p[1]) * v.w)
    }

    Wedge(v, x, y) {
        let [angle, hole, count, swirl, ..] = v.p;
        let r = radius(x, y);
        at_angle(wedged(y.atan2(x) + r * swirl, angle, count), (r + hole) * v.w)
    }

    WedgeSph(v, x, y) {
        let [angle, hole, count, swirl, ..] = v.p;
        let r = over(1.0, radius(x, y) + TINY);
        at_angle(wedged(y.atan2(x) + r * swirl, angle, count), (r + hole) * v.w)
    }

    Whorl(v, x, y) {
        let r = radius(x, y);
        let is_inside = r.less(r.like(v.w));
        let strength = N::select(is_inside, r.like(v.p[0]), r.like(v.p[1]));
        at_angle(y.atan2(x) - strength / (r - v.w), r * v.w)
    }

    Waves2(v, x, y) {
        let [x_scale, y_scale, x_frequency, y_frequency, ..] = v.p;
        (
            (x + (y * x_frequency).sin() * x_scale) * v.w,
            (y + (x * y_frequency).sin() * y_scale) * v.w,
        )
    }

    Auger(v, x, y) {
        let [frequency, weight, symmetry, scale, ..] = v.p;
        let (s, t) = ((x * frequency).sin(), (y * frequency).sin());
        let drilled_y = (y.abs() + scale / 2.0) * s * weight;
        let drilled_x = (x.abs() + scale / 2.0) * t * weight;
        ((x + drilled_x * symmetry) * v.w, (y + drilled_y) * v.w)
    }

    Flux(v, x, y) {
        let (plus, minus) = (x + v.w, x - v.w);
        let stretch = (square_of_radius(plus, y) / square_of_radius(minus, y)).sqrt().sqrt();
        at_angle((y.atan2(minus) - y.atan2(plus)) * 0.5, stretch * (v.w * (2.0 + v.p[0])))
    }
}

/// The even numbers for cells from 0 on, the odd ones, negative, for those below.
#[inline(always)]
fn interleaved<N: Number>(cell: N) -> N {
    N::select(cell.less(cell.like(0.0)), -(cell * 2.0 + 1.0), cell * 2.0)
}

/// `value` in `-limit..limit`: what leaves on one side comes back on the other.
#[inline(always)]
fn wrapped<N: Number>(value: N, limit: f64) -> N {
    let left = remainder(value.abs() + limit, 2.0 * limit) - limit;
    let sign = value.like(1.0).copysign(value);
    N::select(value.like(limit).less(value.abs()), left * sign, value)
}

/// A coordinate moved away from 0 along a hyperbola.
#[inline(always)]
fn separated<N: Number>(value: N, gap: f64, inside: f64) -> N {
    let moved = (value * value + gap * gap).sqrt();
    N::select(value.like(0.0).less(value), moved - value * inside, -(moved + value * inside))
}

/// A direction in a circle from which `count` wedges of `angle` are cut, the rest spread out.
#[inline(always)]
pub(super) fn wedged<N: Number>(phi: N, angle: f64, count: f64) -> N {
    let wedge = ((phi * count + PI) * (FRAC_1_PI / 2.0)).floor();
    phi * (1.0 - angle * count * (FRAC_1_PI / 2.0)) + wedge * angle
}

//! Formulas of other programs that draw a curve or a figure, or put the plane into one.
//!
//! Owns those that are neither waves (`waves.rs`), tiles (`tiles.rs`), roots (`roots.rs`) nor blurs (`blurs.rs`). The letters
//! are those of `plain.rs`.
//!
//! # Source
//! What `JWildfire`, Fractorium and Apophysis plugins of these names compute, in their authors' descriptions.

use std::f64::consts::{FRAC_1_PI, FRAC_1_SQRT_2, FRAC_PI_4, PI, TAU};

use super::complex::near;
use super::formulas::{TINY, at_angle, formulas, over, radius, remainder, square_of_radius};
use super::roots::NEAREST;

formulas! {
    YinYang(v, x, y, random) {
        let [size, sin, cos, other_sin, other_cos, is_dual, outside, ..] = v.p;
        let one = x.like(1.0);
        let pick = |is_other: N::Mask, own: f64, other: f64| N::select(is_other, one * other, one * own);
        let is_other = if is_dual == 0.0 { one.less(one) } else { random.coin() };
        let rho = pick(is_other, size, 1.0 - size);
        let (s, c) = (pick(is_other, sin, other_sin), pick(is_other, cos, other_cos));
        let sign = pick(is_other, v.w, -v.w);
        let (turned_x, turned_y) = (x * c - y * s, x * s + y * c);
        let t = (-(turned_y * turned_y) + 1.0).max(x.like(TINY)).sqrt();
        let alpha = -(turned_x / t - 1.0) * 0.5;
        let k = alpha * rho - (alpha - 1.0);
        let high = t * 2.0 - 1.0;
        let rest = (-(high * high) + 1.0).max(x.like(0.0)).sqrt();
        let is_upper = x.like(0.0).less(turned_y);
        let less = -(rho - 1.0);
        let inside_x = N::select(is_upper, high * k - alpha * less, turned_x * less + rho);
        let inside_y = N::select(is_upper, rest * k, turned_y * less);
        let is_inside = square_of_radius(x, y).less(one);
        let beyond = if outside == 0.0 { 0.0 } else { v.w };
        (
            N::select(is_inside, inside_x * sign, x * beyond),
            N::select(is_inside, inside_y * sign, y * beyond),
        )
    }

    Glynnia(v, x, y, random) {
        let r = radius(x, y);
        // r + x, without a difference of neighbours.
        let zero = x.like(0.0);
        let sum = N::select(x.less(zero), y * y / (r - x), r + x);
        let d = sum.sqrt();
        let (first_x, first_y) = (d * FRAC_1_SQRT_2, -(y / d) * FRAC_1_SQRT_2);
        let k = over(1.0, (r * (y * y + sum * sum)).sqrt());
        let is_first = random.coin();
        let (x, y) = (N::select(is_first, first_x, k * sum), N::select(is_first, first_y, k * y));
        (N::select(r.like(1.0).less(r), x, -x) * v.w, y * v.w)
    }

    CloverleafWf(v, x, y, random) {
        let theta = x.atan2(y);
        let curve = (theta * 2.0).sin() + (theta * 6.0).sin() * 0.25;
        let (unit, chance) = (random.unit(), random.unit());
        let filled = N::select(chance.less(chance.like(v.p[0])), unit, unit.like(1.0));
        let (c, s) = at_angle(theta, curve * filled * v.w);
        (s, c)
    }

    CannabiscurveWf(v, x, y, random) {
        let theta = x.atan2(y);
        let leaves = (theta * 8.0).cos() * 0.9 + 1.0;
        let veins = (theta * 24.0).cos() * 0.1 + 1.0;
        let teeth = (theta * 200.0).cos() * 0.1 + 0.9;
        let (unit, chance) = (random.unit(), random.unit());
        let filled = N::select(chance.less(chance.like(v.p[0])), unit, unit.like(1.0));
        let (c, s) = at_angle(theta, leaves * veins * teeth * (theta.sin() + 1.0) * filled * v.w);
        (c, -s)
    }

    Target(v, x, y) {
        let [even, odd, size, ..] = v.p;
        let depth = square_of_radius(x, y).ln() * 0.5;
        let zero = x.like(0.0);
        let depth = N::select(depth.less(zero), depth - size / 2.0, depth).abs();
        let is_even = remainder(depth, size).less(x.like(size / 2.0));
        let angle = y.atan2(x) + N::select(is_even, x.like(even), x.like(odd));
        at_angle(angle, radius(x, y))
    }

    EpispiralWf(v, x, y) {
        let theta = x.atan2(y);
        let (c, s) = at_angle(theta, over(0.5 * v.w, (theta * v.p[0]).cos()));
        (s, c)
    }

    Epispiral(v, x, y, random) {
        let [count, thickness, holes, ..] = v.p;
        let phi = y.atan2(x);
        let length = if thickness == 0.0 { phi.like(1.0) } else { random.unit() * thickness };
        at_angle(phi, (length / (phi * count).cos() - holes) * v.w)
    }

    Fdisc(v, x, y) {
        at_angle(over(TAU, radius(x, y) + 1.0), (y.atan2(x) * FRAC_1_PI + 1.0) * (v.w / 2.0))
    }

    Unpolar(v, x, y) {
        let (c, s) = at_angle(x, y.exp() * (v.w / TAU));
        (s, c)
    }

    Twoface(v, x, y) {
        let is_right = x.like(0.0).less(x);
        let k = N::select(is_right, over(v.w, square_of_radius(x, y)), x.like(v.w));
        (k * x, k * y)
    }

    Xheart(v, x, y) {
        let [stretch, sin, cos, ..] = v.p;
        let k = over(1.0, square_of_radius(x, y) + 4.0);
        let (x, y) = (k * x * 4.0, k * y * stretch);
        let (turned_x, turned_y) = (x * cos - y * sin, x * sin + y * cos);
        let is_right = x.like(0.0).less(turned_x);
        (turned_x * v.w, N::select(is_right, turned_y, -turned_y) * v.w)
    }

    Cardioid(v, x, y) {
        let phi = y.atan2(x);
        at_angle(phi, (square_of_radius(x, y) + (phi * v.p[0]).sin() + 1.0).sqrt() * v.w)
    }

    Idisc(v, x, y) {
        at_angle(over(PI, radius(x, y) + 1.0), y.atan2(x) * (v.w * FRAC_1_PI))
    }

    Asteria(v, x, y, random) {
        let [sin, cos, ..] = v.p;
        let one = x.like(1.0);
        let (x, y) = (x * v.w, y * v.w);
        let is_inside = square_of_radius(x, y).less(one);
        // Near a corner of the square around the unit circle.
        let is_corner = square_of_radius(x.abs() - 1.0, y.abs() - 1.0).less(one);
        let is_kept = random.unit();
        let is_bent = is_inside & (!is_corner | is_kept.less(is_kept.like(0.35)));
        let (across, along) = (x * cos - y * sin, x * sin + y * cos);
        let depth = -(along.abs() - 1.0);
        let zero = x.like(0.0);
        let root = |value: N| (-(value * value) + 1.0).max(zero).sqrt();
        let bent = across / root(along) * (-(root(depth)) + 1.0);
        (
            N::select(is_bent, bent * cos + along * sin, x),
            N::select(is_bent, along * cos - bent * sin, y),
        )
    }

    Circlize(v, x, y) {
        let zero = x.like(0.0);
        let (far_x, far_y) = (x.abs(), y.abs());
        let side = far_x.max(far_y).max(x.like(TINY));
        // How far the point is along the square from its lower right corner.
        let upright = N::select(x.less(zero), far_x * 5.0 - y, far_x + y);
        let level = N::select(y.less(zero), far_y * 7.0 + x, far_y * 3.0 - x);
        let along = N::select(far_x.less(far_y), level, upright);
        at_angle((along / side - 1.0) * FRAC_PI_4, side * (v.w / FRAC_PI_4) + v.p[0])
    }

    Eclipse(v, x, y) {
        let half2 = -(y * y) + v.w * v.w;
        let moved = x + v.p[0] * v.w;
        let is_inside = (x * x).less(half2);
        let is_left = (moved * moved).less(half2);
        let seen = N::select(is_left, moved, -x);
        let is_shaded = if v.w > 0.0 { is_inside } else { x.less(x) };
        (N::select(is_shaded, seen, x) * v.w, y * v.w)
    }

    Petal(v, x, y) {
        let ((s, c), height) = (x.sin_cos(), y.cos());
        let (across, along) = (c * height, s * height);
        let k = c * v.w;
        (k * across * across * across, k * along * along * along)
    }

    HeartWf(v, x, y) {
        let [left, right, shift, x_scale, ..] = v.p;
        let phi = x.atan2(y);
        let is_left = phi.less(phi.like(0.0));
        let t = (N::select(is_left, phi * left, phi * right) - shift).min(phi.like(60.0));
        let (s, c) = at_angle(t * (PI / 180.0), radius(x, y) * (v.w * 0.001));
        let bow = t * (-(t) + 40.0);
        let along = (bow + 1200.0) * c * x_scale;
        (N::select(is_left, -along, along), -((bow + 400.0) * s))
    }

    RoseWf(v, x, y, random) {
        let [size, waves, filled, ..] = v.p;
        let theta = x.atan2(y);
        let (unit, chance) = (random.unit(), random.unit());
        let filled = N::select(chance.less(chance.like(filled)), unit, unit.like(1.0));
        let (c, s) = at_angle(theta, (theta * waves).cos() * filled * (size * v.w));
        (s, c)
    }

    Tancos(v, x, y) {
        let r2 = square_of_radius(x, y).max(x.like(NEAREST));
        let (sinh, cosh) = near(r2).sinh_cosh();
        let k = over(2.0 * v.w, r2);
        (k * x * (sinh / cosh), k * y * r2.cos())
    }

    TargetSp(v, x, y) {
        let [tightness, arms, size, turn, ..] = v.p;
        let (phi, r) = (y.atan2(x), radius(x, y));
        let depth = r.max(x.like(TINY)).ln() * tightness + (phi + PI) * arms;
        let depth = N::select(depth.less(x.like(0.0)), depth - size / 2.0, depth).abs();
        let is_even = remainder(depth, size).less(x.like(size / 2.0));
        at_angle(phi + N::select(is_even, x.like(turn), x.like(turn - PI)), r)
    }

    GlynnSim2(v, x, y, random) {
        let [size, outer, width, from, along, contrast, exponent, ..] = v.p;
        let r = radius(x, y);
        let (arc_x, arc_y) = at_angle(random.unit() * along + from, -(random.unit() * width) + outer);
        let alpha = over(size, r);
        let unit = random.unit();
        let is_inverted = unit.less(alpha.abs().pow(r.like(exponent)) * contrast);
        let k = N::select(is_inverted, alpha * alpha, alpha.like(1.0));
        let is_inside = r.less(r.like(size));
        (N::select(is_inside, arc_x, k * x) * v.w, N::select(is_inside, arc_y, k * y) * v.w)
    }
}

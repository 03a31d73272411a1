//! Formulas of other programs in the plane: waves, tiles and figures.
//!
//! Owns those that are neither roots (`roots.rs`) nor blurs (`blurs.rs`). The letters are those of `plain.rs`.
//!
//! # Source
//! What `JWildfire`, Fractorium and Apophysis plugins of these names compute, in their authors' descriptions.

use std::f64::consts::{FRAC_1_PI, FRAC_1_SQRT_2, PI, TAU};

use super::formulas::{TINY, at_angle, formulas, over, radius, remainder, square_of_radius};
use super::space::bent;
use crate::number::Number;

formulas! {
    Waves2b(v, x, y) {
        let [x_frequency, y_frequency, x_power, y_power, x_scale, x_far, y_scale, y_far, unity, ..] = v.p;
        let height = |at: N, scale: f64, far: f64| over((scale - far) * unity, at * at + unity) + far;
        let wave = |at: N, power: f64, frequency: f64| (bent(at, power) * frequency).sin();
        (
            (x + height(x, x_scale, x_far) * wave(y, x_power, x_frequency)) * v.w,
            (y + height(y, y_scale, y_far) * wave(x, y_power, y_frequency)) * v.w,
        )
    }

    Waves2Wf(v, x, y) {
        let [x_damp, x_scale, x_frequency, x_is_cos, y_damp, y_scale, y_frequency, y_is_cos, ..] = v.p;
        (
            (x * x_damp + wave(y * x_frequency, x_is_cos) * x_scale) * v.w,
            (y * y_damp + wave(x * y_frequency, y_is_cos) * y_scale) * v.w,
        )
    }

    Waves3Wf(v, x, y) {
        let [x_damp, x_scale, x_frequency, x_is_cos, y_damp, y_scale, y_frequency, y_is_cos, ..] = v.p;
        let (x_wave, y_wave) = (wave(y * x_frequency, x_is_cos), wave(x * y_frequency, y_is_cos));
        ((x * x_damp + x_wave * x_wave * x_scale) * v.w, (y * y_damp + y_wave * y_wave * y_scale) * v.w)
    }

    Waves4Wf(v, x, y) {
        let [x_damp, x_scale, x_frequency, x_is_cos, y_damp, y_scale, y_frequency, y_is_cos, ..] = v.p;
        let cubed = |angle: N, is_cos: f64| {
            let (sin, cos) = angle.sin_cos();
            sin * cos * if is_cos == 0.0 { sin } else { cos }
        };
        let (x_wave, y_wave) = (cubed(y * x_frequency, x_is_cos), cubed(x * y_frequency, y_is_cos));
        ((x * x_damp + x_wave * x_scale) * v.w, (y * y_damp + y_wave * y_scale) * v.w)
    }

    Bwraps(v, x, y) {
        let [size, square, stretch, flatness, inner, outer, ..] = v.p;
        if size == 0.0 {
            (x * v.w, y * v.w)
        } else {
            let (middle_x, middle_y) = (((x / size).floor() + 0.5) * size, ((y / size).floor() + 0.5) * size);
            let (off_x, off_y) = (x - middle_x, y - middle_y);
            let off2 = square_of_radius(off_x, off_y);
            let k = over(stretch, off2 * flatness + 1.0);
            let t = off2 * k * k / square;
            let (s, c) = (t * (outer - inner) + inner).sin_cos();
            let (bent_x, bent_y) = (off_x * k, off_y * k);
            let is_outside = off2.like(square).less(off2);
            (
                N::select(is_outside, x, middle_x + bent_x * c + bent_y * s) * v.w,
                N::select(is_outside, y, middle_y + bent_y * c - bent_x * s) * v.w,
            )
        }
    }

    Boarders2(v, x, y, random) {
        let [kept, push, chance, ..] = v.p;
        let (middle_x, middle_y) = (x.round(), y.round());
        let (off_x, off_y) = (x - middle_x, y - middle_y);
        let longest = off_x.abs().max(off_y.abs()).max(x.like(TINY));
        let unit = random.unit();
        let moved = N::select(unit.less(unit.like(chance)), over(push, longest), unit.like(0.0)) + kept;
        ((moved * off_x + middle_x) * v.w, (moved * off_y + middle_y) * v.w)
    }

    TileLog(v, x, y, random) {
        // Never the logarithm of 0.
        let far = (-(random.unit() - 1.0)).ln() * v.p[0];
        let far = N::select(random.coin(), far, -far);
        ((x + far.round()) * v.w, y * v.w)
    }

    Shredlin(v, x, y) {
        (shred(x, v.p[0], v.p[1]) * v.w, shred(y, v.p[2], v.p[3]) * v.w)
    }

    PointSymmetryWf(v, x, y, random) {
        let [centre_x, centre_y, order, ..] = v.p;
        let (off_x, off_y) = ((x - centre_x) * v.w, (y - centre_y) * v.w);
        let (s, c) = ((random.unit() * order).trunc() * (TAU / order)).sin_cos();
        (off_x * c + off_y * s + centre_x, off_y * c - off_x * s + centre_y)
    }

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

    Kaleidoscope(v, x, y) {
        let [cos, sin, across, above, below, ..] = v.p;
        let shift = N::select(x.like(0.0).less(y), x.like(above), x.like(below));
        (x * cos - y * sin + across, y * cos + x * sin + shift)
    }

    TileHlp(v, x, y, random) {
        let width = v.p[0];
        let cells = x / width;
        let part = cells - cells.trunc();
        let is_moved = (part * PI).cos().less(random.unit() * 2.0 - 1.0);
        let zero = x.like(0.0);
        let step = N::select(zero.less(cells), x.like(-width), x.like(width));
        ((x + N::select(is_moved, step, zero)) * v.w, y * v.w)
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
}

/// The sine, or the cosine.
#[inline(always)]
fn wave<N: Number>(angle: N, is_cos: f64) -> N {
    if is_cos == 0.0 { angle.sin() } else { angle.cos() }
}

/// A coordinate whose cells of the length `distance` are narrowed to a share `width` of it.
#[inline(always)]
fn shred<N: Number>(value: N, distance: f64, width: f64) -> N {
    let cells = value / distance;
    let whole = cells.trunc();
    let zero = value.like(0.0);
    let side = N::select(value.less(zero), value.like(-0.5), value.like(0.5));
    ((cells - whole) * width + whole + side * (1.0 - width)) * distance
}

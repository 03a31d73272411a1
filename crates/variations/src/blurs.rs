//! Formulas of other programs that blur, crop or make a random figure.
//!
//! Owns blurs whose shape does not depend on the point, those that push points along a line, and crops. The letters are
//! those of `plain.rs`.
//!
//! # Source
//! What `JWildfire`, Fractorium and Apophysis plugins of these names compute, in their authors' descriptions.

use std::f64::consts::{FRAC_2_PI, PI, TAU};

use super::MAX_PARAMETERS;
use super::chance::bell;
use super::formulas::{at_angle, formulas, radius, solids};
use crate::number::{Number, Random};

formulas! {
    Sineblur(v, _, _, random) {
        let angle = random.unit() * TAU;
        let u = random.unit();
        let u = u.pow(u.like(v.p[0])).min(u.like(1.0));
        // acos(2u - 1) is twice this angle.
        let half = (-(u - 1.0)).sqrt().atan2(u.sqrt());
        at_angle(angle, half * (v.w * FRAC_2_PI))
    }

    BlurCircle(v, _, _, random) {
        let angle = random.unit() * TAU;
        at_angle(angle, random.unit().sqrt() * v.w)
    }

    BlurLinear(v, x, y, random) {
        let far = random.unit();
        ((x + far * v.p[0]) * v.w, (y + far * v.p[1]) * v.w)
    }

    BlurZoom(v, x, y, random) {
        let [length, centre_x, centre_y, ..] = v.p;
        let k = random.unit() * length + 1.0;
        (((x - centre_x) * k + centre_x) * v.w, ((y + centre_y) * k - centre_y) * v.w)
    }

    Gaussian(v, x, y, random) {
        let angle = random.unit() * TAU;
        let (moved_x, moved_y) = at_angle(angle, bell(random) * v.w);
        (x + moved_x, y + moved_y)
    }

    Rblur(v, x, y, random) {
        let [strength, offset, centre_x, centre_y, ..] = v.p;
        let far = (radius(x - centre_x, y - centre_y) - offset).max(x.like(0.0)) * strength;
        let mut moved = |value: N| (value + (random.unit() - 0.5) * far) * v.w;
        (moved(x), moved(y))
    }

    Spirograph(v, _, _, random) {
        let [a, b, d, tmin, tspan, ymin, yspan, c1, c2, ..] = v.p;
        let (t, height) = (random.unit() * tspan + tmin, random.unit() * yspan + ymin);
        let (sin, cos) = t.sin_cos();
        let (wheel_sin, wheel_cos) = (t * ((a + b) / b)).sin_cos();
        ((cos * (a + b + d) - wheel_cos * c1 + height) * v.w, (sin * (a + b + d) - wheel_sin * c2 + height) * v.w)
    }

    Crop(v, x, y, random) {
        let [left, right, top, bottom, width, height, is_zero, ..] = v.p;
        if is_zero == 0.0 {
            (cropped(x, [left, right], width, random) * v.w, cropped(y, [top, bottom], height, random) * v.w)
        } else {
            let is_outside = is_beyond(x, left, right) | is_beyond(y, top, bottom);
            let k = N::select(is_outside, x.like(0.0), x.like(v.w));
            (k * x, k * y)
        }
    }

    Circlecrop(v, x, y, random) {
        let [size, centre_x, centre_y, scatter, is_zero, ..] = v.p;
        let (off_x, off_y) = (x - centre_x, y - centre_y);
        let r = radius(off_x, off_y);
        let border = if is_zero == 0.0 { (random.unit() * (scatter / 2.0) + size) / r } else { r.like(0.0) };
        let is_outside = r.like(size).less(r);
        // The weight does not move the centre.
        let point = |off: N, centre: f64| {
            let outside = if is_zero == 0.0 { off * border * v.w + centre } else { off.like(0.0) };
            N::select(is_outside, outside, off * v.w + centre)
        };
        (point(off_x, centre_x), point(off_y, centre_y))
    }
}

solids! {
    Smartcrop Makes(v, x, y, z, random) {
        let [_, _, _, _, size, edge, scatter, offset, turn, mode, keeps_inside, ..] = v.p;
        let (phi, r) = (y.atan2(x), radius(x, y));
        let shape = polygon(phi, &v.p);
        let border = shape * ((random.unit() - 0.5) * edge + size);
        let is_beyond = border.less(r);
        let goes = if keeps_inside == 0.0 { !is_beyond } else { is_beyond };
        let zero = x.like(0.0);
        let far = match mode {
            0.0 => zero,
            1.0 => border + shape * (random.unit() * scatter + offset),
            _ => r,
        };
        let (moved_x, moved_y) = at_angle(phi + turn, far * v.w);
        let moved_z = if mode == 0.0 { zero } else { z * v.w };
        [N::select(goes, moved_x, x * v.w), N::select(goes, moved_y, y * v.w), N::select(goes, moved_z, z * v.w)]
    }
}

/// How far the side of a polygon with rounded corners is at an angle, where the middle of a side is at 1.
#[inline(always)]
fn polygon<N: Number>(angle: N, [corner, roundness, width, distortion, ..]: &[f64; MAX_PARAMETERS]) -> N {
    if *distortion == 0.0 {
        return angle.like(1.0);
    }
    let sides = (angle + PI) / *corner;
    let part = sides - sides.trunc();
    let part = part.min(-(part - 1.0));
    let one = angle.like(1.0);
    let side = one / (part * *corner).cos();
    let side = if *roundness == 0.0 {
        side
    } else {
        let round = (part * 2.0).pow(angle.like(*width)) * *roundness;
        ((one - round) * side + round).abs()
    };
    side.pow(angle.like(*distortion))
}

/// `value`, or where it is beyond an end of `range`, a place up to `depth` inside of that end.
#[inline(always)]
fn cropped<N: Number, R: Random<N>>(value: N, range: [f64; 2], depth: f64, random: &mut R) -> N {
    let [low, high] = range;
    let inwards = random.unit() * depth;
    let below = N::select(value.less(value.like(low)), inwards + low, value);
    N::select(value.like(high).less(value), -inwards + high, below)
}

/// Whether `value` is outside of `low..=high`.
#[inline(always)]
fn is_beyond<N: Number>(value: N, low: f64, high: f64) -> N::Mask {
    value.less(value.like(low)) | value.like(high).less(value)
}

//! Formulas that change the colour of a point as well as its place.
//!
//! Owns symmetries and blurs that shift the colour coordinate, and colours by place. What is past 1 or below -1 goes round.
//! The letters are those of `plain.rs`.
//!
//! # Source
//! What `JWildfire`, Fractorium and Apophysis plugins of these names compute: points, chance and colours by the number.

use std::f64::consts::{PI, TAU};

use super::formulas::{at_angle, colours, radius, remainder, values};
use super::space::square_in_space;
use super::{Kind, MAX_PARAMETERS, Variation};
use crate::number::Number;

colours! {
    DcLinear None(v, from, _random) {
        let [sin, cos, offset, half, ..] = v.p;
        let (x, y) = (from.point[0] * v.w, from.point[1] * v.w);
        let along = (from.sum[0] + x) * cos + (from.sum[1] + y) * sin;
        ([x, y, x.like(0.0)], remainder(((along + offset) * half + 0.5).abs(), 1.0))
    }

    PointSymmetryWf None(v, from, random) {
        let [centre_x, centre_y, order, shift, ..] = v.p;
        let [x, y, _] = from.point;
        let (off_x, off_y) = ((x - centre_x) * v.w, (y - centre_y) * v.w);
        let turns = (random.unit() * order).trunc();
        let (s, c) = (turns * (TAU / order)).sin_cos();
        let point = [off_x * c + off_y * s + centre_x, off_y * c - off_x * s + centre_y, x.like(0.0)];
        (point, remainder(turns * shift + from.colour, 1.0))
    }

    AxisSymmetryWf Reads(v, from, random) {
        let [axis, cx, cy, cz, sin, cos, base, shift, other_shift, ..] = v.p;
        let [x, y, z] = from.point;
        let one = x.like(1.0);
        let is_first = random.coin();
        let side = N::select(is_first, one, -one);
        let (turn, mirrored) = (side * sin, |value: N, centre: f64| (value - centre + v.w / 2.0) * side);
        let (across, along) = match axis {
            axis if axis < 0.5 => (mirrored(x, cx), y - cy),
            axis if axis < 1.5 => (x - cx, mirrored(y, cy)),
            _ => (x - cx, mirrored(z, cz)),
        };
        let (x, other) = (across * cos + along * turn + cx, along * cos - across * turn);
        let point = if axis < 1.5 { [x, other + cy, z] } else { [x, y, other + base] };
        let shift = N::select(is_first, one * shift, one * other_shift);
        (point, remainder(from.colour + shift, 1.0))
    }

    Falloff2 Reads(v, from, random) {
        let [strength, nearest, mul_x, mul_y, mul_z, mul_c, x0, y0, z0, is_inverted, form, above, ..] = v.p;
        let [x, y, z] = from.point;
        let distance = square_in_space(x - x0, y - y0, z - z0).sqrt();
        let far = (inverted(distance, is_inverted) - nearest).max(x.like(0.0)) * strength;
        let mut moved = || (random.unit() - 0.5 + above) * far;
        let shifts = [moved(), moved(), moved()];
        let [x, y, z] = if form < 0.5 {
            even([x, y, z], shifts, [mul_x, mul_y, mul_z])
        } else if form < 1.5 {
            around_origin([x, y, z], shifts, [mul_x, mul_y, mul_z], x.like(0.0))
        } else {
            in_ball([x, y, z], shifts, [mul_x, mul_y, mul_z])
        };
        // Another number only where it is needed: pictures without it keep theirs.
        let colour = if mul_c == 0.0 { from.colour } else { remainder((moved() * mul_c + from.colour).abs(), 1.0) };
        ([x * v.w, y * v.w, z * v.w], colour)
    }

    Falloff3 Reads(v, from, random) {
        let [form, is_cube, strength, nearest, is_inverted, mul_x, mul_y, mul_z, mul_c, x0, y0, z0, twist, ..] = v.p;
        let [x, y, z] = from.point;
        let distance = if is_cube == 0.0 {
            square_in_space(x - x0, y - y0, z - z0).sqrt()
        } else {
            (x - x0).abs().max((y - y0).abs()).max((z - z0).abs())
        };
        let beyond = (inverted(distance, is_inverted) - nearest).max(x.like(0.0));
        let far = beyond * strength;
        let mut drawn = || random.unit() - 0.5;
        let [e1, e2, e3] = [drawn(), drawn(), drawn()];
        let shifts = [e1 * far, e2 * far, e3 * far];
        let point = if form < 0.5 {
            in_ball([x, y, z], shifts, [mul_x, mul_y, mul_z])
        } else {
            around_origin([x, y, z], shifts, [mul_x, mul_y, mul_z], e2 * beyond * twist)
        };
        let colour = remainder((drawn() * far * mul_c + from.colour).abs(), 1.0);
        (point.map(|axis| axis * v.w), colour)
    }
}

/// What `dc_linear` reads.
pub(super) fn dc_linear_values(q: &[f64; MAX_PARAMETERS]) -> [f64; MAX_PARAMETERS] {
    let (sin, cos) = libm::sincos(q[1]);
    values([sin, cos, q[0], 0.5 / q[2]])
}

/// What `falloff3` reads.
pub(super) fn falloff3_values(q: &[f64; MAX_PARAMETERS]) -> [f64; MAX_PARAMETERS] {
    let mut all = *q;
    all[2] = 0.04 * q[2];
    all[12] = q[12] * all[2].abs().sqrt();
    all
}

impl Variation {
    /// Whether it changes the colour of a point, with its parameters.
    #[expect(clippy::wildcard_enum_match_arm, reason = "all others leave colours as they are")]
    pub fn changes_colour(&self) -> bool {
        let shifts = match self.kind {
            Kind::DcLinear => &[1.0],
            Kind::FractJuliaWf => &self.params[9..10],
            Kind::PointSymmetryWf => &self.params[3..4],
            Kind::AxisSymmetryWf => &self.params[5..11],
            Kind::Falloff2 => &self.params[5..6],
            Kind::Falloff3 => &self.params[8..9],
            _ => &[][..],
        };
        shifts.iter().any(|shift| *shift != 0.0)
    }
}

/// The distance, or what it lacks of 1.
#[inline(always)]
fn inverted<N: Number>(distance: N, is_inverted: f64) -> N {
    if is_inverted == 0.0 { distance } else { (-(distance - 1.0)).max(distance.like(0.0)) }
}

/// The point, with each coordinate moved.
#[inline(always)]
fn even<N: Number>([x, y, z]: [N; 3], [e1, e2, e3]: [N; 3], [mul_x, mul_y, mul_z]: [f64; 3]) -> [N; 3] {
    [x + e1 * mul_x, y + e2 * mul_y, z + e3 * mul_z]
}

/// The point, with its distance from the origin, its longitude and its latitude moved, and `turn` added to the longitude.
#[inline(always)]
fn around_origin<N: Number>(
    [x, y, z]: [N; 3],
    [e1, e2, e3]: [N; 3],
    [mul_x, mul_y, mul_z]: [f64; 3],
    turn: N,
) -> [N; 3] {
    let rho = square_in_space(x, y, z).sqrt() + e1 * mul_x;
    let (c, s) = at_angle(z.atan2(radius(x, y)) + e3 * mul_z, rho);
    let (x, y) = at_angle(y.atan2(x) + e2 * mul_y + turn, c);
    [x, y, s]
}

/// The point, moved by a distance in a direction.
#[inline(always)]
fn in_ball<N: Number>([x, y, z]: [N; 3], [e1, e2, e3]: [N; 3], [mul_x, mul_y, mul_z]: [f64; 3]) -> [N; 3] {
    let (sin, cos) = (e2 * TAU).sin_cos();
    let (across, up) = at_angle(e3 * PI, e1 * cos);
    [x + across * mul_x, y + up * mul_y, z + e1 * sin * mul_z]
}

//! What the variations of other programs than flam3 precompute per transform.
//!
//! Owns the values that do not depend on the point. Those of flam3's variations are in `formulas.rs`, and
//! those that take many steps beside the formulas that read them. Never calculates with a point.
//!
//! Start at [`of_others`].

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, FRAC_PI_8, PI, TAU};

use super::cells::crackle_values;
use super::colours::{dc_linear_values, falloff3_values};
use super::formulas::values;
use super::synth::synth_values;
use super::tiles::{truchet_values, xtrb_values};
use super::waves::{vibration2_values, waves4_values};
use super::{Kind, MAX_PARAMETERS};

/// What the formula of `kind` reads, of its weight and its parameters in the order of [`Kind::parameters`].
#[expect(clippy::wildcard_enum_match_arm, reason = "most variations take their parameters as they are")]
pub(super) fn of_others(kind: Kind, weight: f64, q: &[f64; MAX_PARAMETERS]) -> [f64; MAX_PARAMETERS] {
    match kind {
        Kind::Spherical3DWf => values([-q[1] / 2.0, if q[0] == 0.0 { 1.0 } else { -1.0 }]),
        Kind::Julia3D => values([q[0].abs(), q[0], (1.0 / q[0] - 1.0) / 2.0]),
        Kind::Julia3Dz => values([q[0].abs(), q[0], 0.5 / q[0]]),
        Kind::Julian3Dx => values([q[1].abs(), q[1], (q[0] / q[1] - 1.0) / 2.0, q[2], q[3], q[4], q[5], q[6], q[7]]),
        Kind::Curl3D => values([q[0], q[1], q[2], square([q[0], q[1], q[2]])]),
        Kind::Blob3D => values([q[0], q[1] - q[0], q[2]]),
        Kind::Poincare3D => {
            let ((sin_a, cos_a), (sin_b, cos_b)) = (libm::sincos(q[1] * FRAC_PI_2), libm::sincos(q[2] * FRAC_PI_2));
            let centre = [-q[0] * cos_a * cos_b, q[0] * sin_a * cos_b, -q[0] * sin_b];
            values([centre[0], centre[1], centre[2], square(centre)])
        }
        Kind::RotateX | Kind::RotateY | Kind::RotateZ => {
            let (sin, cos) = libm::sincos(weight * FRAC_PI_2);
            values([sin, cos])
        }
        Kind::Falloff2 => {
            let mut all = *q;
            all[0] = 0.04 * q[0];
            all
        }
        Kind::Juliaq => values([q[0].abs(), q[1] / q[0], q[1] / q[0] / 2.0, TAU / q[0]]),
        Kind::EJulia => values([q[0].abs(), q[0]]),
        Kind::BTransform => values([q[1].abs(), q[1], q[0], q[2], q[3]]),
        Kind::Hypertile => {
            let (sin, cos) = libm::sincos(TAU * q[2] / q[0]);
            let rho = tile_radius(q[0], q[1]);
            values([rho * cos, rho * sin])
        }
        Kind::Hypertile1 | Kind::Hypertile2 => values([tile_radius(q[0], q[1]), q[0]]),
        Kind::BlurLinear => {
            let (sin, cos) = libm::sincos(q[1]);
            values([q[0] * cos, q[0] * sin])
        }
        Kind::Spirograph => values([q[0], q[1], q[2], q[3], q[4] - q[3], q[5], q[6] - q[5], q[7], q[8]]),
        Kind::Crop => {
            let ([left, right], [top, bottom]) = ([q[0].min(q[2]), q[0].max(q[2])], [q[1].min(q[3]), q[1].max(q[3])]);
            let half = q[4] / 2.0;
            values([left, right, top, bottom, (right - left) * half, (bottom - top) * half, q[5]])
        }
        Kind::Waves2Wf | Kind::Waves3Wf | Kind::Waves4Wf => {
            let (x, y) = (libm::exp(q[6]), libm::exp(q[7]));
            values([x, x * x * q[0], q[2], q[4], y, y * y * q[1], q[3], q[5]])
        }
        Kind::Bwraps => {
            let radius = q[0] / 2.0 / (1.0 + q[1] * q[1]);
            let gain = q[2] * q[2] + 1e-6;
            let bubble = gain * radius;
            let bubble = if bubble > 2.0 { 1.0 } else { bubble / (bubble * bubble / 4.0 + 1.0) };
            values([q[0], radius * radius, gain * radius / bubble, gain * gain / 4.0, q[3], q[4]])
        }
        Kind::YinYang => {
            let ((sin, cos), (other_sin, other_cos)) = (libm::sincos(PI * q[1]), libm::sincos(PI * q[2]));
            values([q[0], sin, cos, other_sin, other_cos, q[3], q[4]])
        }
        Kind::Xheart => {
            let (sin, cos) = libm::sincos(FRAC_PI_4 + q[0] * FRAC_PI_8);
            values([6.0 + 2.0 * q[1], sin, cos])
        }
        _ => of_crops_and_maps(kind, weight, q),
    }
}

/// The same of those with many parameters.
#[expect(clippy::wildcard_enum_match_arm, reason = "most variations take their parameters as they are")]
fn of_crops_and_maps(kind: Kind, weight: f64, q: &[f64; MAX_PARAMETERS]) -> [f64; MAX_PARAMETERS] {
    match kind {
        Kind::Affine3D => values(matrix(q)),
        Kind::AxisSymmetryWf => {
            let (sin, cos) = libm::sincos(q[4].to_radians());
            // JWildfire puts what it turns about y at the height of the centre's y.
            let base = if q[4] == 0.0 { q[3] } else { q[2] };
            let axis = q[0] as usize % 3;
            // The second half keeps its colour where nothing turns about y, in `JWildfire`.
            let other = if axis == 1 && q[4] == 0.0 { 0.0 } else { q[8 + axis] };
            values([q[0], q[1], q[2], q[3], sin, cos, base, q[5 + axis], other])
        }
        Kind::Juliac => {
            // A whole number of turns, or parts of one: a large random number modulo |re|.
            let parts = (1..=1000).map(f64::from).find(|parts| (q[0] * parts).fract() == 0.0).unwrap_or(1e4);
            values([q[0].abs() * parts, 1.0 / q[0], q[1] / 100.0, q[2], TAU / parts])
        }
        Kind::Kaleidoscope => {
            // Its author's 45 are radians.
            let (sin, cos) = libm::sincos(45.0);
            values([q[1] * cos, sin, q[2] + q[3], q[0] + q[2] + q[4], -q[0] - q[2]])
        }
        Kind::Smartcrop => {
            let count = q[0].abs();
            let corner = TAU / count;
            let roundness = q[2] * 2.0 / (count * libm::sin(corner / 2.0));
            let keeps_inside = f64::from((q[0] > 0.0) == (q[1] > 0.0));
            let [size, turn] = [q[1].abs(), q[8] * corner];
            values([corner, roundness, q[3], q[4], size, q[5], q[6], q[7], turn, q[9], keeps_inside])
        }
        _ => of_figures(kind, weight, q),
    }
}

/// The same of those that draw a figure.
#[expect(clippy::wildcard_enum_match_arm, reason = "most variations take their parameters as they are")]
fn of_figures(kind: Kind, weight: f64, q: &[f64; MAX_PARAMETERS]) -> [f64; MAX_PARAMETERS] {
    match kind {
        Kind::Boarders2 => {
            let [kept, push, chance] = [q[0], q[1], q[2]].map(f64::abs);
            values([kept, kept * push, kept + kept * chance])
        }
        Kind::Log => values([1.0 / libm::log(q[0])]),
        Kind::Asteria => {
            let (sin, cos) = libm::sincos(PI * q[0]);
            values([sin, cos])
        }
        Kind::Eclipse => values([q[0].clamp(-2.0, 2.0)]),
        Kind::Joukowski => values([q[0] * q[0], q[1], q[2]]),
        Kind::Julian2 => values([q[0].abs(), q[0], q[1] / q[0] / 2.0, q[2], q[3], q[4], q[5], q[6], q[7]]),
        Kind::PowBlock => {
            let share = q[0] / q[1];
            values([share, share * q[2] * TAU, share / (q[3] / q[4]) / 2.0, q[1]])
        }
        // 60 degrees to each side.
        Kind::HeartWf => values([-60.0 / PI * q[2], 60.0 / PI * q[3], q[1], q[0]]),
        Kind::Waves3 => values([q[0] / 2.0, q[1] / 2.0, q[2], q[3], q[4], q[5]]),
        Kind::Waves22 => {
            let powers = [q[6].trunc(), q[7].trunc()];
            let [x_is_odd, y_is_odd] = powers.map(|power| (power % 2.0).abs());
            values([q[0], q[1], q[2], q[3], q[4], q[5], powers[0], powers[1], x_is_odd, y_is_odd])
        }
        Kind::RoseWf => values([q[0], q[1].round(), q[2]]),
        Kind::TargetSp => values([q[3], q[1].trunc() / PI, q[2], q[0] * PI]),
        Kind::GlynnSim2 => {
            let (thickness, contrast) = (q[1].clamp(0.0, 1.0), q[2].clamp(0.0, 1.0));
            let outer = q[0] + thickness;
            let [from, to] = [q[4].to_radians(), q[5].to_radians()];
            values([q[0], outer, thickness * (q[0] + outer) / outer, from, to - from, contrast, q[3].abs()])
        }
        Kind::Waffle => {
            let (sin, cos) = libm::sincos(q[3]);
            values([q[0], q[1], q[2], weight * sin, weight * cos])
        }
        Kind::Stwin => values([TAU * q[0], q[1] / 10.0, q[2] / 1e4, q[3] / 1e4]),
        Kind::Seashell3D => values([q[0], q[1], q[2], q[3].trunc()]),
        Kind::Hypertile3D => {
            let (sin, cos) = libm::sincos(TAU * q[2] / q[0]);
            let rho = tile_radius(q[0], q[1]);
            values([rho * cos, rho * sin, rho * rho])
        }
        Kind::Gnarly => values([q[0], q[1], q[0] * q[0] / 4.0]),
        Kind::Rblur => values([q[0] * 2.0, q[1], q[2], q[3]]),
        Kind::Crackle => crackle_values(q),
        Kind::DcLinear => dc_linear_values(q),
        Kind::Falloff3 => falloff3_values(q),
        Kind::Synth => synth_values(q),
        Kind::Truchet => truchet_values(weight, q),
        Kind::Vibration2 => vibration2_values(q),
        Kind::Waves4 => waves4_values(q),
        Kind::Xtrb => xtrb_values(q),
        _ => *q,
    }
}

/// Three rows of four of an affine map: of scales, shears, turns about x, y and z in degrees, and a translation.
fn matrix(q: &[f64; MAX_PARAMETERS]) -> [f64; 12] {
    let [tx, ty, tz, sx, sy, sz, rx, ry, rz, xy, xz, yx, yz, zx, zy, ..] = *q;
    let mut rows = [[sx, xy * sy, xz * sz], [yx * sx, sy, yz * sz], [zx * sx, zy * sy, sz]];
    // Each turns the first of two coordinates towards the second one.
    for (degrees, first, second) in [(rx, 1, 2), (ry, 2, 0), (rz, 0, 1)] {
        let (sin, cos) = libm::sincos(degrees.to_radians());
        let (a, b) = (rows[first], rows[second]);
        rows[first] = std::array::from_fn(|i| cos * a[i] - sin * b[i]);
        rows[second] = std::array::from_fn(|i| sin * a[i] + cos * b[i]);
    }
    let [[a, b, c], [d, e, f], [g, h, i]] = rows;
    [a, b, c, tx, d, e, f, ty, g, h, i, tz]
}

fn square(vector: [f64; 3]) -> f64 {
    vector.iter().map(|part| part * part).sum()
}

/// How far the corners of hyperbolic tiles of `p` sides, `q` at a corner, are moved.
fn tile_radius(p: f64, q: f64) -> f64 {
    let (p, q) = (libm::cos(TAU / p), libm::cos(TAU / q));
    1.0 / (1.0 - (p - 1.0) / (p + q)).sqrt()
}

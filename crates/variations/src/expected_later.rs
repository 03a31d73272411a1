//! What formulas that came later compute, in `f64` and in other words.
//!
//! Owns the images of a point; `expected.rs` compares them with the formulas.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::Kind::{self, *};
use super::expected::C;

/// All images of a point, each as likely as the others, before the weight.
#[expect(clippy::wildcard_enum_match_arm, reason = "all others are elsewhere")]
pub(super) fn images(kind: Kind, q: &[f64], w: f64, point: [f64; 3]) -> Vec<[f64; 3]> {
    let [x, y, _] = point;
    let (zeta, theta) = (C(x, y), x.atan2(y));
    let r = zeta.size();
    let one = match kind {
        Affine3D => {
            let [scaled_x, scaled_y, scaled_z] = [0, 1, 2].map(|axis| q[3 + axis] * point[axis]);
            let sheared = [
                scaled_x + q[9] * scaled_y + q[10] * scaled_z,
                scaled_y + q[11] * scaled_x + q[12] * scaled_z,
                scaled_z + q[13] * scaled_x + q[14] * scaled_y,
            ];
            let turned = (0..3).fold(sheared, |p, axis| turned(p, axis, q[6 + axis]));
            [0, 1, 2].map(|axis| turned[axis] + q[axis])
        }
        // Between the lines y = 0 and x = 0, as in flam3 with a height.
        Butterfly3D => {
            let k = (16.0 / (3.0 * PI)).sqrt() * (x * y).abs().sqrt() / C(x, 2.0 * y).size();
            [k * x, 2.0 * k * y, k * y.abs() * r / 2.0]
        }
        Waves4Wf => {
            let wave = |angle: f64, is_cos: f64| (2.0 * angle).sin() / 2.0 * (angle + is_cos * FRAC_PI_2).sin();
            let (x_damp, y_damp) = (q[6].exp(), q[7].exp());
            let moved = |from: f64, damp: f64, scale: f64, wave: f64| (from + damp * scale * wave) * damp;
            [moved(x, x_damp, q[0], wave(y * q[2], q[4])), moved(y, y_damp, q[1], wave(x * q[3], q[5])), 0.0]
        }
        CannabiscurveWf => {
            let leaf = (1.0 + 0.9 * (8.0 * theta).cos()) * (1.0 + 0.1 * (24.0 * theta).cos());
            let leaf = leaf * (0.9 + 0.1 * (200.0 * theta).cos()) * (1.0 + theta.sin());
            // A quarter of a turn further.
            let (sin, cos) = (theta + FRAC_PI_2).sin_cos();
            [leaf * sin, leaf * cos, 0.0]
        }
        Target => {
            let depth = r.ln();
            // Rings are half a size wide; inside of the unit circle they begin with the other one.
            let ring = (if depth < 0.0 { q[2] / 2.0 - depth } else { depth }) / (q[2] / 2.0);
            let turn = if (ring as i64) % 2 == 0 { q[0] } else { q[1] };
            let C(x, y) = zeta * C::polar(1.0, turn);
            [x / w, y / w, 0.0]
        }
        Kaleidoscope => {
            let (sin, cos) = 45.0_f64.sin_cos();
            let halves = if y > 0.0 { q[0] + q[2] + q[4] } else { -q[0] - q[2] };
            [(q[1] * x * cos - y * sin + q[2] + q[3]) / w, (q[1] * y * cos + x * sin + halves) / w, 0.0]
        }
        RotateX => turned(point, 0, -90.0 * w).map(|part| part / w),
        RotateZ => turned(point, 2, -90.0 * w).map(|part| part / w),
        Smartcrop => cropped(q, point),
        _ => return super::expected_more::images(kind, q, w, point),
    };
    vec![one]
}

/// `point` turned by so many degrees about an axis, by the right hand.
fn turned(point: [f64; 3], axis: usize, degrees: f64) -> [f64; 3] {
    let (first, second) = ((axis + 1) % 3, (axis + 2) % 3);
    let C(a, b) = C(point[first], point[second]) * C::polar(1.0, degrees.to_radians());
    let mut turned = point;
    (turned[first], turned[second]) = (a, b);
    turned
}

/// The image of a point under a crop without chance.
fn cropped(q: &[f64], [x, y, z]: [f64; 3]) -> [f64; 3] {
    let (count, size, zeta) = (q[0].abs(), q[1].abs(), C(x, y));
    // The angle from the nearest middle of a side: one looks to the left.
    let corner = TAU / count;
    let off = (zeta.angle() + PI).rem_euclid(corner);
    let off = off.min(corner - off);
    let straight = 1.0 / off.cos();
    let round = q[2] / (count / 2.0 * (PI / count).sin()) * (off / corner * 2.0).powf(q[3]);
    let shape = (straight + (1.0 - straight) * round).abs().powf(q[4]);
    let is_outside = zeta.size() > size * shape;
    let is_inside_kept = q[0].signum() == q[1].signum();
    if is_outside != is_inside_kept {
        return [x, y, z];
    }
    let far = match q[9] as i32 {
        0 => return [0.0; 3],
        1 => shape * (size + q[7]),
        _ => zeta.size(),
    };
    let C(x, y) = zeta * C::polar(far / zeta.size(), q[8] * corner);
    [x, y, z]
}

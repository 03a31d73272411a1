//! What formulas found by probing JWildfire point by point precompute per transform.
//!
//! Owns values that do not depend on the point, as `precomputed.rs` does, where this begins. Never calculates with a point.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::formulas::values;
use super::waves::WAVE;
use super::{Kind, MAX_PARAMETERS};

/// How many values a wave of `synth` has, and where its waves begin.
pub(super) const LAYER: usize = 6;
pub(super) const LAYERS: usize = 5;

/// What the formula of `kind` reads, of its weight and its parameters in the order of [`Kind::parameters`].
#[expect(clippy::wildcard_enum_match_arm, reason = "most variations take their parameters as they are")]
pub(super) fn of_latest(kind: Kind, weight: f64, q: &[f64; MAX_PARAMETERS]) -> [f64; MAX_PARAMETERS] {
    match kind {
        Kind::Falloff3 => {
            let mut all = *q;
            all[2] = 0.04 * q[2];
            all[12] = q[12] * all[2].abs().sqrt();
            all
        }
        Kind::DcLinear => {
            let (sin, cos) = libm::sincos(q[1]);
            values([sin, cos, q[0], 0.5 / q[2]])
        }
        Kind::Crackle => {
            let layer = 2.5 * q[4];
            let below = layer.floor();
            let (next_share, share) = libm::sincos((layer - below) * FRAC_PI_2);
            values([q[0] / 2.0, q[1], q[2], q[3], below, share, next_share])
        }
        Kind::Truchet => {
            let norm = q[1].clamp(0.001, 2.0);
            let width = (libm::exp2(1.0 / norm) - 1.0) * q[2].clamp(0.001, 1.0) / 2.0;
            let scale = (libm::cos(q[3]) + libm::sin(q[3])) / weight;
            let seed = q[5].abs();
            let hash = if seed == 0.0 || seed == 1.0 {
                [seed, 0.0, 0.0]
            } else {
                let g = (1.5 * seed).sqrt() / (0.5 * seed) * 0.25;
                let k = g * 0.5 * 32_747.0;
                [seed * k + 12_345.0, k * g, k * g * g]
            };
            values([scale, norm, width, q[4].clamp(0.001, 10.0), hash[0], hash[1], hash[2]])
        }
        Kind::Waves4 => values([q[0], q[1], q[2], q[3], f64::from(q[4] >= 1.0), q[5] / 1000.0]),
        Kind::Vibration2 => {
            let [first, second] =
                [[0, 10], [5, 18]].map(|[wave, swells]| vibration(&q[wave..][..5], &q[swells..][..8]));
            let mut all = [0.0; MAX_PARAMETERS];
            all[..WAVE].copy_from_slice(&first);
            all[WAVE..2 * WAVE].copy_from_slice(&second);
            all
        }
        Kind::Synth => {
            let mut all = [0.0; MAX_PARAMETERS];
            let layers = LAYER * 5;
            let [mode, power, mix, smooth] = [0, 1, 2, 3].map(|at| q[1 + layers + at]);
            all[..LAYERS].copy_from_slice(&[q[0], mode, power, mix, smooth]);
            all[LAYERS..LAYERS + layers].copy_from_slice(&q[1..=layers]);
            all
        }
        Kind::Xtrb => triangles(q),
        _ => *q,
    }
}

/// What `xtrb` reads: the sides of its triangles and the area of one, twice.
fn triangles(q: &[f64; MAX_PARAMETERS]) -> [f64; MAX_PARAMETERS] {
    let power = q[0].round();
    let (b, c) = (0.047 + q[4], 0.047 + q[5]);
    let [half_a, half_b, half_c] = [PI - b - c, b, c].map(|angle| libm::tan(angle / 2.0));
    let sides = [half_b + half_c, half_a + half_c, half_a + half_b].map(|side| side * q[1]);
    let area = q[1] * sides.iter().sum::<f64>();
    let (sin, cos) = libm::sincos(c);
    let [side_a, side_b, side_c] = sides;
    let (exponent, share) = (q[3] / power / 2.0, 1.0 - q[2] * q[2]);
    values([q[1], sin, cos, power.abs(), power, exponent, side_a, side_b, side_c, area, q[2], share])
}

/// What a wave of `vibration2` reads, of its direction, angle, frequency, size and phase, and of how much and how often each
/// of the direction, the angle, the frequency and the size swells.
fn vibration(wave: &[f64], swells: &[f64]) -> [f64; WAVE] {
    let (sin, cos) = libm::sincos(wave[0]);
    let frequency = wave[2];
    [
        cos,
        sin,
        TAU * frequency,
        wave[3],
        TAU * wave[4] / frequency,
        swells[0],
        TAU * swells[1],
        swells[2],
        TAU * swells[3],
        swells[4] / frequency,
        TAU * swells[5],
        wave[3] * swells[6],
        TAU * swells[7],
        wave[0],
        wave[1],
    ]
}

//! Formulas of other programs that add waves to the point.
//!
//! Owns those in the plane. The letters are those of `plain.rs`.
//!
//! # Source
//! What `JWildfire`, Fractorium and Apophysis plugins of these names compute, in their authors' descriptions.

use std::f64::consts::TAU;

use super::MAX_PARAMETERS;
use super::formulas::{at_angle, formulas, over, values};
use super::roots::NEAREST;
use super::space::bent;
use crate::Compiled;
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

    Waves3(v, x, y) {
        let [x_scale, y_scale, x_frequency, y_frequency, x_swell, y_swell, ..] = v.p;
        let wave = |at: N, frequency: f64, swell: f64| (at * frequency).sin() * ((at * swell).sin() + 1.0);
        (
            (x + wave(y, x_frequency, x_swell) * x_scale) * v.w,
            (y + wave(x, y_frequency, y_swell) * y_scale) * v.w,
        )
    }

    Waves22(v, x, y) {
        let [x_scale, y_scale, x_frequency, y_frequency, x_mode, y_mode, x_power, y_power, x_is_odd, y_is_odd, ..] = v.p;
        let wave = |angle: N, mode: f64, power: f64, is_odd: f64| {
            let sin = angle.sin();
            let sin = if mode < 0.5 { sin } else { (sin + 1.0) * 0.5 };
            let grown = sin.abs().pow(sin.like(power));
            if is_odd == 0.0 { grown } else { grown.copysign(sin) }
        };
        (
            (x + wave(y * x_frequency, x_mode, x_power, x_is_odd) * x_scale) * v.w,
            (y + wave(x * y_frequency, y_mode, y_power, y_is_odd) * y_scale) * v.w,
        )
    }

    Stwin(v, x, y) {
        let [turns, xy, x2, y2, ..] = v.p;
        let (small_x, small_y) = (x * (v.w * 0.05), y * (v.w * 0.05));
        let (square_x, square_y) = (small_x * small_x + x2, small_y * small_y + y2);
        let sum = square_x + square_y;
        let sum = sum.abs().max(x.like(NEAREST)).copysign(sum);
        let wave = (square_x - square_y) * ((small_x + small_y + xy) * turns).sin() / sum;
        (x * v.w + wave, y * v.w + wave)
    }

    Waves4(v, x, y) {
        let [x_scale, y_scale, x_frequency, y_frequency, is_cut, drift, ..] = v.p;
        let strip = (y * (x_frequency / TAU)).floor();
        // Whole turns of the strip's angle go first: what is left is exact in `f32`.
        let turns = strip * STRIP;
        let turns = turns - turns.round() + strip * STRIP_REST;
        let height = (turns * TAU + y * drift + 1.0).sin() * 43_758.545_3;
        let height = height - height.trunc();
        let height = if is_cut == 0.0 {
            height
        } else {
            N::select(height.like(0.5).less(height), height.like(1.0), height.like(0.0))
        };
        (
            (x + height * height * (y * x_frequency).sin() * x_scale) * v.w,
            (y + (x * y_frequency).sin() * y_scale) * v.w,
        )
    }

    Vibration2(v, x, y) {
        let (first_x, first_y) = vibrated(v, 0, x, y);
        let (second_x, second_y) = vibrated(v, WAVE, x, y);
        ((x + first_x + second_x) * v.w, (y + first_y + second_y) * v.w)
    }
}

/// By what part of a turn the angle of a strip of `waves4` is further than that of the one before: 91.2228 radians, less whole
/// turns. Its first 12 bits, and the rest.
const STRIP: f64 = 2123.0 / 4096.0;
const STRIP_REST: f64 = 91.2228 / TAU - 14.0 - STRIP;

/// What `waves4` reads.
pub(super) fn waves4_values(q: &[f64; MAX_PARAMETERS]) -> [f64; MAX_PARAMETERS] {
    values([q[0], q[1], q[2], q[3], f64::from(q[4] >= 1.0), q[5] / 1000.0])
}

/// What `vibration2` reads: one wave after the other.
pub(super) fn vibration2_values(q: &[f64; MAX_PARAMETERS]) -> [f64; MAX_PARAMETERS] {
    let [first, second] = [[0, 10], [5, 18]].map(|[wave, swells]| vibration(&q[wave..][..5], &q[swells..][..8]));
    let mut all = [0.0; MAX_PARAMETERS];
    all[..WAVE].copy_from_slice(&first);
    all[WAVE..2 * WAVE].copy_from_slice(&second);
    all
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
/// How many values a wave of `vibration2` has.
const WAVE: usize = 15;

/// What a wave of `vibration2` adds, whose values begin at `at`.
#[inline(always)]
fn vibrated<N: Number>(v: &Compiled, at: usize, x: N, y: N) -> (N, N) {
    let value = |place: usize| v.p[at + place];
    let along = x * value(0) + y * value(1);
    let swell = |first: f64, place: usize| {
        let (size, frequency) = (value(place), value(place + 1));
        if size == 0.0 { x.like(first) } else { (along * frequency).cos() * size + first }
    };
    let direction = swell(value(13), 5);
    let (sin, cos) = direction.sin_cos();
    let height = swell(value(3), 11) * ((x * cos + y * sin) * value(2) + swell(value(4), 9)).sin();
    at_angle(direction + swell(value(14), 7), height)
}

/// The sine, or the cosine.
#[inline(always)]
fn wave<N: Number>(angle: N, is_cos: f64) -> N {
    if is_cos == 0.0 { angle.sin() } else { angle.cos() }
}

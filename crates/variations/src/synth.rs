//! A formula of other programs that shapes a point by a sum of waves, as a synthesiser shapes a sound.
//!
//! Owns the waves, how they are combined, and the twenty ways in which the sum moves a point. The letters are those of
//! `plain.rs`, but that θ is the angle from the y axis.
//!
//! # Source
//! What `JWildfire` computes, by the number: 20 modes with and without `smooth`, nine shapes of waves, four layers.

use std::f64::consts::{PI, TAU};

use super::MAX_PARAMETERS;
use super::formulas::{TINY, at_angle, formulas, over, radius, remainder, square_of_radius};
use crate::Compiled;
use crate::number::Number;

/// How many values a wave has, and where the waves begin.
const LAYER: usize = 6;
const LAYERS: usize = 5;

/// The nearest to 0 that a number is raised to a power.
const NEAREST: f64 = 1e-30;

formulas! {
    Synth(v, x, y, random) {
        let [_, mode, power, ..] = v.p;
        let mode = mode as usize;
        let (square, r) = (square_of_radius(x, y), radius(x, y));
        let theta = x.atan2(y);
        let raised = |value: N, exponent: f64| value.max(value.like(NEAREST)).pow(value.like(exponent));
        // At which two places the waves are asked, and the length that the first answer bends.
        let mut outer = x.like(1.0);
        let (first, second, length) = match mode {
            0 => (theta, theta, raised(square, f64::midpoint(power, 1.0))),
            1 => (theta, theta, r / (square * 0.25 + 1.0)),
            2 => {
                let far = (random.unit() + random.unit() + random.unit() * 0.002) / 2.002;
                outer = far;
                let angle = random.unit() * TAU - PI;
                (angle, angle, raised(far, power))
            }
            3 => {
                let far = (random.unit() + random.unit()) * 0.5;
                let angle = random.unit() * TAU - PI;
                (angle, angle, raised(far, -power))
            }
            4 | 12 => {
                let length = (random.unit() + random.unit() - 1.0) * (0.1 * power) + 1.0;
                let u = random.unit() * 2.0 - 1.0;
                let angle = if mode == 12 { u * PI } else { u.atan2((-(u * u - 1.0)).sqrt()) * 2.0 };
                (angle, angle, length)
            }
            13 => {
                let angle = random.unit() * TAU - PI;
                (angle, angle, raised(random.unit(), power) * 0.1)
            }
            14..=16 => {
                let length = raised(square, power / 2.0);
                (length, length, length)
            }
            5 | 19 => (theta, theta, r),
            7 | 10 | 17 => (x, x, y),
            _ => (y, x, x),
        };
        let s = waves(v, first);
        let other = if matches!(mode, 8 | 11 | 18) { waves(v, second) } else { s };
        let polar = |length: N, angle: N| {
            let (y, x) = at_angle(angle, length);
            (x, y)
        };
        let (x, y) = match mode {
            0..=3 | 5 | 12 => polar(stretched(v, length, s) * outer, first),
            4 => (first / PI, stretched(v, length, s) - 1.0),
            6 => (stretched(v, x, s), y),
            7 => (x, stretched(v, y, s)),
            8 => (stretched(v, x, s), stretched(v, y, other)),
            9 => (x + s - 1.0, y),
            10 => (x, y + s - 1.0),
            11 => (x + s - 1.0, y + other - 1.0),
            13 => polar(s + length, first),
            14 => polar(length, theta + s - 1.0),
            15 => {
                let (along_x, along_y) = polar(s - 1.0, theta);
                (x + along_y, y - along_x)
            }
            16 => polar(r, theta + s - 1.0),
            17 => (x, (s - 1.0) * 2.0 - y),
            18 => ((s - 1.0) * 2.0 - x, (other - 1.0) * 2.0 - y),
            19 => polar(raised(stretched(v, r, s).abs(), power), theta),
            _ => (x.like(0.0), x.like(0.0)),
        };
        (x * v.w, y * v.w)
    }
}

/// What `synth` reads: the sum that waves are added to, mode, power, mix and smooth, then the waves.
pub(super) fn synth_values(q: &[f64; MAX_PARAMETERS]) -> [f64; MAX_PARAMETERS] {
    let mut all = [0.0; MAX_PARAMETERS];
    let layers = LAYER * 5;
    let [mode, power, mix, smooth] = [0, 1, 2, 3].map(|at| q[1 + layers + at]);
    all[..LAYERS].copy_from_slice(&[q[0], mode, power, mix, smooth]);
    all[LAYERS..LAYERS + layers].copy_from_slice(&q[1..=layers]);
    all
}

/// The sum of the waves at `t`.
#[inline(always)]
fn waves<N: Number>(v: &Compiled, t: N) -> N {
    let [base, _, _, mix, ..] = v.p;
    let mut sum = t.like(base);
    for layer in 0..5 {
        let at = LAYERS + LAYER * layer;
        let [size, shape, skew, frequency, phase, way] =
            [v.p[at], v.p[at + 1], v.p[at + 2], v.p[at + 3], v.p[at + 4], v.p[at + 5]];
        if size == 0.0 {
            continue;
        }
        let wave = shaped(shape, skewed(t * frequency + phase, skew), frequency) * size;
        sum = match way as usize {
            0 => sum + wave,
            1 => sum * (wave + 1.0),
            2 => sum.max(wave + base),
            3 => sum.min(wave + base),
            _ => sum,
        };
    }
    sum * mix + (1.0 - mix)
}

/// An angle in 0..2π, with the first half of the turn longer by a part `skew` of it.
#[inline(always)]
fn skewed<N: Number>(angle: N, skew: f64) -> N {
    let zero = angle.like(0.0);
    let left = remainder(angle, TAU);
    let z = N::select(left.less(zero), left + TAU, left);
    if skew == 0.0 {
        return z;
    }
    let half = PI * (1.0 + skew);
    N::select(z.less(z.like(half)), z / (1.0 + skew), (z - half) / (1.0 - skew) + PI)
}

/// The height of a wave at `z`, in 0..2π.
#[inline(always)]
fn shaped<N: Number>(shape: f64, z: N, frequency: f64) -> N {
    let is_late = z.like(PI).less(z);
    let falling = -(z / PI - 1.0);
    match shape as usize {
        0 => z.sin(),
        1 => z.cos(),
        2 => N::select(is_late, z.like(1.0), z.like(-1.0)),
        3 => falling,
        // The second half falls twice as fast, from 1.
        4 => N::select(is_late, falling * 2.0 + 1.0, -falling),
        5 => falling * falling * 2.0 - 1.0,
        6 => (z / TAU).sqrt() * 2.0 - 1.0,
        // Sides of a polygon, and their inversion.
        7 => over(1.0, ((z - PI) / frequency).cos()) - 1.0,
        8 => {
            let cos = ((z - PI) / frequency).cos();
            cos / -(cos - 1.0)
        }
        _ => z.like(0.0),
    }
}

/// The length times `factor`; if it is smooth, a curve that has this slope at 0 and returns to the length itself further out.
#[inline(always)]
fn stretched<N: Number>(v: &Compiled, length: N, factor: N) -> N {
    if v.p[4] == 0.0 {
        return length * factor;
    }
    let one = length.like(1.0);
    let (x, m) = (length.abs(), factor.abs());
    let is_small = m.less(one);
    let end = (-(m - 2.0)).max(m * 2.0);
    // Up to 1, and from there to the end.
    let k = N::select(is_small, m, one / m);
    let t = x / (k + (k * k + (-(k * 2.0 - 1.0)) * x).sqrt()).max(x.like(TINY));
    let early = (m - 1.0) * t * t;
    let further = (x - 1.0).max(x.like(0.0));
    let slow = (further / (end - 1.0).max(x.like(TINY))).sqrt();
    let fast = ((m - 1.0) * (m - 1.0) + further).sqrt() - (m - 1.0);
    let rest = -(N::select(is_small, slow, fast) - 1.0);
    let late = (m - 1.0) * rest * rest;
    let bent = x + N::select(one.less(x), late, early);
    N::select(end.less(x), x, bent).copysign(length) * one.copysign(factor)
}

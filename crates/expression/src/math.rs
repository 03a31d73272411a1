//! The elementary functions, the same bits on every machine.
//!
//! Owns sin, cos, exp, ln and atan in f32, by additions and multiplications that no compiler may fuse or reorder, and what
//! becomes of results that are not finite. All are without branches, so that loops over them become vector instructions.
//! The system's library is not called.
//!
//! Start at [`settled`].
//!
//! # Source
//! The polynomials interpolate at Chebyshev nodes: sin to 2.4e-8, exp to 1e-8, atan to 6.4e-8 before rounding. The parts of
//! pi are those of Moshier's Cephes.

use std::f32::consts::{FRAC_1_PI, FRAC_PI_2, LN_2, LOG2_E, PI, TAU};

/// The largest magnitude of a number, and of every result.
pub const LARGEST: f32 = 1e6;
/// Added to a magnitude below 2^22 and taken off again, it rounds to the nearest whole number; with it added, the lowest
/// bits of the sum are that number.
const TO_WHOLE: f32 = 12_582_912.0;
/// From here on, every f32 is whole.
const ALL_WHOLE: f32 = 8_388_608.0;
/// Pi in three parts; the products of the first two with whole numbers up to 2^13 are exact.
const PI_PARTS: [f32; 3] = [3.140_625, 9.675_026e-4, 1.509_958e-7];
/// ln 2 in two parts, in the same manner.
const LN_2_PARTS: [f32; 2] = [0.693_359_4, -2.121_944_4e-4];

/// What a result counts as: 0 if it is not finite, never beyond 1e6, and no negative zero.
#[inline(always)]
pub(crate) fn settled(value: f32) -> f32 {
    let finite = if value.abs() < f32::INFINITY { value } else { 0.0 };
    capped(finite)
}

/// As [`settled`], of a value that is finite.
#[inline(always)]
pub(crate) fn capped(value: f32) -> f32 {
    value.clamp(-LARGEST, LARGEST) + 0.0
}

/// The next whole number below.
#[inline(always)]
pub(crate) fn floor(value: f32) -> f32 {
    let near = nearest(value);
    if near > value { near - 1.0 } else { near }
}

/// The nearest whole number; halves go to the even one.
#[inline(always)]
pub(crate) fn nearest(value: f32) -> f32 {
    let near = (value.abs() + ALL_WHOLE - ALL_WHOLE).copysign(value);
    if value.abs() < ALL_WHOLE { near } else { value }
}

/// The next whole number below, modulo 2^32 and with a constant added, and what is above it. Magnitudes up to 2^21.
#[inline(always)]
pub(crate) fn split(value: f32) -> (u32, f32) {
    let shifted = value + TO_WHOLE;
    let near = shifted - TO_WHOLE;
    let is_above = near > value;
    let whole = if is_above { near - 1.0 } else { near };
    (shifted.to_bits().wrapping_sub(u32::from(is_above)), value - whole)
}

/// The sine of an angle in radians, to 2e-6 up to 2^13.
#[inline(always)]
pub(crate) fn sin(angle: f32) -> f32 {
    let shifted = angle * FRAC_1_PI + TO_WHOLE;
    folded_sine(angle, shifted - TO_WHOLE, shifted.to_bits())
}

/// The cosine of an angle in radians, to 2e-6 up to 2^13.
#[inline(always)]
pub(crate) fn cos(angle: f32) -> f32 {
    let shifted = (angle * FRAC_1_PI - 0.5) + TO_WHOLE;
    folded_sine(angle, (shifted - TO_WHOLE) + 0.5, shifted.to_bits().wrapping_add(1))
}

/// The sine of what is left of an angle after `halves` half turns, its sign changed where `parity` is odd.
#[inline(always)]
fn folded_sine(angle: f32, halves: f32, parity: u32) -> f32 {
    let r = ((angle - halves * PI_PARTS[0]) - halves * PI_PARTS[1]) - halves * PI_PARTS[2];
    let z = r * r;
    let tail = -0.166_666_66 + z * (0.008_333_237 + z * (-0.000_198_220_02 + z * 2.632_390_3e-6));
    let sine = (r + r * z * tail).clamp(-1.0, 1.0);
    f32::from_bits(sine.to_bits() ^ (parity << 31))
}

/// The sine of so many turns, `0.0..1.0`.
#[inline(always)]
pub(crate) fn sin_of_turns(turns: f64) -> f32 {
    sin(turns as f32 * TAU)
}

/// e to the power of a number, to 2e-6 of the result; 0 or the largest f32 where it is out of range.
#[inline(always)]
pub(crate) fn exp(power: f32) -> f32 {
    let power = power.clamp(-87.0, 88.0);
    let shifted = power * LOG2_E + TO_WHOLE;
    let n = shifted - TO_WHOLE;
    let r = (power - n * LN_2_PARTS[0]) - n * LN_2_PARTS[1];
    let tail = 0.5 + r * (0.166_665_76 + r * (0.041_666_556 + r * (0.008_363_195 + r * 0.001_392_620_4)));
    let exponent = shifted.to_bits().wrapping_sub(TO_WHOLE.to_bits()).wrapping_add(127);
    (1.0 + r + r * r * tail) * f32::from_bits(exponent << 23)
}

/// The natural logarithm of a number above 0, to 2e-6 of the result or of 1; minus infinity below 1.2e-38.
#[inline(always)]
pub(crate) fn ln(number: f32) -> f32 {
    // The bits of the square root of 1/2: what is left has a mantissa from there to the square root of 2.
    let exponent = (number.to_bits().wrapping_sub(0x3f35_04f3) as i32) >> 23;
    let mantissa = f32::from_bits(number.to_bits().wrapping_sub((exponent as u32) << 23));
    let above = mantissa - 1.0;
    let s = above / (2.0 + above);
    let z = s * s;
    let series = 2.0 + z * (0.666_666_7 + z * (0.4 + z * (0.285_714_3 + z * 0.222_222_22)));
    let ln = s * series + exponent as f32 * LN_2;
    if number < f32::MIN_POSITIVE { f32::NEG_INFINITY } else { ln }
}

/// The angle of a point in radians, from minus pi to pi, to 2e-6; 0 in the origin.
#[inline(always)]
pub(crate) fn atan2(y: f32, x: f32) -> f32 {
    let (across, up) = (x.abs(), y.abs());
    let is_steep = up > across;
    let (low, high) = if is_steep { (across, up) } else { (up, across) };
    let t = if high > 0.0 { low / high } else { 0.0 };
    let z = t * t;
    let high_half = 0.098_688_655 + z * (-0.058_829_755 + z * (0.023_780_52 + z * -0.004_559_792));
    let series = 0.999_999_9 + z * (-0.333_318_1 + z * (0.199_669_61 + z * (-0.140_032_9 + z * high_half)));
    let eighth = t * series;
    let quarter = if is_steep { FRAC_PI_2 - eighth } else { eighth };
    let half = if x < 0.0 { PI - quarter } else { quarter };
    if y < 0.0 { -half } else { half }
}

/// From 0 to 1 as `t` does, with speed and acceleration 0 at both ends.
#[inline(always)]
pub(crate) fn fade(t: f32) -> f32 {
    t * t * t * (10.0 + t * (-15.0 + t * 6.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(from: f32, to: f32) -> impl Iterator<Item = f32> {
        (0..=200_000).map(move |step| from + (to - from) * step as f32 / 200_000.0)
    }

    fn worst(inputs: impl Iterator<Item = f32>, ours: fn(f32) -> f32, truth: fn(f64) -> f64) -> f64 {
        let error = |input: f32| {
            let truth = truth(f64::from(input));
            (f64::from(ours(input)) - truth).abs() / truth.abs().max(1.0)
        };
        inputs.map(error).fold(0.0, f64::max)
    }

    #[test]
    fn sine_and_cosine_are_right_to_two_millionths() {
        for range in [1.0, 10.0, 8192.0] {
            let found = [worst(steps(-range, range), sin, f64::sin), worst(steps(-range, range), cos, f64::cos)];
            assert!(found.iter().all(|error| *error < 2e-6), "up to {range}: {found:?}");
        }
        assert!(steps(-1e6, 1e6).all(|angle| sin(angle).abs() <= 1.0 && cos(angle).abs() <= 1.0));
    }

    #[test]
    fn exponential_and_logarithm_are_right_to_two_millionths() {
        let relative = |power: f32| (f64::from(exp(power)) / f64::from(power).exp() - 1.0).abs();
        let found = steps(-87.0, 88.0).map(relative).fold(0.0, f64::max);
        assert!(found < 2e-6, "exp: {found}");
        let found = worst(steps(-87.0, 88.0).map(f32::exp), ln, f64::ln).max(worst(steps(0.5, 2.0), ln, f64::ln));
        assert!(found < 2e-6, "ln: {found}");
        assert_eq!(ln(0.0), f32::NEG_INFINITY);
    }

    #[test]
    fn the_angle_of_a_point_is_right_to_two_millionths_in_every_quarter() {
        for angle in steps(-0.9999 * PI, 0.9999 * PI) {
            for radius in [1e-6, 1.0, 1e6] {
                let (y, x) = (radius * angle.sin(), radius * angle.cos());
                let error = (f64::from(atan2(y, x)) - f64::from(y).atan2(f64::from(x))).abs();
                assert!(error < 2e-6, "{y} {x}: {error}");
            }
        }
        assert_eq!(atan2(0.0, 0.0), 0.0);
    }

    #[test]
    fn whole_numbers_are_those_of_the_standard_library() {
        for value in steps(-70.0, 70.0).chain(steps(-1e6, 1e6)).chain([0.5, -0.5, 1e9, -8_388_607.5, f32::INFINITY]) {
            assert_eq!(floor(value), value.floor(), "{value}");
            assert_eq!(nearest(value), value.round_ties_even(), "{value}");
            if value.abs() < 2e6 {
                let (whole, above) = split(value);
                assert_eq!((whole as i32 - TO_WHOLE.to_bits() as i32) as f32, value.floor(), "{value}");
                assert_eq!(above, value - value.floor(), "{value}");
            }
        }
    }

    #[test]
    fn what_is_not_finite_counts_as_zero_and_no_zero_is_negative() {
        for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -0.0] {
            assert_eq!(settled(value).to_bits(), 0, "{value}");
        }
        assert_eq!([settled(3e9), settled(-3e9), settled(-0.5)], [1e6, -1e6, -0.5]);
    }
}

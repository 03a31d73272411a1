//! Arithmetic, waves, bits and choices, sample by sample.
//!
//! Owns what each function means for three or fewer numbers. Never looks at a neighbour.
//!
//! Start at [`each`].

use std::f32::consts::FRAC_1_PI;

use crate::math::{self, capped, floor, nearest, settled};

/// Bits of a number from 0 to 1 that `and`, `or` and `xor` see.
const BITS: f32 = 8_388_608.0;
/// `if` changes over from minus this to this.
const SOFTNESS: f32 = 0.02;

/// Applies a function of one number to arrays of equal length.
#[inline(always)]
pub(super) fn each(a: &[f32], out: &mut [f32], function: impl Fn(f32) -> f32) {
    for (out, a) in out.iter_mut().zip(a) {
        *out = function(*a);
    }
}

/// Applies a function of two numbers to arrays of equal length.
#[inline(always)]
pub(super) fn each_two(a: &[f32], b: &[f32], out: &mut [f32], function: impl Fn(f32, f32) -> f32) {
    for ((out, a), b) in out.iter_mut().zip(a).zip(b) {
        *out = function(*a, *b);
    }
}

/// Applies a function of three numbers to arrays of equal length.
#[inline(always)]
pub(super) fn each_three(a: &[f32], b: &[f32], c: &[f32], out: &mut [f32], function: impl Fn(f32, f32, f32) -> f32) {
    for (((out, a), b), c) in out.iter_mut().zip(a).zip(b).zip(c) {
        *out = function(*a, *b, *c);
    }
}

#[inline(always)]
pub(super) fn add(a: f32, b: f32) -> f32 {
    capped(a + b)
}

#[inline(always)]
pub(super) fn subtract(a: f32, b: f32) -> f32 {
    capped(a - b)
}

#[inline(always)]
pub(super) fn multiply(a: f32, b: f32) -> f32 {
    capped(a * b)
}

/// 0 where the divisor is 0.
#[inline(always)]
pub(super) fn divide(a: f32, b: f32) -> f32 {
    settled(a / b)
}

#[inline(always)]
pub(super) fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[inline(always)]
pub(super) fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
pub(super) fn invert(a: f32) -> f32 {
    capped(1.0 - a)
}

/// a - b floor(a / b): the sign is that of b.
#[inline(always)]
pub(super) fn modulo(a: f32, b: f32) -> f32 {
    settled(a - b * floor(a / b))
}

/// The nearest multiple of b.
#[inline(always)]
pub(super) fn round(a: f32, b: f32) -> f32 {
    settled(b * nearest(a / b))
}

/// sign(a) |a|^b; 0 where a is 0.
#[inline(always)]
pub(super) fn power(a: f32, b: f32) -> f32 {
    let power = math::exp(b * math::ln(a.abs())).copysign(a);
    settled(if a == 0.0 { 0.0 } else { power })
}

/// ln |a| / ln |b|.
#[inline(always)]
pub(super) fn log(a: f32, b: f32) -> f32 {
    settled(math::ln(a.abs()) / math::ln(b.abs()))
}

#[inline(always)]
pub(super) fn sqrt(a: f32) -> f32 {
    settled(a.sqrt())
}

#[inline(always)]
pub(super) fn sin(a: f32) -> f32 {
    math::sin(a) + 0.0
}

#[inline(always)]
pub(super) fn cos(a: f32) -> f32 {
    math::cos(a) + 0.0
}

/// The angle of (b, a), over pi.
#[inline(always)]
pub(super) fn atan(a: f32, b: f32) -> f32 {
    math::atan2(a, b) * FRAC_1_PI + 0.0
}

#[inline(always)]
pub(super) fn and(a: f32, b: f32) -> f32 {
    of_bits(bits(a) & bits(b))
}

#[inline(always)]
pub(super) fn or(a: f32, b: f32) -> f32 {
    of_bits(bits(a) | bits(b))
}

#[inline(always)]
pub(super) fn xor(a: f32, b: f32) -> f32 {
    of_bits(bits(a) ^ bits(b))
}

/// The 23 bits after the point of a number that is mirrored at 0 and 1 until it lies between them.
#[inline(always)]
fn bits(a: f32) -> u32 {
    let folded = (a - 2.0 * nearest(a * 0.5)).abs();
    // A number from 1 to 2 has these bits as its mantissa.
    let below_one = if folded < 1.0 - 1.0 / BITS { folded } else { 1.0 - 1.0 / BITS };
    (1.0 + below_one).to_bits() & 0x7f_ffff
}

#[inline(always)]
fn of_bits(bits: u32) -> f32 {
    f32::from_bits(bits | 0x3f80_0000) - 1.0
}

/// b where a is above 0, else c, with a soft step between.
#[inline(always)]
pub(super) fn choose(a: f32, b: f32, c: f32) -> f32 {
    let t = (a / (2.0 * SOFTNESS) + 0.5).clamp(0.0, 1.0);
    capped(c + (b - c) * (t * t * (3.0 - 2.0 * t)))
}

/// From a to b as c goes from 0 to 1.
#[inline(always)]
pub(super) fn dissolve(a: f32, b: f32, c: f32) -> f32 {
    capped(a + (b - a) * c.clamp(0.0, 1.0))
}

/// Where red, green and blue are on the circle of hues, in sixths, from where they begin to fall.
pub(super) const SIXTHS: [f32; 3] = [5.0, 3.0, 1.0];

/// Red, green or blue, by its sixth, of a hue in turns, a saturation and a value.
#[inline(always)]
pub(super) fn hue(sixth: f32, hue: f32, saturation: f32, value: f32) -> f32 {
    let sixth = sixth + 6.0 * (hue - floor(hue));
    let k = sixth - 6.0 * floor(sixth * (1.0 / 6.0));
    let fall = min(k, 4.0 - k).clamp(0.0, 1.0);
    capped(value - value * saturation.clamp(0.0, 1.0) * fall)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOME: [f32; 12] = [-1e6, -7.3, -1.0, -0.4, -1e-9, 0.0, 1e-9, 0.3, 0.5, 1.0, 2.75, 1e6];

    #[test]
    fn every_function_of_two_numbers_is_finite_at_most_a_million_and_never_negative_zero() {
        let functions = [add, subtract, multiply, divide, max, min, modulo, round, power, log, atan, and, or, xor];
        for (number, function) in functions.iter().enumerate() {
            for (a, b) in SOME.iter().flat_map(|a| SOME.map(|b| (*a, b))) {
                let result = function(a, b);
                let is_settled = result.abs() <= 1e6 && result.to_bits() != (-0.0_f32).to_bits();
                assert!(is_settled, "function {number} of {a} and {b}: {result}");
            }
        }
    }

    #[test]
    fn functions_that_sims_left_open_are_as_defined() {
        assert_eq!([divide(3.0, 0.0), modulo(-0.25, 1.0), modulo(5.0, -3.0), round(7.4, 2.0)], [0.0, 0.75, -1.0, 8.0]);
        assert!((power(-8.0, 1.0 / 3.0) + 2.0).abs() < 1e-5 && (log(8.0, -2.0) - 3.0).abs() < 1e-5);
        assert_eq!([atan(1.0, 0.0), atan(0.0, -1.0)], [0.5, 1.0]);
        assert_eq!([choose(0.02, 3.0, 5.0), choose(0.0, 3.0, 5.0), choose(-0.02, 3.0, 5.0)], [3.0, 4.0, 5.0]);
        assert_eq!([dissolve(1.0, 3.0, 0.5), dissolve(1.0, 3.0, -2.0), dissolve(1.0, 3.0, 2.0)], [2.0, 1.0, 3.0]);
    }

    #[test]
    fn rounding_gives_multiples() {
        for (a, b) in SOME.iter().flat_map(|a| [0.25, 0.5, 3.0].map(|b| (*a, b))) {
            let multiple = round(a, b) / b;
            assert_eq!(multiple, multiple.round(), "{a} {b}");
        }
    }

    #[test]
    fn bits_are_those_of_numbers_that_are_mirrored_into_zero_to_one() {
        assert_eq!([and(0.75, 0.5), or(0.25, 0.5), xor(0.75, 0.25)], [0.5, 0.75, 0.5]);
        assert_eq!([and(-0.75, 0.75), and(1.25, 0.75), and(2.75, 0.75)], [0.75; 3]);
        for (a, b) in SOME.iter().flat_map(|a| SOME.map(|b| (*a, b))) {
            assert!([and(a, b), or(a, b), xor(a, b)].iter().all(|result| (0.0..1.0).contains(result)), "{a} {b}");
        }
    }

    #[test]
    fn hues_go_from_red_by_green_and_blue_to_red() {
        let colour = |turns| SIXTHS.map(|sixth| hue(sixth, turns, 1.0, 1.0));
        let near = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5);
        assert!(near(colour(0.0), [1.0, 0.0, 0.0]) && near(colour(1.0 / 3.0), [0.0, 1.0, 0.0]));
        assert!(near(colour(2.0 / 3.0), [0.0, 0.0, 1.0]) && near(colour(-4.0), [1.0, 0.0, 0.0]));
        assert!(near(SIXTHS.map(|sixth| hue(sixth, 0.3, 0.0, 0.6)), [0.6; 3]));
    }
}

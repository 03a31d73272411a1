//! Sixteen numbers at a time: `f32`, by polynomials.
//!
//! Owns the operators and the elementary functions. Each is made of operations that IEEE 754 rounds in one way only
//! (sums, products, fused products, quotients, roots, comparisons), so that AVX-512, AVX2, NEON and a processor without
//! any of them give the same bits. The C library's functions do not: they differ between processors.
//!
//! Start at [`Lanes`]; the polynomials' coefficients are in `series.rs`.

use std::f32::consts::{FRAC_2_PI, FRAC_PI_2, LN_2, LOG2_E, PI, TAU};
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use fearless_simd::{Bytes, ExtractToken, Select, Simd, SimdBase, SimdFloat, SimdInt, SimdMask};
use fearless_simd::{f32x16, i32x16, mask32x16, u32x16};

use super::{Mask, Number, series};

/// Sixteen `f32`.
#[derive(Clone, Copy, Debug)]
pub struct Lanes<S: Simd>(pub f32x16<S>);

/// Sixteen outcomes of a comparison.
#[derive(Clone, Copy, Debug)]
pub struct LaneMask<S: Simd>(pub mask32x16<S>);

macro_rules! operators {
    ($($operator:ident $method:ident;)*) => {$(
        impl<S: Simd> $operator for Lanes<S> {
            type Output = Lanes<S>;
            #[inline(always)]
            fn $method(self, other: Lanes<S>) -> Lanes<S> {
                Lanes($operator::$method(self.0, other.0))
            }
        }

        impl<S: Simd> $operator<f64> for Lanes<S> {
            type Output = Lanes<S>;
            #[inline(always)]
            fn $method(self, other: f64) -> Lanes<S> {
                Lanes($operator::$method(self.0, other as f32))
            }
        }
    )*};
}

operators! {
    Add add;
    Sub sub;
    Mul mul;
    Div div;
}

impl<S: Simd> Neg for Lanes<S> {
    type Output = Lanes<S>;
    #[inline(always)]
    fn neg(self) -> Lanes<S> {
        Lanes(-self.0)
    }
}

impl<S: Simd> BitAnd for LaneMask<S> {
    type Output = LaneMask<S>;
    #[inline(always)]
    fn bitand(self, other: LaneMask<S>) -> LaneMask<S> {
        LaneMask(self.0 & other.0)
    }
}

impl<S: Simd> BitOr for LaneMask<S> {
    type Output = LaneMask<S>;
    #[inline(always)]
    fn bitor(self, other: LaneMask<S>) -> LaneMask<S> {
        LaneMask(self.0 | other.0)
    }
}

impl<S: Simd> Not for LaneMask<S> {
    type Output = LaneMask<S>;
    #[inline(always)]
    fn not(self) -> LaneMask<S> {
        LaneMask(!self.0)
    }
}

impl<S: Simd> Mask for LaneMask<S> {
    #[inline(always)]
    fn any(self) -> bool {
        self.0.any_true()
    }
}

impl<S: Simd> Lanes<S> {
    #[inline(always)]
    fn bits(self) -> u32x16<S> {
        self.0.bitcast()
    }

    /// The nearest integer, as a number and as an integer; for absolute values below 2^22.
    #[inline(always)]
    fn nearest(self) -> (Lanes<S>, u32x16<S>) {
        // Adding 1.5 * 2^23 leaves no bits for fractions.
        const SHIFT: f32 = 12_582_912.0;
        let shifted = self.0 + SHIFT;
        (Lanes(shifted - SHIFT), shifted.bitcast())
    }

    /// `self` with its sign turned where the lowest bit but one of `quarters` is set.
    #[inline(always)]
    fn turned(self, quarters: u32x16<S>) -> Lanes<S> {
        let sign = (quarters & 2) << 30;
        Lanes((self.bits() ^ sign).bitcast())
    }

    /// Beyond 2^22 neighbouring numbers are so far apart that an angle is as good as random; this is one.
    #[inline(always)]
    fn folded(self) -> Lanes<S> {
        let scrambled: u32x16<S> = self.bits() * 0x9e37_79b9;
        let signed: i32x16<S> = scrambled.bitcast();
        let phase: f32x16<S> = signed.to_float();
        Lanes(phase * (TAU / 4_294_967_296.0))
    }

    /// The logarithm to base 2 of positive numbers.
    #[inline(always)]
    fn log2(self) -> Lanes<S> {
        // The smallest normal number: below it the exponent's bits mean nothing.
        let x = self.max(self.like(f64::from(f32::MIN_POSITIVE)));
        let bits: i32x16<S> = x.bits().bitcast();
        let exponent: i32x16<S> = (bits - series::HALF_ROOT as i32) >> 23;
        let mantissa: f32x16<S> = (bits - (exponent << 23)).bitcast();
        let m = Lanes(mantissa - 1.0);
        let series = m.polynomial(series::LOG);
        let square = m * m;
        let ln = (series * m).mul_add(square, square.mul_add(m.like(-0.5), m));
        let whole: f32x16<S> = exponent.to_float();
        ln.mul_add(m.like(f64::from(LOG2_E)), Lanes(whole))
    }

    /// 2 to the power of `self`.
    #[inline(always)]
    fn exp2(self) -> Lanes<S> {
        let x = self.max(self.like(-126.0)).min(self.like(127.0));
        let (whole, bits) = x.nearest();
        let grown = (x - whole).polynomial(series::EXP2);
        Lanes((grown.bits() + (bits << 23)).bitcast())
    }

    /// The polynomial whose coefficients are these, that of the highest power first.
    #[inline(always)]
    fn polynomial<const TERMS: usize>(self, coefficients: [f32; TERMS]) -> Lanes<S> {
        let mut sum = self.like(f64::from(coefficients[0]));
        for coefficient in &coefficients[1..] {
            sum = sum.mul_add(self, self.like(f64::from(*coefficient)));
        }
        sum
    }
}

/// Whether the instruction set has a fused product.
#[inline(always)]
fn is_fused<S: Simd>(simd: S) -> bool {
    #[cfg(target_arch = "x86_64")]
    return !matches!(simd.level(), fearless_simd::Level::Sse2(_));
    #[cfg(not(target_arch = "x86_64"))]
    !simd.level().is_fallback()
}

/// `x * factor + term`, rounded once, by many instructions: in one place, since formulas are full of it.
#[inline(never)]
fn fused<S: Simd>(x: Lanes<S>, factor: Lanes<S>, term: Lanes<S>) -> Lanes<S> {
    Lanes(x.0.mul_add_precise(factor.0, term.0))
}

impl<S: Simd> Number for Lanes<S> {
    type Mask = LaneMask<S>;

    #[inline(always)]
    fn like(self, value: f64) -> Lanes<S> {
        Lanes(f32x16::splat(self.0.token(), value as f32))
    }

    #[inline(always)]
    fn mul_add(self, factor: Lanes<S>, term: Lanes<S>) -> Lanes<S> {
        if is_fused(self.0.token()) {
            Lanes(self.0.mul_add_precise(factor.0, term.0))
        } else {
            fused(self, factor, term)
        }
    }

    #[inline(always)]
    fn abs(self) -> Lanes<S> {
        Lanes(self.0.abs())
    }

    #[inline(always)]
    fn sqrt(self) -> Lanes<S> {
        Lanes(self.0.sqrt())
    }

    #[inline(always)]
    fn trunc(self) -> Lanes<S> {
        Lanes(self.0.trunc())
    }

    #[inline(always)]
    fn floor(self) -> Lanes<S> {
        Lanes(self.0.floor())
    }

    #[inline(always)]
    fn round(self) -> Lanes<S> {
        Lanes(self.0.round_ties_even())
    }

    #[inline(always)]
    fn copysign(self, sign: Lanes<S>) -> Lanes<S> {
        Lanes(self.0.copysign(sign.0))
    }

    #[inline(always)]
    fn sin_cos(self) -> (Lanes<S>, Lanes<S>) {
        let is_far = self.like(4_194_304.0).less(self.abs());
        let angle = if is_far.0.any_true() { Lanes::select(is_far, self.folded(), self) } else { self };
        let (quarters, bits) = (angle * f64::from(FRAC_2_PI)).nearest();
        let r = quarters.mul_add(angle.like(f64::from(-FRAC_PI_2)), angle);
        let r = quarters.mul_add(angle.like(f64::from(-series::LACKING)), r);
        let r2 = r * r;
        let sin = (r2.polynomial(series::SIN) * r2).mul_add(r, r);
        let series = r2.polynomial(series::COS);
        let cos = series.mul_add(r2 * r2, r2.mul_add(r.like(-0.5), r.like(1.0)));
        let even = LaneMask((bits & 1).simd_eq(0));
        let sin_of_angle = Lanes::select(even, sin, cos).turned(bits);
        let cos_of_angle = Lanes::select(even, cos, sin).turned(bits + 1);
        (sin_of_angle, cos_of_angle)
    }

    #[inline(always)]
    fn atan2(self, x: Lanes<S>) -> Lanes<S> {
        let (far, high) = (x.abs(), self.abs());
        let steep = far.less(high);
        let (longer, shorter) = (Lanes::select(steep, high, far), Lanes::select(steep, far, high));
        // Never 0 divided by 0.
        let slope = shorter / longer.max(longer.like(f64::from(f32::MIN_POSITIVE)));
        let square = slope * slope;
        let series = square.polynomial(series::ATAN);
        let angle = (series * square).mul_add(slope, slope);
        let angle = Lanes::select(steep, angle.like(f64::from(FRAC_PI_2)) - angle, angle);
        let angle = Lanes::select(x.less(x.like(0.0)), angle.like(f64::from(PI)) - angle, angle);
        angle.copysign(self)
    }

    #[inline(always)]
    fn exp(self) -> Lanes<S> {
        (self * f64::from(LOG2_E)).exp2()
    }

    #[inline(always)]
    fn ln(self) -> Lanes<S> {
        self.log2() * f64::from(LN_2)
    }

    #[inline(always)]
    fn pow(self, exponent: Lanes<S>) -> Lanes<S> {
        (self.log2() * exponent).exp2()
    }

    #[inline(always)]
    fn less(self, other: Lanes<S>) -> LaneMask<S> {
        LaneMask(self.0.simd_lt(other.0))
    }

    #[inline(always)]
    fn select(mask: LaneMask<S>, yes: Lanes<S>, no: Lanes<S>) -> Lanes<S> {
        Lanes(mask.0.select(yes.0, no.0))
    }
}

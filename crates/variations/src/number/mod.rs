//! The numbers that variations calculate with: one `f64`, or sixteen `f32` in one go.
//!
//! Owns the trait that lets each formula be written once, and its two implementations: [`f64`], by libm (`plain.rs`), and
//! [`Lanes`], by polynomials of our own (`lanes.rs`). Both give the same bits on every processor.
//! Never knows what a variation or an orbit is.
//!
//! Start at [`Number`].

mod lanes;
mod plain;
mod random;
pub mod series;

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

pub use lanes::{LaneMask, Lanes};
pub use random::LaneRng;

/// How many orbits [`Lanes`] hold.
pub const LANES: usize = 16;

/// A real number, or several that take the same steps.
///
/// Constants and parameters are `f64` on the right of an operator. Nothing here panics: what has no value is NaN or
/// very large, and whoever iterates looks for that.
pub trait Number:
    Copy
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
{
    /// The outcome of a comparison.
    type Mask: Mask;

    /// `value`, as many times as `self` is a number.
    fn like(self, value: f64) -> Self;
    /// `self * factor + term`, rounded once.
    fn mul_add(self, factor: Self, term: Self) -> Self;
    /// The absolute value.
    fn abs(self) -> Self;
    /// The square root; NaN below 0.
    fn sqrt(self) -> Self;
    /// Rounds towards 0.
    fn trunc(self) -> Self;
    /// Rounds down.
    fn floor(self) -> Self;
    /// Rounds to the nearest integer, halves to the even one.
    fn round(self) -> Self;
    /// The absolute value of `self` with the sign of `sign`.
    fn copysign(self, sign: Self) -> Self;
    /// Sine and cosine; for [`Lanes`] to 2e-7 up to an angle of a million, and anything in -1..=1 beyond four million.
    fn sin_cos(self) -> (Self, Self);
    /// The angle of the point `(x, self)`, in -π..=π; 0 at the origin.
    fn atan2(self, x: Self) -> Self;
    /// e to the power of `self`; for [`Lanes`] in 2^-126..=2^127.
    fn exp(self) -> Self;
    /// The natural logarithm. Below the smallest normal number it is that number's; of a negative one it is anything.
    fn ln(self) -> Self;
    /// `self` to the power of `exponent`, for `self` from 0 on.
    fn pow(self, exponent: Self) -> Self;

    /// Whether `self < other`; not where either is NaN.
    fn less(self, other: Self) -> Self::Mask;
    /// `yes` where `mask` holds, else `no`.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;

    /// The smaller of both; `other` where either is NaN.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self::select(self.less(other), self, other)
    }

    /// The larger of both; `other` where either is NaN.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self::select(other.less(self), self, other)
    }

    /// The sine.
    #[inline(always)]
    fn sin(self) -> Self {
        self.sin_cos().0
    }

    /// The cosine.
    #[inline(always)]
    fn cos(self) -> Self {
        self.sin_cos().1
    }

    /// The tangent.
    #[inline(always)]
    fn tan(self) -> Self {
        let (sin, cos) = self.sin_cos();
        sin / cos
    }

    /// The hyperbolic sine and cosine.
    #[inline(always)]
    fn sinh_cosh(self) -> (Self, Self) {
        let grown = self.exp();
        let shrunk = grown.like(1.0) / grown;
        ((grown - shrunk) * 0.5, (grown + shrunk) * 0.5)
    }
}

/// The outcome of a comparison, for one number or for several.
pub trait Mask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {
    /// Whether it holds for at least one of them.
    fn any(self) -> bool;
}

/// Where formulas get random numbers from.
pub trait Random<N: Number> {
    /// A number in `0.0..1.0`.
    fn unit(&mut self) -> N;
    /// Heads or tails.
    fn coin(&mut self) -> N::Mask;
}

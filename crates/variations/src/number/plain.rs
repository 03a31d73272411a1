//! One number at a time: `f64`, by libm's functions, which give the same bits on every processor.
//!
//! Owns the reference that [`Lanes`](super::Lanes) are compared with. It also draws what is so deep in a flame that `f32`
//! does not tell neighbouring cells apart.

use super::{Mask, Number, Random};
use species::Rng;

impl Mask for bool {
    #[inline]
    fn any(self) -> bool {
        self
    }
}

impl Number for f64 {
    type Mask = bool;

    #[inline]
    fn like(self, value: f64) -> f64 {
        value
    }

    #[inline]
    fn mul_add(self, factor: f64, term: f64) -> f64 {
        // Not rounded once: without the processor's instruction that is a call. The reference needs no last bit.
        self * factor + term
    }

    #[inline]
    fn abs(self) -> f64 {
        self.abs()
    }

    #[inline]
    fn sqrt(self) -> f64 {
        self.sqrt()
    }

    #[inline]
    fn trunc(self) -> f64 {
        self.trunc()
    }

    #[inline]
    fn floor(self) -> f64 {
        self.floor()
    }

    #[inline]
    fn round(self) -> f64 {
        self.round_ties_even()
    }

    #[inline]
    fn copysign(self, sign: f64) -> f64 {
        self.copysign(sign)
    }

    #[inline]
    fn sin_cos(self) -> (f64, f64) {
        libm::sincos(self)
    }

    #[inline]
    fn atan2(self, x: f64) -> f64 {
        libm::atan2(self, x)
    }

    #[inline]
    fn exp(self) -> f64 {
        libm::exp(self)
    }

    #[inline]
    fn ln(self) -> f64 {
        libm::log(self)
    }

    #[inline]
    fn pow(self, exponent: f64) -> f64 {
        libm::pow(self, exponent)
    }

    #[inline]
    fn less(self, other: f64) -> bool {
        self < other
    }

    #[inline]
    fn select(mask: bool, yes: f64, no: f64) -> f64 {
        if mask { yes } else { no }
    }
}

impl Random<f64> for Rng {
    #[inline]
    fn unit(&mut self) -> f64 {
        Rng::unit(self)
    }

    #[inline]
    fn coin(&mut self) -> bool {
        self.bits() >> 63 == 1
    }
}

//! Exact rates.
//!
//! Owns [`Rate`], a reduced fraction. Never rounds.

use std::fmt;
use std::num::NonZeroU32;

/// Events per second as an exact fraction: a clip's fps or a screen's refresh (24000/1001, never 23.976).
/// Always in lowest terms, so equal rates are equal values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Rate {
    num: NonZeroU32,
    den: NonZeroU32,
}

/// Why two numbers are no rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{num}/{den}` is no rate: both numbers must be from 1 to 4294967295")]
pub struct RateError {
    /// Numerator as given.
    pub num: u64,
    /// Denominator as given.
    pub den: u64,
}

impl Rate {
    /// The rate `num / den` per second, reduced.
    ///
    /// # Errors
    /// [`RateError`] if either is 0, or too large for `u32` even in lowest terms.
    pub fn new(num: u64, den: u64) -> Result<Self, RateError> {
        let refused = RateError { num, den };
        let divisor = gcd(num, den).max(1);
        let fit = |n: u64| u32::try_from(n / divisor).ok().and_then(NonZeroU32::new).ok_or(refused);
        Ok(Self { num: fit(num)?, den: fit(den)? })
    }

    /// Numerator in lowest terms.
    pub fn num(self) -> u32 {
        self.num.get()
    }

    /// Denominator in lowest terms.
    pub fn den(self) -> u32 {
        self.den.get()
    }

    /// How long `count` periods take, in whole nanoseconds, rounded down.
    pub fn span_ns(self, count: u64) -> u64 {
        let ns = u128::from(count) * 1_000_000_000 * u128::from(self.den()) / u128::from(self.num());
        u64::try_from(ns).unwrap_or(u64::MAX)
    }

    /// Whether this rate is a whole multiple of `other`: every frame then stays lit equally long.
    pub fn is_multiple_of(self, other: Self) -> bool {
        let up = u64::from(self.num()) * u64::from(other.den());
        let down = u64::from(self.den()) * u64::from(other.num());
        up.is_multiple_of(down)
    }
}

impl fmt::Display for Rate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.den() == 1 { write!(f, "{}", self.num) } else { write!(f, "{}/{}", self.num, self.den) }
    }
}

/// The greatest common divisor; `a` where `b` is 0.
pub(crate) fn gcd(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { gcd(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_rates_are_equal_values() {
        assert_eq!(Rate::new(60_000, 2_000), Rate::new(30, 1));
        assert_eq!(Rate::new(24_000, 1_001).unwrap().to_string(), "24000/1001");
        assert_eq!(Rate::new(30, 1).unwrap().to_string(), "30");
    }

    #[test]
    fn nothing_per_second_is_no_rate() {
        assert_eq!(Rate::new(0, 1), Err(RateError { num: 0, den: 1 }));
        assert_eq!(Rate::new(1, 0), Err(RateError { num: 1, den: 0 }));
        assert!(Rate::new(u64::MAX, 1).is_err());
    }

    #[test]
    fn sixty_is_a_multiple_of_thirty_and_not_of_film() {
        let hz = |n, d| Rate::new(n, d).unwrap();
        assert!(hz(60, 1).is_multiple_of(hz(30, 1)));
        assert!(!hz(60, 1).is_multiple_of(hz(24, 1)));
        assert!(!hz(60, 1).is_multiple_of(hz(30_000, 1_001)));
        assert!(hz(60_000, 1_001).is_multiple_of(hz(30_000, 1_001)));
    }

    #[test]
    fn a_second_of_film_takes_a_second_and_a_bit() {
        assert_eq!(Rate::new(24_000, 1_001).unwrap().span_ns(24_000), 1_001_000_000_000);
    }
}

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

/// How far a screen's refresh may be off a whole multiple of the frame rate, in percent, for every frame to stay lit
/// for that many vblanks. A change of speed by 1 % is invisible without sound; a frame that stays for one vblank more
/// is visible.
const LOCK_TOLERANCE_PERCENT: u128 = 1;

/// Two numbers that do not make a rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{num}/{den}` is not a rate: both numbers must be from 1 to 4294967295")]
pub struct RateError {
    /// Numerator as given.
    pub num: u64,
    /// Denominator as given.
    pub den: u64,
}

impl Rate {
    /// `num / den` per second, reduced.
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

    /// The whole number `n` for which this rate is within 1 % of `n` times `other`; `None` if there is none.
    pub fn multiple_of(self, other: Self) -> Option<u32> {
        let up = u128::from(self.num()) * u128::from(other.den());
        let down = u128::from(self.den()) * u128::from(other.num());
        let nearest = (2 * up + down) / (2 * down);
        let is_near = nearest > 0 && up.abs_diff(nearest * down) * 100 <= nearest * down * LOCK_TOLERANCE_PERCENT;
        u32::try_from(nearest).ok().filter(|_| is_near)
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
    fn a_rate_locks_to_another_within_a_hundredth_of_a_multiple() {
        let hz = |n, d| Rate::new(n, d).unwrap();
        assert_eq!(hz(60, 1).multiple_of(hz(30, 1)), Some(2));
        assert_eq!(hz(60_000, 1_001).multiple_of(hz(30, 1)), Some(2));
        assert_eq!(hz(60_600, 1_000).multiple_of(hz(30, 1)), Some(2), "a hundredth is within");
        assert_eq!(hz(60_601, 1_000).multiple_of(hz(30, 1)), None);
        assert_eq!(hz(60, 1).multiple_of(hz(24, 1)), None);
        assert_eq!(hz(30, 1).multiple_of(hz(60, 1)), None, "half is no whole multiple");
        assert_eq!(hz(1, u64::from(u32::MAX)).multiple_of(hz(u64::from(u32::MAX), 1)), None);
    }

    #[test]
    fn a_second_of_film_takes_a_second_and_a_bit() {
        assert_eq!(Rate::new(24_000, 1_001).unwrap().span_ns(24_000), 1_001_000_000_000);
    }
}

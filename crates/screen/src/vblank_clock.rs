//! Vblanks computed from a clock, for screens without vblank interrupts.
//!
//! Vblank `n` starts `n` periods after the origin. The time is an argument.

use timing::{Nanos, Rate, Vblank};

/// A grid of vblanks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VblankClock {
    origin: Nanos,
    refresh: Rate,
}

impl VblankClock {
    /// `refresh` vblanks per second; number 0 starts at `origin`.
    pub(crate) fn new(origin: Nanos, refresh: Rate) -> Self {
        Self { origin, refresh }
    }

    /// The start of vblank `vblank`, in whole nanoseconds, rounded down.
    pub(crate) fn begins(&self, vblank: u64) -> Nanos {
        self.origin.after(self.refresh.span_ns(vblank))
    }

    /// The vblank at `now`.
    pub(crate) fn at(&self, now: Nanos) -> u64 {
        let elapsed = u128::from(now.since(self.origin));
        let periods = elapsed * u128::from(self.refresh.num()) / u128::from(self.refresh.den());
        let begun = u64::try_from(periods / 1_000_000_000).unwrap_or(u64::MAX);
        // Starts are rounded down: the next one may start a fraction of a nanosecond early.
        if self.begins(begun + 1) <= now { begun + 1 } else { begun }
    }

    /// `vblank`, near `now`, as a counter that does not wrap.
    pub(crate) fn unwrap_near(&self, vblank: Vblank, now: Nanos) -> u64 {
        let current = self.at(now);
        current.saturating_add_signed(vblank.since(Vblank(current as u32)).into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn a_vblank_has_begun_exactly_from_its_beginning_on(vblank in 1u64..1 << 33, rate in 20_000u64..240_000) {
            let beat = VblankClock::new(Nanos(77), Rate::new(rate, 1001).unwrap());
            let begins = beat.begins(vblank);
            prop_assert_eq!(beat.at(begins), vblank);
            prop_assert_eq!(beat.at(Nanos(begins.0 - 1)), vblank - 1);
        }

        #[test]
        fn a_wrapped_counter_is_unwrapped_near_now(vblank in 1u64 << 32..1 << 34, ahead in -1000i64..1000) {
            let beat = VblankClock::new(Nanos(0), Rate::new(60, 1).unwrap());
            let meant = vblank.saturating_add_signed(ahead);
            prop_assert_eq!(beat.unwrap_near(Vblank(meant as u32), beat.begins(vblank)), meant);
        }
    }
}

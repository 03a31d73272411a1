//! Counters of different types: frames, vblanks, nanoseconds.
//!
//! Owns the newtypes. Rates are in `rate.rs`.

use std::fmt;

/// A point on the monotonic clock, in nanoseconds since its own origin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Nanos(pub u64);

impl Nanos {
    /// Nanoseconds from `earlier` to here, 0 if `earlier` lies ahead.
    pub fn since(self, earlier: Self) -> u64 {
        self.0.saturating_sub(earlier.0)
    }

    /// The point `ns` nanoseconds later.
    #[must_use]
    pub fn after(self, ns: u64) -> Self {
        Self(self.0.saturating_add(ns))
    }
}

/// A frame's place in the endless stream, from 0 at the start of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FrameIndex(pub u64);

/// How many frames a clip has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FrameCount(pub u32);

impl fmt::Display for FrameCount {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// The kernel's vblank counter of one CRTC. It wraps, so it has no `Ord`: ask [`Vblank::since`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Vblank(pub u32);

impl Vblank {
    /// Vblanks from `earlier` to here, negative if `earlier` lies ahead; exact within 2^31 vblanks (400 days at 60 Hz).
    pub fn since(self, earlier: Self) -> i32 {
        self.0.wrapping_sub(earlier.0).cast_signed()
    }

    /// The vblank `count` later.
    #[must_use]
    pub fn after(self, count: u32) -> Self {
        Self(self.0.wrapping_add(count))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vblank_counter_may_wrap() {
        assert_eq!(Vblank(1).since(Vblank(u32::MAX)), 2);
        assert_eq!(Vblank(u32::MAX).since(Vblank(1)), -2);
        assert_eq!(Vblank(u32::MAX).after(3), Vblank(2));
    }
}

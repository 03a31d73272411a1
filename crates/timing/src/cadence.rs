//! For how many vblanks each frame stays lit.
//!
//! Owns the cadence: the mapping from a clip's rate to the screen's, by error diffusion. Pure arithmetic.
//! Never reads a clock, never touches a screen. The error is carried across joins: resetting it at each clip
//! would make the only hiccup that a viewer can see.
//!
//! Start at [`Cadence::hold`]. The film-on-60-Hz case is drawn in the tests.

use crate::rate::{Rate, gcd};

/// Error-diffused cadence of one stream on one screen.
///
/// The phase error is kept as an exact fraction of a vblank and stays within half a vblank for ever.
///
/// # Source
/// mpv's display-sync: `n = lrint(ratio + error)`, here in integers.
#[derive(Clone, Debug)]
pub struct Cadence {
    /// Vblanks per frame as `up / down`, in lowest terms.
    up: u64,
    down: u64,
    /// What is owed to the next frame, in `1 / down` vblanks; within `±down / 2`.
    owed: i64,
}

impl Cadence {
    /// The cadence of `frames` per second on a screen of `refresh` vblanks per second.
    pub fn new(frames: Rate, refresh: Rate) -> Self {
        let up = u64::from(refresh.num()) * u64::from(frames.den());
        let down = u64::from(refresh.den()) * u64::from(frames.num());
        let divisor = gcd(up, down);
        Self { up: up / divisor, down: down / divisor, owed: 0 }
    }

    /// How many vblanks the next frame stays lit. 0 only where frames come faster than vblanks: such a frame is
    /// due together with its successor.
    pub fn hold(&mut self) -> u32 {
        let down = i128::from(self.down);
        let exact = i128::from(self.up) + i128::from(self.owed);
        // Nearest whole vblank, halves downwards: 2, 3, 2, 3 for film on 60 Hz.
        let held = (2 * exact - down).div_euclid(2 * down) + i128::from((2 * exact - down).rem_euclid(2 * down) != 0);
        let held = held.max(0);
        self.owed = (exact - held * down) as i64;
        u32::try_from(held).unwrap_or(u32::MAX)
    }

    /// The same phase on a screen of another refresh, after a mode change.
    #[must_use]
    pub fn moved_to(&self, frames: Rate, refresh: Rate) -> Self {
        let mut moved = Self::new(frames, refresh);
        moved.owed = (i128::from(self.owed) * i128::from(moved.down) / i128::from(self.down)) as i64;
        moved
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn holds(frames: (u64, u64), refresh: (u64, u64), count: usize) -> Vec<u32> {
        let rate = |(n, d)| Rate::new(n, d).unwrap();
        let mut cadence = Cadence::new(rate(frames), rate(refresh));
        (0..count).map(|_| cadence.hold()).collect()
    }

    #[test]
    fn film_on_a_60_hz_screen_is_lit_two_three_two_three() {
        assert_eq!(holds((24, 1), (60, 1), 6), [2, 3, 2, 3, 2, 3]);
    }

    #[test]
    fn whole_multiples_are_lit_evenly() {
        assert_eq!(holds((30, 1), (60, 1), 4), [2, 2, 2, 2]);
        assert_eq!(holds((20, 1), (60, 1), 4), [3, 3, 3, 3]);
        assert_eq!(holds((25, 1), (50, 1), 3), [2, 2, 2]);
    }

    #[test]
    fn the_published_sequences_come_out() {
        assert_eq!(holds((25, 1), (60, 1), 5), [2, 3, 2, 3, 2]);
        assert_eq!(holds((23, 1), (60, 1), 16), [3, 2, 3, 2, 3, 3, 2, 3, 2, 3, 3, 2, 3, 3, 2, 3]);
        assert_eq!(holds((24, 1), (50, 1), 12).iter().sum::<u32>(), 25);
    }

    proptest! {
        #[test]
        fn a_frame_is_never_more_than_half_a_vblank_off(
            fps in 1u64..=120_000, den in prop_oneof![Just(1u64), Just(1_000), Just(1_001)], refresh in 20_000u64..=240_000,
        ) {
            let (frames, screen) = (Rate::new(fps, den).unwrap(), Rate::new(refresh, 1_000).unwrap());
            let mut cadence = Cadence::new(frames, screen);
            let mut lit = 0i128;
            for frame in 1..=500i128 {
                lit += i128::from(cadence.hold());
                // |lit - frame * refresh / fps| <= 1/2, without dividing.
                let up = i128::from(screen.num()) * i128::from(frames.den());
                let down = i128::from(screen.den()) * i128::from(frames.num());
                prop_assert!((2 * (lit * down - frame * up)).abs() <= down, "frame {frame} lit {lit}");
            }
        }
    }
}

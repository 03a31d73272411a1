//! How many vblanks each frame stays on the screen.
//!
//! Owns the cadence: the mapping from a clip's rate to the screen's. Pure arithmetic. Never reads a clock, never
//! touches a screen. Where the screen's refresh is near a whole multiple of the clip's rate, every frame gets the same
//! number of vblanks, and playback is up to 1 % slower or faster. Elsewhere the rounding error is carried to the next
//! frame and across joins: resetting it at each clip would be visible as a stutter.
//!
//! Start at [`Cadence::hold`]. Real display modes are tabled in `cadence/modes.rs`.

#[cfg(test)]
mod modes;

use crate::rate::{Rate, gcd};

/// The cadence of one stream on one screen.
///
/// Locked, every frame stays lit for the same number of vblanks. Diffused, the phase error is kept as an exact fraction of a
/// vblank and stays within half a vblank for ever.
///
/// # Source
/// mpv's display-sync: `n = lrint(ratio + error)`, here in integers; and its `video-sync=display-resample`, which changes the
/// speed so that `n` is constant.
#[derive(Clone, Debug)]
pub struct Cadence {
    /// Vblanks per frame as `up / down`, in lowest terms; `down` is 1 where the two rates are locked.
    up: u64,
    down: u64,
    /// Rounding error carried to the next frame, in `1 / down` vblanks; within `±down / 2`.
    error: i64,
}

impl Cadence {
    /// The cadence of `frames` per second on a screen of `refresh` vblanks per second.
    pub fn new(frames: Rate, refresh: Rate) -> Self {
        if let Some(vblanks) = refresh.multiple_of(frames) {
            return Self { up: vblanks.into(), down: 1, error: 0 };
        }
        let up = u64::from(refresh.num()) * u64::from(frames.den());
        let down = u64::from(refresh.den()) * u64::from(frames.num());
        let divisor = gcd(up, down);
        Self { up: up / divisor, down: down / divisor, error: 0 }
    }

    /// How many vblanks the next frame stays lit. 0 only where the frame rate exceeds the refresh: such a frame is due
    /// together with the next one.
    pub fn hold(&mut self) -> u32 {
        let down = i128::from(self.down);
        let exact = i128::from(self.up) + i128::from(self.error);
        // Nearest whole vblank, halves downwards: 2, 3, 2, 3 for film on 60 Hz.
        let held = (2 * exact - down).div_euclid(2 * down) + i128::from((2 * exact - down).rem_euclid(2 * down) != 0);
        let held = held.max(0);
        self.error = (exact - held * down) as i64;
        u32::try_from(held).unwrap_or(u32::MAX)
    }

    /// The same phase on a screen of another refresh, after a mode change.
    #[must_use]
    pub fn with_rates(&self, frames: Rate, refresh: Rate) -> Self {
        let mut moved = Self::new(frames, refresh);
        moved.error = (i128::from(self.error) * i128::from(moved.down) / i128::from(self.down)) as i64;
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
    fn the_published_sequences_come_out() {
        assert_eq!(holds((25, 1), (60, 1), 5), [2, 3, 2, 3, 2]);
        assert_eq!(holds((23, 1), (60, 1), 16), [3, 2, 3, 2, 3, 3, 2, 3, 2, 3, 3, 2, 3, 3, 2, 3]);
        assert_eq!(holds((24, 1), (50, 1), 12).iter().sum::<u32>(), 25);
    }

    #[test]
    fn what_was_owed_is_dropped_where_the_rates_lock() {
        let rate = |n, d| Rate::new(n, d).unwrap();
        let mut film = Cadence::new(rate(24, 1), rate(60, 1));
        film.hold();
        let mut locked = film.with_rates(rate(24, 1), rate(48, 1));
        assert_eq!([locked.hold(), locked.hold(), locked.hold()], [2, 2, 2]);
    }

    fn rates() -> impl Strategy<Value = (Rate, Rate)> {
        let frames = (1u64..=120_000, prop_oneof![Just(1u64), Just(1_000), Just(1_001)]);
        (frames, 20_000u64..=240_000)
            .prop_map(|((fps, den), refresh)| (Rate::new(fps, den).unwrap(), Rate::new(refresh, 1_000).unwrap()))
    }

    proptest! {
        #[test]
        fn a_frame_is_never_more_than_half_a_vblank_off_or_all_are_lit_equally_long((frames, screen) in rates()) {
            let mut cadence = Cadence::new(frames, screen);
            let mut lit = 0i128;
            for frame in 1..=500i128 {
                let held = cadence.hold();
                lit += i128::from(held);
                // |lit - frame * refresh / fps| <= 1/2, without dividing.
                let up = i128::from(screen.num()) * i128::from(frames.den());
                let down = i128::from(screen.den()) * i128::from(frames.num());
                match screen.multiple_of(frames) {
                    Some(vblanks) => prop_assert_eq!(held, vblanks),
                    None => prop_assert!((2 * (lit * down - frame * up)).abs() <= down, "frame {} lit {}", frame, lit),
                }
            }
        }

        #[test]
        fn a_locked_run_is_a_hundredth_slower_or_faster_at_most(fps in 1u64..=240, times in 1u64..=8, off in 990u64..=1_010) {
            let (frames, screen) = (Rate::new(fps, 1).unwrap(), Rate::new(fps * times * off, 1_000).unwrap());
            let mut cadence = Cadence::new(frames, screen);
            let vblanks: u64 = (0..1_000).map(|_| u64::from(cadence.hold())).sum();
            prop_assert_eq!(vblanks, 1_000 * times);
            let (took, wanted) = (screen.span_ns(vblanks) as f64, frames.span_ns(1_000) as f64);
            prop_assert!((took / wanted - 1.0).abs() <= 0.010_11, "{} for {}", took, wanted);
        }
    }
}

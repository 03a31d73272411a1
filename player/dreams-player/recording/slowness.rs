//! Whether the player keeps up with its flock.
//!
//! Owns that decision: a pure function of the counters of the run, of the screen's rate and of the time. A short
//! shortage does not count, nor does a picture that is held because no clip can be read. Never plays faster or slower.
//!
//! Start at [`Slowness::look`].

use crate::recording::view::Tally;
use timing::{Nanos, Rate};

/// Vblanks of a span: ten seconds at 60 Hz.
const SPAN: u64 = 600;
/// So many spans in a row decide: a minute at 60 Hz.
const SPANS: u32 = 6;
/// A span is slow if a frame was due and not there at more than one of so many vblanks.
const ONE_OF: u64 = 20;

/// What is known of the last spans.
#[derive(Debug, Default)]
pub(crate) struct Slowness {
    /// The span that runs: the screen's rate, its beginning and the counters then.
    span: Option<(Rate, Nanos, Tally)>,
    /// How many spans in a row were slow, or were not, whichever was last.
    row: u32,
    /// Which of both.
    was_slow: bool,
    is_slow: bool,
}

impl Slowness {
    /// Whether the player is too slow at `now`, when the run has these counters on a screen of `refresh` vblanks per
    /// second; `None` while the screen is away. It is, once six spans in a row were slow, until six were not.
    pub(crate) fn look(&mut self, tally: Tally, refresh: Option<Rate>, now: Nanos) -> bool {
        let Some(refresh) = refresh else {
            *self = Self::default();
            return false;
        };
        let Some((before, begun, counted)) = self.span.filter(|(before, ..)| *before == refresh) else {
            *self = Self { span: Some((refresh, now, tally)), ..Self::default() };
            return false;
        };
        let elapsed_ns = now.since(begun);
        if elapsed_ns < before.span_ns(SPAN) {
            return self.is_slow;
        }
        let vblanks = elapsed_ns / before.span_ns(1).max(1);
        let late = tally.late.saturating_sub(counted.late);
        let is_slow = late.saturating_mul(ONE_OF) > vblanks && tally.flips > counted.flips;
        self.row = if self.row > 0 && is_slow == self.was_slow { self.row.saturating_add(1) } else { 1 };
        (self.was_slow, self.span) = (is_slow, Some((refresh, now, tally)));
        if self.row >= SPANS {
            self.is_slow = is_slow;
        }
        self.is_slow
    }
}

#[cfg(test)]
mod tests {
    use super::Slowness;
    use crate::recording::Tally;
    use timing::{Nanos, Rate};

    /// Looks twice a second at a screen of 60 Hz, in each second of which there are so many flips and late vblanks;
    /// returns the looks at which the answer changed.
    fn changes(seconds: &[(u64, u64)]) -> Vec<(usize, bool)> {
        let refresh = Some(Rate::new(60, 1).unwrap());
        let (mut slowness, mut tally, mut told) = (Slowness::default(), Tally::default(), vec![(0, false)]);
        for (second, (flips, late)) in seconds.iter().enumerate() {
            for half in 0..2 {
                let is_slow = slowness.look(tally, refresh, Nanos((2 * second as u64 + half) * 500_000_000));
                if told.last().unwrap().1 != is_slow {
                    told.push((2 * second + usize::from(half == 1), is_slow));
                }
            }
            tally = Tally { flips: tally.flips + flips, late: tally.late + late, ..tally };
        }
        told
    }

    #[test]
    fn a_player_is_too_slow_after_a_minute_of_late_frames_and_until_a_minute_without() {
        let [slow, fast] = [vec![(4, 50); 90], vec![(30, 3); 90]];
        assert_eq!(changes(&[slow.clone(), fast.clone()].concat()), [(0, false), (120, true), (300, false)]);
        assert_eq!(changes(&fast), [(0, false)], "one vblank in twenty is little");
        let pause = [fast.clone(), vec![(1, 59); 40], fast].concat();
        assert_eq!(changes(&pause), [(0, false)], "forty seconds are a shortage, which ends");
        assert_eq!(changes(&vec![(0, 60); 300]), [(0, false)], "a picture that is held for want of a clip");
    }

    #[test]
    fn a_screen_that_goes_or_changes_begins_anew() {
        let [one, other] = [60, 50].map(|hz| Rate::new(hz, 1).unwrap());
        let mut slowness = Slowness::default();
        let mut look = |refresh, second: u64| {
            let tally = Tally { flips: second, late: 50 * second, ..Tally::default() };
            slowness.look(tally, refresh, Nanos(second * 1_000_000_000))
        };
        assert!((0..=60).fold(false, |_, second| look(Some(one), second)));
        assert!(!look(Some(other), 61), "another rate");
        assert!((62..=140).fold(false, |_, second| look(Some(other), second)));
        assert!(!look(None, 141) && !look(Some(other), 142));
    }
}

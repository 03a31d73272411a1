//! Which vblank the next frame is due at, and how late it was.
//!
//! Owns the cadence of the run: one sequence from the first frame to the last, carried across joins.
//! Pure arithmetic on the vblanks that flips bring; nothing is ever skipped to catch up, so a late frame moves all
//! that follow. A flock faster than the screen is shown one frame a vblank: slower than it was made, but whole.

use timing::{Cadence, Rate, Vblank};

/// When the frames of one flock are due on one screen.
#[derive(Clone, Debug)]
pub(crate) struct Pacing {
    frames: Rate,
    refresh: Rate,
    cadence: Cadence,
    /// How many vblanks the lit frame stays lit, at least 1.
    hold: u32,
    /// When the lit frame arrived; `None` before the first.
    lit: Option<Vblank>,
    /// The newest vblank that the screen told of, and that of the last flip.
    newest: Vblank,
    flipped: Vblank,
}

impl Pacing {
    /// For `frames` a second on a screen of `refresh` vblanks a second.
    pub(crate) fn new(frames: Rate, refresh: Rate) -> Self {
        let (newest, flipped) = (Vblank(0), Vblank(0));
        Self { frames, refresh, cadence: Cadence::new(frames, refresh), hold: 1, lit: None, newest, flipped }
    }

    /// How many frames a second.
    pub(crate) fn frames(&self) -> Rate {
        self.frames
    }

    /// `vblank` has begun.
    pub(crate) fn begun(&mut self, vblank: Vblank) {
        self.newest = vblank;
    }

    /// The lit frame arrived at `vblank` once more, and its time goes on.
    pub(crate) fn repeated(&mut self, vblank: Vblank) {
        (self.newest, self.flipped) = (vblank, vblank);
    }

    /// A new frame arrived at `vblank`. Returns how many vblanks after its due one: once per vblank missed.
    pub(crate) fn flipped(&mut self, vblank: Vblank) -> u32 {
        self.repeated(vblank);
        let late = self.lit.map_or(0, |lit| vblank.since(lit.after(self.hold)));
        self.hold = self.cadence.hold().max(1);
        self.lit = Some(vblank);
        late.max(0).cast_unsigned()
    }

    /// How many vblanks the next frame is overdue, counting the newest one.
    pub(crate) fn overdue(&self) -> u32 {
        let overdue = self.lit.map_or(0, |lit| self.newest.since(lit.after(self.hold)).saturating_add(1));
        overdue.max(0).cast_unsigned()
    }

    /// The awaited frame is not late from here on.
    pub(crate) fn settle(&mut self) {
        if self.overdue() > 0 {
            self.lit = Some(self.newest);
        }
    }

    /// The screen has `refresh` vblanks a second from now on.
    pub(crate) fn set_refresh(&mut self, refresh: Rate) {
        self.refresh = refresh;
        self.cadence = self.cadence.with_rates(self.frames, refresh);
    }

    /// From the next frame on they come at another rate, and the screen has `refresh` vblanks a second: what is owed is
    /// carried over, and the lit frame keeps its time.
    pub(crate) fn goes_on(&mut self, frames: Rate, refresh: Rate) {
        self.frames = frames;
        self.set_refresh(refresh);
    }

    /// The screen was away and shows the last frame again since `vblank`: it stays lit for its time, and the time
    /// without a screen does not count as late.
    pub(crate) fn resumed(&mut self, vblank: Vblank) {
        self.repeated(vblank);
        self.lit = Some(vblank);
    }

    /// The last vblank of the lit frame, if that is to come: a commit after it began shows the next frame at the vblank at
    /// which it is due.
    pub(crate) fn last_vblank(&self) -> Option<Vblank> {
        self.lit.map(|lit| lit.after(self.hold - 1)).filter(|last| last.since(self.newest) > 0)
    }

    /// The vblank after the newest.
    pub(crate) fn next_vblank(&self) -> Vblank {
        self.newest.after(1)
    }

    /// Whether the last flip was a second ago, or longer.
    pub(crate) fn is_stale(&self) -> bool {
        let second = self.refresh.num().div_ceil(self.refresh.den());
        self.newest.since(self.flipped) >= second.cast_signed()
    }
}

#[cfg(test)]
mod tests {
    use super::Pacing;
    use timing::{Rate, Vblank};

    fn rate(num: u64, den: u64) -> Rate {
        Rate::new(num, den).unwrap()
    }

    #[test]
    fn film_on_60_hz_is_due_after_two_and_three_vblanks_by_turns() {
        let mut pacing = Pacing::new(rate(24, 1), rate(60, 1));
        let mut at = Vblank(u32::MAX - 3);
        let mut holds = Vec::new();
        for _ in 0..6 {
            assert_eq!(pacing.flipped(at), 0);
            let due = pacing.last_vblank().unwrap().after(1);
            holds.push(due.since(at));
            at = due;
        }
        assert_eq!(holds, [2, 3, 2, 3, 2, 3]);
    }

    #[test]
    fn a_late_frame_counts_once_per_missed_vblank_and_moves_its_successors() {
        let mut pacing = Pacing::new(rate(30, 1), rate(60, 1));
        assert_eq!(pacing.flipped(Vblank(10)), 0);
        assert_eq!(pacing.flipped(Vblank(15)), 3);
        assert_eq!(pacing.last_vblank(), Some(Vblank(16)));
        assert_eq!(pacing.flipped(Vblank(17)), 0);
    }

    #[test]
    fn a_frame_that_is_awaited_is_late_already() {
        let mut pacing = Pacing::new(rate(30, 1), rate(60, 1));
        assert_eq!(pacing.overdue(), 0);
        pacing.flipped(Vblank(10));
        let mut overdue_at = |vblank| {
            pacing.begun(Vblank(vblank));
            pacing.overdue()
        };
        assert_eq!([10, 11, 12, 13, 14].map(&mut overdue_at), [0, 0, 1, 2, 3]);
        assert_eq!((pacing.flipped(Vblank(15)), pacing.overdue()), (3, 0));
    }

    #[test]
    fn a_flock_faster_than_the_screen_is_shown_whole() {
        let mut pacing = Pacing::new(rate(60, 1), rate(30, 1));
        for vblank in 0..100 {
            assert_eq!(pacing.flipped(Vblank(vblank)), 0);
            assert_eq!(pacing.last_vblank(), None, "the next one goes at once");
        }
    }

    #[test]
    fn another_rate_holds_from_its_first_frame_on_and_that_one_comes_in_its_time() {
        let mut pacing = Pacing::new(rate(30, 1), rate(60, 1));
        assert_eq!(pacing.flipped(Vblank(10)), 0);
        pacing.goes_on(rate(20, 1), rate(60, 1));
        assert_eq!((pacing.last_vblank(), pacing.flipped(Vblank(12))), (Some(Vblank(11)), 0));
        assert_eq!(pacing.last_vblank(), Some(Vblank(14)));
    }

    #[test]
    fn time_without_a_screen_is_nobodys_lateness() {
        let mut pacing = Pacing::new(rate(25, 1), rate(60, 1));
        pacing.flipped(Vblank(100));
        pacing.set_refresh(rate(50, 1));
        pacing.resumed(Vblank(7));
        assert_eq!(pacing.flipped(Vblank(9)), 0);
        assert_eq!(pacing.last_vblank(), Some(Vblank(10)));
    }
}

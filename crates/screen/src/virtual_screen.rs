//! A screen in memory: for machines without a display, for tests, and for the live view.
//!
//! Owns its last picture and its own vblanks. Pictures are neither dropped nor reordered. Start at
//! [`VirtualScreen::new`]; [`Pace`] selects the source of its vblanks.

use crate::picture::OwnedPicture;
use crate::vblank_clock::VblankClock;
use crate::{DimmedBy, Event, Light, OutputSettings, Picture, Screen, ScreenError, ScreenInfo};
use rustix::event::{Timespec, poll};
use std::time::Duration;
use timing::{Nanos, Rate, Vblank};

/// The source of a virtual screen's vblanks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// From the clock: vblank `n` begins `n` periods after the screen was made.
    Timer,
    /// From the player: every flip and every vblank asked for comes at once, and the counter jumps to it.
    /// Vblank `n` is said to begin at `n` periods, whatever the clock says.
    Free,
}

/// A screen in memory whose picture can be read.
#[derive(Debug)]
pub struct VirtualScreen {
    size: (u32, u32),
    /// Its size follows that of the pictures.
    is_to_measure: bool,
    refresh: Rate,
    pace: Pace,
    now: fn() -> Nanos,
    beat: VblankClock,
    /// Free pace only: the vblank that the player has reached.
    reached: u64,
    shown: Option<OwnedPicture>,
    staged: Option<OwnedPicture>,
    /// The committed picture, and the vblank at which it flips.
    committed: Option<(OwnedPicture, u64)>,
    asked: Option<u64>,
    is_asleep: bool,
    /// The event of sleeping or waking is not reported yet.
    turned: bool,
    /// A previous picture, whose memory is reused.
    spare: Option<OwnedPicture>,
}

impl VirtualScreen {
    /// A dark screen of `size` pixels that has `refresh` vblanks per second.
    ///
    /// * `now` — the monotonic clock; read at [`Pace::Timer`] only.
    pub fn new(size: (u32, u32), refresh: Rate, pace: Pace, now: fn() -> Nanos) -> Self {
        let origin = match pace {
            Pace::Timer => now(),
            Pace::Free => Nanos(0),
        };
        Self {
            size,
            is_to_measure: false,
            refresh,
            pace,
            now,
            beat: VblankClock::new(origin, refresh),
            reached: 0,
            shown: None,
            staged: None,
            committed: None,
            asked: None,
            is_asleep: false,
            turned: false,
            spare: None,
        }
    }

    /// The same screen, whose size follows that of its pictures.
    #[must_use]
    pub fn to_measure(mut self) -> Self {
        self.is_to_measure = true;
        self
    }

    /// The picture on the screen: the last one whose flip was reported; `None` before the first.
    pub fn picture(&self) -> Option<Picture<'_>> {
        self.shown.as_ref().map(OwnedPicture::view)
    }

    /// The vblank that has begun.
    fn current(&self) -> u64 {
        match self.pace {
            Pace::Free => self.reached,
            Pace::Timer => self.beat.at((self.now)()),
        }
    }

    /// The next event, and its vblank.
    fn due(&self) -> Option<u64> {
        let flip = self.committed.as_ref().map(|(_, vblank)| *vblank);
        [flip, self.asked].into_iter().flatten().min()
    }

    /// The event of vblank `due`, a flip before a notice.
    fn happen(&mut self, due: u64) -> Event {
        if let Some((picture, _)) = self.committed.take_if(|(_, vblank)| *vblank <= due) {
            self.spare = self.shown.replace(picture);
            return Event::Flip { vblank: Vblank(due as u32), at: self.beat.begins(due) };
        }
        self.asked = None;
        let vblank = self.current().max(due);
        Event::Vblank { vblank: Vblank(vblank as u32), at: self.beat.begins(vblank) }
    }
}

impl Screen for VirtualScreen {
    fn info(&self) -> Option<ScreenInfo> {
        (!self.is_asleep).then(|| ScreenInfo {
            screen: "virtual".to_owned(),
            mode: format!("{}x{}@{}", self.size.0, self.size.1, self.refresh),
            size: self.size,
            format: "YU12".to_owned(),
            refresh: self.refresh,
            notes: Vec::new(),
            dimmed_by: DimmedBy::Nothing,
            connector: None,
        })
    }

    fn stage(&mut self, picture: &Picture<'_>) -> Result<(), ScreenError> {
        picture.check(self.size)?;
        if self.is_asleep {
            return Ok(());
        }
        let mut held = self.staged.take().or_else(|| self.spare.take()).unwrap_or_default();
        held.copy_from(picture);
        self.staged = Some(held);
        Ok(())
    }

    fn commit(&mut self) {
        if self.committed.is_none()
            && !self.is_asleep
            && let Some(picture) = self.staged.take().or_else(|| self.shown.clone())
        {
            self.committed = Some((picture, self.current() + 1));
        }
    }

    fn set_format(&mut self, size: (u32, u32), _: Rate) {
        if self.is_to_measure {
            self.size = size;
        }
    }

    /// It sleeps and wakes like a display; brightness has no effect.
    fn set_light(&mut self, light: Light) {
        let sleeps = light == Light::Off;
        self.turned |= sleeps != self.is_asleep;
        self.is_asleep = sleeps;
        if sleeps {
            (self.staged, self.committed, self.asked) = (None, None, None);
        }
    }

    /// A picture in memory is as it is.
    fn set_output(&mut self, _: &OutputSettings) {}

    fn notify_at(&mut self, vblank: Vblank) {
        let current = self.current();
        let ahead = vblank.since(Vblank(current as u32));
        if self.is_asleep {
            return;
        }
        self.asked = Some(current.saturating_add_signed(i64::from(ahead)));
    }

    fn next_event(&mut self, timeout: Duration) -> Event {
        if std::mem::take(&mut self.turned) {
            return if self.is_asleep { Event::Asleep } else { Event::Back };
        }
        let Some(due) = self.due() else {
            pause(timeout);
            return Event::Idle;
        };
        match self.pace {
            Pace::Free => self.reached = self.reached.max(due),
            Pace::Timer => {
                let until = Duration::from_nanos(self.beat.begins(due).since((self.now)()));
                pause(until.min(timeout));
                if (self.now)() < self.beat.begins(due) {
                    return Event::Idle;
                }
            }
        }
        self.happen(due)
    }
}

/// Waits for `span`, an hour at most. An interrupted wait ends early: callers check the clock again.
fn pause(span: Duration) {
    let span = Timespec::try_from(span.min(Duration::from_hours(1))).expect("an hour fits a timespec");
    let _ = poll(&mut [], Some(&span));
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    thread_local!(static CLOCK: Cell<u64> = const { Cell::new(0) });

    /// A clock that a millisecond passes on at every reading.
    fn ticking() -> Nanos {
        CLOCK.with(|clock| Nanos(clock.replace(clock.get() + 1_000_000)))
    }

    fn hz(rate: u64) -> Rate {
        Rate::new(rate, 1).unwrap()
    }

    fn grey(luma: &[u8]) -> Picture<'_> {
        Picture { width: 4, height: 2, planes: [luma, &[128; 2], &[128; 2]], strides: [4, 2, 2] }
    }

    fn shown_luma(screen: &VirtualScreen) -> Option<u8> {
        screen.picture().map(|picture| picture.planes[0][0])
    }

    #[test]
    fn a_free_screen_jumps_to_the_vblank_asked_for() {
        let mut screen = VirtualScreen::new((4, 2), hz(50), Pace::Free, ticking);
        let at = |vblank: u32| Nanos(u64::from(vblank) * 20_000_000);
        screen.notify_at(Vblank(1_000_000));
        assert_eq!(screen.next_event(Duration::MAX), Event::Vblank { vblank: Vblank(1_000_000), at: at(1_000_000) });
        screen.stage(&grey(&[7; 8])).unwrap();
        screen.commit();
        assert_eq!(screen.next_event(Duration::MAX), Event::Flip { vblank: Vblank(1_000_001), at: at(1_000_001) });
        assert_eq!(screen.next_event(Duration::ZERO), Event::Idle);
    }

    #[test]
    fn a_timed_screen_flips_once_a_period() {
        let mut screen = VirtualScreen::new((4, 2), hz(50), Pace::Timer, ticking);
        let mut flips = Vec::new();
        for luma in 0..4 {
            screen.stage(&grey(&[luma; 8])).unwrap();
            screen.commit();
            loop {
                let event = screen.next_event(Duration::ZERO);
                if let Event::Flip { vblank, .. } = event {
                    break flips.push(vblank.0);
                }
                assert_eq!(event, Event::Idle);
            }
            assert_eq!(shown_luma(&screen), Some(luma));
        }
        assert_eq!(flips, [1, 2, 3, 4]);
    }

    #[test]
    fn a_picture_is_readable_from_its_flip_on() {
        let mut screen = VirtualScreen::new((4, 2), hz(60), Pace::Free, ticking);
        screen.stage(&grey(&[1; 8])).unwrap();
        screen.stage(&grey(&[2; 8])).unwrap();
        screen.commit();
        assert_eq!(shown_luma(&screen), None);
        screen.next_event(Duration::ZERO);
        screen.stage(&grey(&[3; 8])).unwrap();
        assert_eq!(shown_luma(&screen), Some(2));
    }

    #[test]
    fn a_commit_before_its_predecessors_flip_is_ignored() {
        let mut screen = VirtualScreen::new((4, 2), hz(60), Pace::Free, ticking);
        screen.stage(&grey(&[1; 8])).unwrap();
        screen.commit();
        screen.stage(&grey(&[2; 8])).unwrap();
        screen.commit();
        assert!(matches!(screen.next_event(Duration::ZERO), Event::Flip { .. }));
        assert_eq!(shown_luma(&screen), Some(1));
        screen.commit();
        screen.next_event(Duration::ZERO);
        assert_eq!(shown_luma(&screen), Some(2));
    }

    #[test]
    fn a_screen_that_sleeps_shows_nothing_new_until_it_is_woken() {
        for pace in [Pace::Free, Pace::Timer] {
            let mut screen = VirtualScreen::new((4, 2), hz(60), pace, ticking);
            screen.stage(&grey(&[1; 8])).unwrap();
            screen.commit();
            screen.set_light(Light::Off);
            assert_eq!((screen.next_event(Duration::ZERO), screen.info()), (Event::Asleep, None));
            screen.stage(&grey(&[2; 8])).unwrap();
            screen.commit();
            screen.notify_at(Vblank(7));
            assert_eq!(screen.next_event(Duration::ZERO), Event::Idle);
            screen.set_light(Light::FULL);
            assert_eq!(screen.next_event(Duration::ZERO), Event::Back);
            screen.stage(&grey(&[3; 8])).unwrap();
            screen.commit();
            while !matches!(screen.next_event(Duration::ZERO), Event::Flip { .. }) {}
            assert_eq!(shown_luma(&screen), Some(3));
        }
    }

    #[test]
    fn a_picture_that_does_not_fit_is_refused_and_the_lit_one_stays() {
        let mut screen = VirtualScreen::new((4, 2), hz(60), Pace::Free, ticking);
        screen.stage(&grey(&[1; 8])).unwrap();
        screen.commit();
        screen.next_event(Duration::ZERO);
        for (width, height) in [(0, 2), (3, 2), (6, 2), (4, 4)] {
            let wrong = Picture { width, height, ..grey(&[9; 8]) };
            assert!(matches!(screen.stage(&wrong), Err(ScreenError::Size { .. })), "{width}x{height}");
        }
        assert_eq!(shown_luma(&screen), Some(1));
    }
}

//! When something fails: the watchdog, and the rungs of the ladder.
//!
//! Owns the deeds; `ladder.rs` decides which. Keeps two rules at every failure: a framebuffer that a plane may show
//! is not removed before the CRTC is off, and nothing is tried again without a pause.

use super::card::{Happening, How, Kms, Source};
use super::ladder::{self, Rung, Trouble};
use super::{Flight, KmsScreen, Output, Painted, Phase};
use crate::Event;
use std::io;
use std::time::Duration;
use timing::{Nanos, Vblank};

impl<K: Kms> KmsScreen<K> {
    /// The kernel did not take a flip.
    pub(super) fn flip_failed(&mut self, error: &io::Error, deadline: Nanos) {
        let (now, period) = (self.now(), self.period());
        let Phase::Up(output) = &mut self.phase else { return };
        let rung = ladder::flip_failed(Trouble::of(error), now >= deadline, output.failed_in_a_row);
        if rung == Rung::Again {
            output.flight = Flight::Retrying { next: now.after(period.as_nanos() as u64), deadline };
        } else {
            self.climb(rung, &format!("a flip failed: {error}"));
        }
    }

    /// A flip's event did not come.
    pub(super) fn overdue(&mut self, from: Option<Vblank>) {
        if self.has_come() {
            return;
        }
        let now = self.now();
        let Phase::Up(output) = &mut self.phase else { return };
        let pending = output.ring.pending().map(|painted| painted.buffer.source);
        let current = output.vblank(&mut self.kms, now).ok().map(|(vblank, _)| vblank);
        let moved = from.zip(current).is_some_and(|(from, current)| current.since(from) > 0);
        let plane = self.kms.plane_properties(output.plan.way.plane).ok();
        let shown = plane.as_ref().and_then(Source::of);
        match ladder::flip_overdue(moved, pending.is_some() && shown == pending, output.failed_in_a_row) {
            None => {
                output.ring.presume_flipped();
                output.flight = Flight::Landed;
                output.gave_up_at = current.filter(|_| output.beat.is_none());
                output.failed_in_a_row += 1;
                let reason = "a flip event was lost; the picture is on the glass".to_owned();
                self.notices.push_back(Event::Recovered { reason });
            }
            Some(rung) => self.climb(rung, "a flip did not come"),
        }
    }

    /// Whether an event lay waiting while we were late ourselves; it has been dealt with.
    fn has_come(&mut self) -> bool {
        let waiting = self.kms.wait(Duration::ZERO).ok().flatten();
        waiting.is_some_and(|happening| {
            self.happened(happening);
            true
        })
    }

    /// A vblank event did not come.
    pub(super) fn vblank_overdue(&mut self) {
        if self.has_come() {
            return;
        }
        let now = self.now();
        let Phase::Up(output) = &mut self.phase else { return };
        let Some(asked) = output.asked.take_if(|asked| asked.deadline <= now) else { return };
        let event = match output.vblank(&mut self.kms, now) {
            Ok((vblank, at)) if vblank.since(asked.vblank) >= 0 => Event::Vblank { vblank, at },
            Ok(_) => Event::Recovered { reason: "vblanks stand still; the picture stands".to_owned() },
            Err(error) => Event::Recovered { reason: format!("a vblank event was lost: {error}") },
        };
        self.notices.push_back(event);
    }

    /// The card's descriptor failed.
    pub(super) fn card_failed(&mut self, error: &io::Error) {
        let reason = format!("{} is gone: {error}", self.kms.name());
        self.climb(Rung::AwaitCard, &reason);
    }

    /// Takes a rung of the ladder.
    pub(super) fn climb(&mut self, rung: Rung, reason: &str) {
        let now = self.now();
        match rung {
            Rung::Again | Rung::Relight => {
                if let Phase::Up(output) = &mut self.phase {
                    output.flight = Flight::Lighting { next: now, since: now };
                }
            }
            Rung::OtherWay => {
                if let Phase::Up(output) = &self.phase {
                    self.refused.push(output.plan.way);
                }
                self.leave(reason);
            }
            Rung::Reopen | Rung::AwaitCard => self.go_dark(reason.to_owned(), false),
            Rung::AwaitMaster => {
                let reason = format!("another process is master of {}", self.kms.name());
                self.go_dark(reason, false);
            }
        }
    }

    /// Gives the output up in good order: CRTC off, then buffers freed. The card stays open.
    pub(super) fn leave(&mut self, reason: &str) {
        self.go_dark(reason.to_owned(), true);
    }

    /// Nothing is lit from here on. `tidy`: the CRTC is switched off and the buffers are freed one by one; if that
    /// fails, or is not to be tried, closing the card frees them all.
    fn go_dark(&mut self, reason: String, tidy: bool) {
        let pause = if self.tries == 0 { Duration::ZERO } else { ladder::pause(self.tries) };
        let now = self.now();
        let retry = now.after(pause.as_nanos() as u64).max(self.cable.goes_dark(now));
        if matches!(self.phase, Phase::Asleep) {
            // It sleeps on, and whoever wakes it opens the card.
            return self.close();
        }
        self.forget_coming();
        let phase = std::mem::replace(&mut self.phase, Phase::Dark { retry });
        let tidied = match phase {
            Phase::Up(output) => tidy && self.tidy(*output),
            Phase::Asleep | Phase::Dark { .. } => tidy,
        };
        if !tidied {
            self.close();
        }
        self.tries = self.tries.saturating_add(1);
        self.notices.push_back(Event::Lost { reason });
    }

    /// Lets somebody else have the display, at another console.
    pub(super) fn leave_console(&mut self) {
        self.is_elsewhere = true;
        self.go_dark("somebody looks at another console".to_owned(), false);
        self.kms.let_console_go();
    }

    /// Has the display again.
    pub(super) fn return_to_console(&mut self) {
        self.is_elsewhere = false;
        self.tries = 0;
        if let Phase::Dark { retry } = &mut self.phase {
            *retry = (self.settings.now)();
        }
    }

    /// Frees an output; false if the CRTC could not be switched off.
    pub(super) fn tidy(&mut self, output: Output) -> bool {
        if output.lit
            && let Err(error) = self.kms.commit(How::Modeset, output.plan.darken())
        {
            tracing::debug!(%error, "cannot switch the CRTC off, closing the card");
            return false;
        }
        free(&mut self.kms, output);
        self.drop_stale_flips();
        true
    }

    /// Takes the events that belong to commits that are over; others are kept in mind.
    pub(super) fn drop_stale_flips(&mut self) {
        while let Ok(Some(happening)) = self.kms.wait(Duration::ZERO) {
            if !matches!(happening, Happening::Flip { .. }) {
                self.happened(happening);
            }
        }
    }
}

/// Frees an output that no plane shows.
pub(super) fn free(kms: &mut impl Kms, output: Output) {
    destroy(kms, output.ring.into_buffers());
    kms.destroy_blob(output.mode);
    output.dimming.free(kms);
}

/// Frees buffers that no plane shows, with their framebuffers.
pub(super) fn destroy(kms: &mut impl Kms, mut buffers: Vec<Painted>) {
    // Buffers of one framebuffer lie side by side.
    buffers.dedup_by_key(|painted| painted.buffer.source.fb);
    for painted in buffers {
        kms.destroy(painted.buffer.source.fb);
    }
}

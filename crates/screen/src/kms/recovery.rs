//! The watchdog, and the recovery steps.
//!
//! Executes the steps that `recovery_policy.rs` chooses, by two rules: a framebuffer that a plane may show is not
//! removed before the CRTC is off, and nothing is retried without a pause.

use super::card::{CommitMode, Kms, KmsEvent, Source};
use super::recovery_policy::{self, CommitError, RecoveryStep};
use super::{CommitState, FilledBuffer, KmsScreen, Output, Phase};
use crate::Event;
use std::io;
use std::time::Duration;
use timing::{Nanos, Vblank};

impl<K: Kms> KmsScreen<K> {
    /// The kernel did not take a flip.
    pub(super) fn flip_failed(&mut self, error: &io::Error, deadline: Nanos) {
        let (now, period) = (self.now(), self.period());
        let Phase::Up(output) = &mut self.phase else { return };
        let step = recovery_policy::flip_failed(CommitError::of(error), now >= deadline, output.failed_in_a_row);
        if step == RecoveryStep::Again {
            output.flight = CommitState::Retrying { next: now.after(period.as_nanos() as u64), deadline };
        } else {
            self.recover(step, &format!("a page flip failed: {error}"));
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
        match recovery_policy::flip_overdue(moved, pending.is_some() && shown == pending, output.failed_in_a_row) {
            None => {
                output.ring.presume_flipped();
                output.flight = CommitState::Landed;
                output.gave_up_at = current.filter(|_| output.own_vblanks.is_none());
                output.failed_in_a_row += 1;
                let reason = "a page flip event was lost; the picture is on the screen".to_owned();
                self.notices.push_back(Event::Recovered { reason });
            }
            Some(step) => self.recover(step, "a page flip did not complete"),
        }
    }

    /// Whether the event was already waiting while this process was late; it is handled.
    fn has_come(&mut self) -> bool {
        let waiting = self.kms.wait(Duration::ZERO).ok().flatten();
        waiting.is_some_and(|happening| {
            self.on_event(happening);
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
            Ok(_) => Event::Recovered { reason: "the vblank counter has stopped; the picture stays".to_owned() },
            Err(error) => Event::Recovered { reason: format!("a vblank event was lost: {error}") },
        };
        self.notices.push_back(event);
    }

    /// The card's descriptor failed.
    pub(super) fn card_failed(&mut self, error: &io::Error) {
        let reason = format!("{} is gone: {error}", self.kms.name());
        self.recover(RecoveryStep::AwaitCard, &reason);
    }

    /// Executes a recovery step.
    pub(super) fn recover(&mut self, step: RecoveryStep, reason: &str) {
        let now = self.now();
        match step {
            RecoveryStep::Again | RecoveryStep::Relight => {
                if let Phase::Up(output) = &mut self.phase {
                    output.flight = CommitState::Lighting { next: now, since: now };
                }
            }
            RecoveryStep::OtherWay => {
                if let Phase::Up(output) = &self.phase {
                    self.refused.push(output.plan.way);
                }
                self.leave(reason);
            }
            RecoveryStep::Reopen | RecoveryStep::AwaitCard => self.go_dark(reason.to_owned(), false),
            RecoveryStep::AwaitMaster => {
                let reason = format!("another process is DRM master of {}", self.kms.name());
                self.go_dark(reason, false);
            }
        }
    }

    /// Closes the output: switches the CRTC off, then frees the buffers. The card stays open.
    pub(super) fn leave(&mut self, reason: &str) {
        self.go_dark(reason.to_owned(), true);
    }

    /// Goes dark. With `tidy` the CRTC is switched off and the buffers are freed one by one; without, or if that fails,
    /// the card is closed, which frees them all.
    fn go_dark(&mut self, reason: String, tidy: bool) {
        let pause = if self.tries == 0 { Duration::ZERO } else { recovery_policy::pause(self.tries) };
        let now = self.now();
        let retry = now.after(pause.as_nanos() as u64).max(self.cable.on_dark(now));
        if matches!(self.phase, Phase::Asleep) {
            // It stays asleep; waking it opens the card.
            return self.close();
        }
        self.drop_prepared();
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

    /// Releases the display for another console.
    pub(super) fn leave_console(&mut self) {
        self.is_elsewhere = true;
        self.go_dark("another console is active".to_owned(), false);
        self.kms.release_console();
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
            && let Err(error) = self.kms.commit(CommitMode::Modeset, output.plan.darken())
        {
            tracing::debug!(%error, "cannot switch the CRTC off, closing the card");
            return false;
        }
        free(&mut self.kms, output);
        self.drop_stale_flips();
        true
    }

    /// Drops the events of commits that are over; other events are kept.
    pub(super) fn drop_stale_flips(&mut self) {
        while let Ok(Some(happening)) = self.kms.wait(Duration::ZERO) {
            if !matches!(happening, KmsEvent::Flip { .. }) {
                self.on_event(happening);
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
pub(super) fn destroy(kms: &mut impl Kms, mut buffers: Vec<FilledBuffer>) {
    // Buffers of one framebuffer lie side by side.
    buffers.dedup_by_key(|painted| painted.buffer.source.fb);
    for painted in buffers {
        kms.destroy(painted.buffer.source.fb);
    }
}

//! Light: the commits that bring a picture to the display, and the night.
//!
//! Owns how dimming goes with lighting and with flips: a card that refuses that is lit without. A display that is to sleep is
//! switched off in good order and its buffers are freed; woken, it is brought up as one that was plugged in. Never decides
//! when: whoever calls `set_light` does. How a display is dimmed is in `dimming.rs`.
//!
//! Start at [`flip`] and [`lit`].

use super::card::{How, Id, Kms, Request, Source};
use super::dimming::Dimmer;
use super::ladder::Trouble;
use super::plan::Plan;
use super::{KmsScreen, Output, Phase};
use crate::{Event, Light};
use rustix::io::Errno;
use std::io;

impl<K: Kms> KmsScreen<K> {
    /// Goes by the light that was told.
    pub(super) fn dim(&mut self) {
        if let (Phase::Up(output), Light::On { .. }) = (&mut self.phase, self.light) {
            for output in [output].into_iter().chain(&mut self.coming) {
                output.dimming.renew(&mut self.kms, &output.plan, self.light);
            }
        }
    }

    /// Switches the display off and frees its buffers. The card stays ours, so that nobody lights it with words.
    pub(super) fn sleep(&mut self) {
        self.forget_coming();
        let up = match std::mem::replace(&mut self.phase, Phase::Asleep) {
            Phase::Up(output) => Some(output),
            Phase::Asleep | Phase::Dark { .. } => None,
        };
        if let Some(mut output) = up.or_else(|| self.leaving.take()) {
            // What the boot left there goes, too.
            output.lit = true;
            if !self.tidy(*output) {
                self.close();
            }
        }
        self.retire();
        self.notices.push_back(Event::Asleep);
    }

    /// Lights the display again.
    pub(super) fn rise(&mut self) {
        self.tries = 0;
        self.phase = Phase::Dark { retry: self.now() };
        self.attempt();
    }
}

/// Hands `source` to the kernel, as bright as it is to be.
pub(super) fn flip(kms: &mut impl Kms, output: &mut Output, source: Source) -> io::Result<()> {
    let bare = output.plan.flip(source);
    let Some((dimmer, blob)) = output.dimming.news(&output.plan) else { return kms.commit(How::Flip, &bare) };
    let mut dimmed = bare.clone();
    dimmer.set(&mut dimmed, blob);
    let outcome = kms.commit(How::Flip, &dimmed);
    if is_refused(&outcome) {
        output.dimming.is_refused(kms);
        return kms.commit(How::Flip, &bare);
    }
    if outcome.is_ok() {
        output.dimming.is_taken();
    }
    outcome
}

/// Commits `source` with all its surroundings, as bright as it is to be.
pub(super) fn lit(kms: &mut impl Kms, output: &mut Output, source: Source, first: bool) -> io::Result<()> {
    let dimmed = output.dimming.lasting(&output.plan);
    let outcome = settled(kms, &output.plan, source, dimmed, first);
    let outcome = if dimmed.is_some() && is_refused(&outcome) {
        output.dimming.is_refused(kms);
        settled(kms, &output.plan, source, None, first)
    } else {
        outcome
    };
    if outcome.is_ok() {
        output.dimming.is_taken();
    }
    outcome
}

fn is_refused(outcome: &io::Result<()>) -> bool {
    outcome.as_ref().is_err_and(|error| Trouble::of(error) == Trouble::Refused)
}

/// Waits until `source` is on the glass. The `first` time it is tested before, and tried without setting the mode where
/// that is set already: then nothing flashes.
fn settled(
    kms: &mut impl Kms,
    plan: &Plan,
    source: Source,
    dimmed: Option<(Dimmer, Id)>,
    first: bool,
) -> io::Result<()> {
    let mut request: Request = plan.light(source);
    if let Some((dimmer, blob)) = dimmed {
        dimmer.set(&mut request, Some(blob));
    }
    if first {
        kms.commit(How::Test, &request)?;
    }
    let settled = if first && plan.same_mode { kms.commit(How::Settle, &request) } else { Err(Errno::INVAL.into()) };
    match settled {
        Err(error) if Trouble::of(&error) == Trouble::Refused => kms.commit(How::Modeset, &request),
        settled => settled,
    }
}

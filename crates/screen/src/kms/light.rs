//! The commits that light, dim and switch off a display.
//!
//! Adds dimming to modesets and flips; if the driver rejects it, they are repeated without. At night the CRTC is
//! switched off and its buffers are freed; in the morning the display is brought up like one that was plugged in. The
//! caller of `set_light` decides when. Methods of dimming are in `dimming.rs`.
//!
//! Start at [`flip`] and [`lit`].

use super::card::{CommitMode, Id, Kms, Request, Source};
use super::dimming::Dimmer;
use super::plan::Plan;
use super::recovery_policy::CommitError;
use super::{KmsScreen, Output, Phase};
use crate::{Event, Light};
use rustix::io::Errno;
use std::io;

impl<K: Kms> KmsScreen<K> {
    /// Applies the light that was set.
    pub(super) fn dim(&mut self) {
        if let (Phase::Up(output), Light::On { .. }) = (&mut self.phase, self.light) {
            for output in [output].into_iter().chain(&mut self.coming) {
                output.dimming.renew(&mut self.kms, &output.plan, self.light);
            }
        }
    }

    /// Switches the display off and frees its buffers. The card stays open, so that no text console appears.
    pub(super) fn sleep(&mut self) {
        self.drop_prepared();
        let up = match std::mem::replace(&mut self.phase, Phase::Asleep) {
            Phase::Up(output) => Some(output),
            Phase::Asleep | Phase::Dark { .. } => None,
        };
        if let Some(mut output) = up.or_else(|| self.leaving.take()) {
            // The picture of the boot goes, too.
            output.lit = true;
            if !self.tidy(*output) {
                self.close();
            }
        }
        self.free_previous();
        self.notices.push_back(Event::Asleep);
    }

    /// Lights the display again.
    pub(super) fn switch_on(&mut self) {
        self.tries = 0;
        self.phase = Phase::Dark { retry: self.now() };
        self.attempt();
    }
}

/// Commits `source` as a flip, with a change of brightness.
pub(super) fn flip(kms: &mut impl Kms, output: &mut Output, source: Source) -> io::Result<()> {
    let bare = output.plan.flip(source);
    let Some((dimmer, blob)) = output.dimming.pending_change(&output.plan) else {
        return kms.commit(CommitMode::Flip, &bare);
    };
    let mut dimmed = bare.clone();
    dimmer.set(&mut dimmed, blob);
    let outcome = kms.commit(CommitMode::Flip, &dimmed);
    if is_refused(&outcome) {
        output.dimming.is_refused(kms);
        return kms.commit(CommitMode::Flip, &bare);
    }
    if outcome.is_ok() {
        output.dimming.is_taken();
    }
    outcome
}

/// Commits `source` with all properties, and the brightness.
pub(super) fn lit(kms: &mut impl Kms, output: &mut Output, source: Source, first: bool) -> io::Result<()> {
    let dimmed = output.dimming.current_setting(&output.plan);
    let outcome = commit_blocking(kms, &output.plan, source, dimmed, first);
    let outcome = if dimmed.is_some() && is_refused(&outcome) {
        output.dimming.is_refused(kms);
        commit_blocking(kms, &output.plan, source, None, first)
    } else {
        outcome
    };
    if outcome.is_ok() {
        output.dimming.is_taken();
    }
    outcome
}

fn is_refused(outcome: &io::Result<()>) -> bool {
    outcome.as_ref().is_err_and(|error| CommitError::of(error) == CommitError::Refused)
}

/// A blocking commit of `source`. The `first` one is tested before, and tried without a modeset if the mode is set
/// already, so that the display does not flash.
fn commit_blocking(
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
        kms.commit(CommitMode::Test, &request)?;
    }
    let commit_blocking =
        if first && plan.same_mode { kms.commit(CommitMode::Settle, &request) } else { Err(Errno::INVAL.into()) };
    match commit_blocking {
        Err(error) if CommitError::of(&error) == CommitError::Refused => kms.commit(CommitMode::Modeset, &request),
        commit_blocking => commit_blocking,
    }
}

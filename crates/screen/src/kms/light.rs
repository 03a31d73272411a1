//! How bright the picture is, and the night.
//!
//! Owns the choice of means: the lamp behind the display where there is one, else a ramp that dims a CRTC, and how that goes
//! with lights and flips: a card that does not take it is lit without.
//! A display that is to sleep is switched off in good order and its buffers are freed; woken, it is brought up as one that
//! was plugged in. Never decides when: whoever calls `set_light` does.
//!
//! Start at [`Ramp`].

use super::card::{How, Id, Kms, Source};
use super::ladder::Trouble;
use super::plan::Plan;
use super::{KmsScreen, Output, Phase};
use crate::{Event, Light};
use rustix::io::Errno;
use std::io;

/// What becomes of the samples of one output.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Ramp {
    /// The kernel's copy; `None` for samples as they are.
    blob: Option<Id>,
    /// It goes with the next flip.
    is_news: bool,
    /// The card does not take it: it is not tried again.
    is_refused: bool,
    /// There is a lamp behind the display, which is dimmed instead.
    has_lamp: bool,
}

impl Ramp {
    /// The ramp for `light` on an output that is yet to be lit.
    pub(super) fn new(kms: &mut impl Kms, plan: &Plan, light: Light) -> Self {
        let mut ramp = Self { has_lamp: kms.find_lamp(&plan.connector), ..Self::default() };
        ramp.dim(kms, plan, light);
        ramp
    }

    /// Goes by `light`: with the lamp at once, else with the next flip.
    fn dim(&mut self, kms: &mut impl Kms, plan: &Plan, light: Light) {
        match light {
            Light::On { thousandths } if self.has_lamp => kms.shine(thousandths),
            Light::On { thousandths } => self.blob = drawn(kms, plan, thousandths),
            Light::Off => {}
        }
    }

    /// Another one, from the next flip on. What the old one was set by may go: the CRTC has its own.
    fn renew(&mut self, kms: &mut impl Kms, plan: &Plan, light: Light) {
        if self.is_refused {
            return;
        }
        self.free(kms);
        (self.blob, self.is_news) = (None, true);
        self.dim(kms, plan, light);
    }

    /// The card does not take it.
    fn refuse(&mut self, kms: &mut impl Kms) {
        tracing::warn!("this display cannot be dimmed");
        self.free(kms);
        (self.blob, self.is_news, self.is_refused) = (None, false, true);
    }

    pub(super) fn free(self, kms: &mut impl Kms) {
        if let Some(blob) = self.blob {
            kms.destroy_blob(blob);
        }
    }
}

/// The kernel's copy of the ramp for so many thousandths; `None` where none is needed, or can be had.
fn drawn(kms: &mut impl Kms, plan: &Plan, thousandths: u16) -> Option<Id> {
    let entries = plan.dimmer.filter(|_| thousandths < 1000)?.entries;
    let made = kms.create_ramp(&ramp(entries, thousandths));
    made.inspect_err(|error| tracing::debug!(%error, "cannot make a ramp")).ok()
}

/// So many thousandths of every sample, evenly from dark to bright.
fn ramp(entries: u16, thousandths: u16) -> Vec<[u16; 4]> {
    let brightest = u64::from(u16::MAX) * u64::from(thousandths.min(1000)) / 1000;
    let last = u64::from(entries.max(2)) - 1;
    let entry = |index: u64| (index * brightest / last) as u16;
    (0..=last).map(entry).map(|sample| [sample, sample, sample, 0]).collect()
}

impl<K: Kms> KmsScreen<K> {
    /// Goes by the light that was told.
    pub(super) fn dim(&mut self) {
        if let (Phase::Up(output), Light::On { .. }) = (&mut self.phase, self.light) {
            for output in [output].into_iter().chain(&mut self.coming) {
                output.ramp.renew(&mut self.kms, &output.plan, self.light);
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

/// Hands `source` to the kernel, as bright as it is to be. A card that does not take the ramp gets the picture without.
pub(super) fn flip(kms: &mut impl Kms, output: &mut Output, source: Source) -> io::Result<()> {
    let bare = output.plan.flip(source);
    let Some(dimmer) = output.plan.dimmer.filter(|_| output.ramp.is_news) else { return kms.commit(How::Flip, &bare) };
    let mut dimmed = bare.clone();
    dimmer.set(&mut dimmed, output.ramp.blob);
    let outcome = kms.commit(How::Flip, &dimmed);
    if is_refused(&outcome) {
        output.ramp.refuse(kms);
        return kms.commit(How::Flip, &bare);
    }
    output.ramp.is_news &= outcome.is_err();
    outcome
}

/// Commits `source` with all its surroundings, as bright as it is to be; without the ramp if the card refuses that.
pub(super) fn lit(kms: &mut impl Kms, output: &mut Output, source: Source, first: bool) -> io::Result<()> {
    let outcome = settled(kms, &output.plan, source, output.ramp.blob, first);
    let outcome = if output.ramp.blob.is_some() && is_refused(&outcome) {
        output.ramp.refuse(kms);
        settled(kms, &output.plan, source, None, first)
    } else {
        outcome
    };
    output.ramp.is_news &= outcome.is_err();
    outcome
}

fn is_refused(outcome: &io::Result<()>) -> bool {
    outcome.as_ref().is_err_and(|error| Trouble::of(error) == Trouble::Refused)
}

/// Waits until `source` is on the glass. The `first` time it is tested before, and tried without setting the mode where
/// that is set already: then nothing flashes.
fn settled(kms: &mut impl Kms, plan: &Plan, source: Source, ramp: Option<Id>, first: bool) -> io::Result<()> {
    let mut request = plan.light(source);
    if let (Some(dimmer), Some(_)) = (plan.dimmer, ramp) {
        dimmer.set(&mut request, ramp);
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

#[cfg(test)]
mod tests {
    use super::ramp;

    #[test]
    fn a_ramp_is_even_and_as_bright_as_it_is_told() {
        for (entries, thousandths) in [(2, 0), (2, 1000), (256, 500), (4096, 999), (u16::MAX, 1)] {
            let ramp = ramp(entries, thousandths);
            assert_eq!((ramp.len(), ramp[0]), (usize::from(entries), [0; 4]));
            let brightest = u32::from(u16::MAX) * u32::from(thousandths) / 1000;
            assert_eq!(u32::from(ramp.last().unwrap()[0]), brightest);
            let steps: Vec<_> = ramp.windows(2).map(|pair| pair[1][0] - pair[0][0]).collect();
            let (least, most) = (steps.iter().min().unwrap(), steps.iter().max().unwrap());
            assert!(most - least <= 1, "{entries} entries of {thousandths} thousandths");
            assert!(ramp.iter().all(|[red, green, blue, _]| red == green && green == blue), "no tint");
        }
    }
}

//! Brightness, hours and the owner's settings of the display, as the flip thread applies them.
//!
//! Owns the changes of the screen for them, how a notice stays bright on a dimmed display, and the night in black. Never decides them: `control/brightness.rs` does.

use super::{Event, FrameSource, Playback, Presenter, QUIET};
use crate::control::FULL;
use crate::pipeline::black_picture::Blackout;
use crate::pipeline::playback::Kept;
use crate::recording::Record;
use screen::{DimmedBy, Light, ScreenError};
use settings::hours::Lighting;
use std::sync::Arc;

/// By which power of a sample a display is bright.
const GAMMA: f64 = 2.2;

/// Why the screen shows no frames.
#[derive(Debug)]
pub(super) enum Absence {
    /// It is gone, or sleeps.
    Gone,
    /// It is black for the night.
    Night(Blackout),
}

/// How a brightness is made, in thousandths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Brightness {
    /// By the display.
    pub(super) display: u16,
    /// By the samples of the frames.
    pub(super) samples: u16,
}

impl Brightness {
    /// The same brightness of the frames on a display that is fully lit, if it can be dimmed at all.
    pub(super) fn of(thousandths: u16, dimmed_by: DimmedBy) -> Self {
        match dimmed_by {
            DimmedBy::Backlight => {
                let samples = (f64::from(thousandths) / f64::from(FULL)).powf(1.0 / GAMMA) * f64::from(FULL);
                Self { display: FULL, samples: samples.round() as u16 }
            }
            DimmedBy::Nothing => Self { display: thousandths, samples: FULL },
            DimmedBy::Samples => Self { display: FULL, samples: thousandths },
        }
    }
}

impl<F: FrameSource> Presenter<'_, F> {
    /// Feeds the watchdog while there is no screen, or a black one: that is no reason to restart the player.
    pub(super) fn stay_alive(&self, event: &screen::Event) {
        let is_away = matches!(self.playback, Playback::Away(Kept::Shown(..), _));
        if is_away && *event == screen::Event::Idle && self.handles.watchdog.is_some() {
            self.handles.recorder.record(Record::Alive);
        }
    }

    /// Tells the screen the brightness and the owner's settings, if they changed.
    pub(super) fn go_by_the_owner(&mut self) -> Result<Option<Event>, ScreenError> {
        let Some((lighting, output)) = self.handles.target.get() else { return Ok(None) };
        if self.output.as_ref().is_none_or(|known| !Arc::ptr_eq(known, &output)) {
            self.screen.set_output(&output);
            self.output = Some(output);
        }
        let night = if let Playback::Away(_, Absence::Night(black)) = &self.playback { Some(black) } else { None };
        if lighting == self.lighting || night.is_some_and(|black| !black.is_complete(&*self.screen)) {
            return Ok(None);
        }
        let was_black = night.is_some();
        self.lighting = lighting;
        match lighting {
            Lighting::Off => self.screen.set_light(Light::Off),
            Lighting::On { .. } => self.screen.set_light(Light::On { thousandths: self.brightness().display }),
            Lighting::Black => {
                // A display that sleeps has to wake first: then it goes black.
                let black = Blackout::begin(&mut *self.screen, self.format.size)?;
                return Ok(Some(self.lost(Absence::Night(black))));
            }
        }
        if !was_black {
            return Ok(None);
        }
        if lighting == Lighting::Off || self.screen.info().is_none() {
            return Ok(Some(Event::Lost(Absence::Gone)));
        }
        self.back();
        Ok(Some(Event::Back))
    }

    /// Has the display fully lit while there is a notice, so that its letters are as bright as ever, and the frames dimmed
    /// in its place. Both change with the next frame; a backlight may be a frame early.
    pub(super) fn lift(&mut self, has_notice: bool) {
        if has_notice == self.is_lifted {
            return;
        }
        let before = self.brightness().display;
        self.is_lifted = has_notice;
        let thousandths = self.brightness().display;
        if thousandths != before {
            self.screen.set_light(Light::On { thousandths });
        }
    }

    /// How the brightness of now is made.
    pub(super) fn brightness(&self) -> Brightness {
        let Lighting::On { thousandths } = self.lighting else { return Brightness::of(FULL, DimmedBy::Nothing) };
        let dimmed_by = self.glass.mode().map_or(DimmedBy::Nothing, |lit| lit.dimmed_by);
        if self.is_lifted {
            Brightness::of(thousandths, dimmed_by)
        } else {
            Brightness { display: thousandths, samples: FULL }
        }
    }

    /// Keeps the screen black until something happens.
    pub(super) fn stay_black(&mut self) -> Result<(), ScreenError> {
        let event = self.screen.next_event(QUIET);
        self.stay_alive(&event);
        if let Playback::Away(_, Absence::Night(black)) = &mut self.playback {
            black.on(&mut *self.screen, &event)?;
        }
        Ok(())
    }
}

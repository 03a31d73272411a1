//! Brightness, hours and the owner's settings of the display, as the flip thread applies them.
//!
//! Owns the changes of the screen for them, and the night in black. Never decides them: `control/brightness.rs` does.

use super::{FrameSource, Presenter, QUIET};
use crate::pipeline::black_picture::Blackout;
use crate::pipeline::playback::{Event, Playback};
use crate::recording::Record;
use player::hours::Lighting;
use screen::{Light, ScreenError};
use std::sync::Arc;

impl<F: FrameSource> Presenter<'_, F> {
    /// Feeds the watchdog while there is no screen, or a black one: that is no reason to restart the player.
    pub(super) fn stay_alive(&self, event: &screen::Event) {
        let is_away = matches!(self.playback, Playback::Away(_)) && *event == screen::Event::Idle;
        if is_away && self.fed.is_some() && self.handles.watchdog.is_some() {
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
        if lighting == self.lighting || self.blackout.as_ref().is_some_and(|black| !black.is_complete(&*self.screen)) {
            return Ok(None);
        }
        self.lighting = lighting;
        let was_black = self.blackout.take().is_some();
        match lighting {
            Lighting::Off => self.screen.set_light(Light::Off),
            Lighting::On { thousandths } => self.screen.set_light(Light::On { thousandths }),
            Lighting::Black => {
                // A display that sleeps has to wake first: then it goes black.
                self.blackout = Some(Blackout::begin(&mut *self.screen, self.format.size)?);
                self.handles.view.lit(None);
                self.asked = None;
                self.settle();
                return Ok(Some(Event::Lost));
            }
        }
        if was_black && lighting != Lighting::Off && self.screen.info().is_some() {
            self.back();
            return Ok(Some(Event::Back));
        }
        Ok(None)
    }

    /// Keeps the screen black until something happens.
    pub(super) fn stay_black(&mut self) -> Result<(), ScreenError> {
        let event = self.screen.next_event(QUIET);
        self.stay_alive(&event);
        self.blackout.as_mut().map_or(Ok(()), |blackout| blackout.on(&mut *self.screen, &event))
    }
}

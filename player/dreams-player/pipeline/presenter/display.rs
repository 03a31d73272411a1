//! What the hour and the owner want of the screen.
//!
//! Owns how the flip thread hears of it, and the night in black. Never decides what they want: `brightness.rs` does.

use super::{QUIET, Show, Supply};
use crate::pipeline::black_picture::Blackout;
use crate::pipeline::playback::{Event, Playback};
use crate::recording::recorder::Note;
use player::hours::Lighting;
use screen::{Light, ScreenError};
use std::sync::Arc;

impl<F: Supply> Show<'_, F> {
    /// Lets the watchdog know of us while there is no screen, or a black one: not a reason to be restarted.
    pub(super) fn stay_alive(&self, event: &screen::Event) {
        let is_away = matches!(self.playback, Playback::Away(_)) && *event == screen::Event::Idle;
        if is_away && self.fed.is_some() && self.ears.watchdog.is_some() {
            self.ears.scribe.note(Note::Alive);
        }
    }

    /// Tells the screen what its owner and the hour want, if that is news.
    pub(super) fn go_by_the_owner(&mut self) -> Result<Option<Event>, ScreenError> {
        let Some((lighting, output)) = self.ears.target.get() else { return Ok(None) };
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
                self.blackout = Some(Blackout::begin(&mut *self.screen, self.piece.size)?);
                self.ears.view.lit(None);
                self.asked = None;
                self.settle();
                return Ok(Some(Event::Lost));
            }
        }
        if was_black && lighting != Lighting::Off && self.screen.lit().is_some() {
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

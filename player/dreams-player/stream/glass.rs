//! What is on the glass, for anyone who wants to look.
//!
//! Owns the view that the flip thread shares with the status page. The flip thread never waits for it: while
//! someone copies the view, an update is left out, and the next flip brings it.

use crate::control::notice_pane::Placard;
use crate::recording::tally::Tally;
use crate::stream::scheduled_clip::{Shown, Turn};
use player::hours::Lighting;
use screen::{Lit, OutputSettings};
use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// How long the first picture may keep others waiting: beyond that there is no screen, and nothing to compete with.
const CURTAIN: Duration = Duration::from_millis(500);

/// What is on the glass; cheap to clone, the pixels are shared.
#[derive(Clone, Debug, Default)]
pub(crate) struct View {
    /// How the screen is lit; `None` while it is away.
    pub(crate) lit: Option<Arc<Lit>>,
    /// The picture.
    pub(crate) shown: Option<Shown>,
    /// The run so far.
    pub(crate) tally: Tally,
}

/// The shared view, and the turns that are planned.
#[derive(Debug, Default)]
pub(crate) struct Glass {
    view: Mutex<View>,
    plan: Mutex<VecDeque<Arc<Turn>>>,
    /// What people are told over the picture.
    placard: Mutex<Option<Arc<Placard>>>,
    /// What the hour wants; `None` before anybody said.
    lighting: Mutex<Option<Lighting>>,
    /// What the owner has set of the display; `None` before anybody said.
    output: Mutex<Option<Arc<OutputSettings>>>,
    /// Whether the first picture is on the glass, and word of it.
    is_open: Mutex<bool>,
    opened: Condvar,
}

impl Glass {
    /// Tells that the first picture is on the glass.
    pub(crate) fn open(&self) {
        *hold(&self.is_open) = true;
        self.opened.notify_all();
    }

    /// Waits until the first picture is on the glass, so as not to take the processor from it; not for ever.
    pub(crate) fn await_opening(&self) {
        let closed = self.opened.wait_timeout_while(hold(&self.is_open), CURTAIN, |is_open| !*is_open);
        drop(closed);
    }

    /// Tells people something over the picture from the next frame on, or nothing more.
    pub(crate) fn tell(&self, placard: Option<Arc<Placard>>) {
        *hold(&self.placard) = placard;
    }

    /// What people are told. It is held for the moment of a copy only.
    pub(crate) fn placard(&self) -> Option<Arc<Placard>> {
        hold(&self.placard).clone()
    }

    /// Has the display be as the hour wants it.
    pub(crate) fn set_lighting(&self, lighting: Lighting) {
        *hold(&self.lighting) = Some(lighting);
    }

    /// What the hour wants. It is held for the moment of a copy only.
    pub(crate) fn lighting(&self) -> Lighting {
        hold(&self.lighting).unwrap_or(Lighting::FULL)
    }

    /// Has the display go by what its owner has set.
    pub(crate) fn set_output(&self, output: &Arc<OutputSettings>) {
        *hold(&self.output) = Some(Arc::clone(output));
    }

    /// What the owner has set of the display. It is held for the moment of a copy only.
    pub(crate) fn output(&self) -> Option<Arc<OutputSettings>> {
        hold(&self.output).clone()
    }

    /// What people on site are to be told of the screen.
    pub(crate) fn notes(&self) -> Vec<String> {
        hold(&self.view).lit.as_ref().map_or_else(Vec::new, |lit| lit.notes.clone())
    }

    /// Shows what a flip brought, unless someone is looking at this very moment.
    pub(crate) fn flipped(&self, shown: &Shown, tally: Tally) {
        if let Ok(mut view) = self.view.try_lock() {
            (view.shown, view.tally) = (Some(shown.clone()), tally);
        }
    }

    /// Tells how the run goes while no flip does, unless someone is looking at this very moment.
    pub(crate) fn counted(&self, tally: Tally) {
        if let Ok(mut view) = self.view.try_lock() {
            view.tally = tally;
        }
    }

    /// Shows that the screen came or went. Rare enough to wait until nobody is looking.
    pub(crate) fn lit(&self, lit: Option<&Arc<Lit>>) {
        hold(&self.view).lit = lit.map(Arc::clone);
    }

    /// What is on the glass.
    pub(crate) fn view(&self) -> View {
        hold(&self.view).clone()
    }

    /// The size of the picture on the glass.
    pub(crate) fn size(&self) -> Option<(u32, u32)> {
        let view = hold(&self.view);
        view.shown.as_ref().map(|shown| shown.still.picture()).map(|picture| (picture.width, picture.height))
    }

    /// Adds a turn to the plan, and forgets those that are over.
    pub(crate) fn plan(&self, turn: Arc<Turn>) {
        let on_glass = hold(&self.view).shown.as_ref().and_then(|shown| Some(shown.turn.as_ref()?.number));
        let mut plan = hold(&self.plan);
        plan.retain(|turn| Some(turn.number) > on_glass);
        plan.push_back(turn);
    }

    /// Strikes a turn from the plan that ended without a picture.
    pub(crate) fn pass(&self, number: u64) {
        hold(&self.plan).retain(|turn| turn.number != number);
    }

    /// The turn that follows turn `number`, if it is planned.
    pub(crate) fn after(&self, number: u64) -> Option<Arc<Turn>> {
        hold(&self.plan).iter().find(|turn| turn.number > number).map(Arc::clone)
    }
}

fn hold<T>(lock: &Mutex<T>) -> MutexGuard<'_, T> {
    lock.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::Glass;
    use crate::stream::scheduled_clip::tests::turns;

    #[test]
    fn a_turn_that_ended_without_a_picture_is_not_planned_any_more() {
        let glass = Glass::default();
        for turn in turns(3, 2) {
            glass.plan(turn);
        }
        glass.pass(2);
        assert_eq!(glass.after(1).map(|turn| turn.number), Some(3));
        glass.pass(3);
        assert!(glass.after(1).is_none());
    }
}

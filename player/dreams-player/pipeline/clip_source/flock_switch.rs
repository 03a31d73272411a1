//! How the path goes over from one flock to another.
//!
//! Owns when that happens: at a join, at the same sheep if both flocks have it; it waits for such a join, but not for
//! ever. The walk's memory is carried over (`flock::Itinerary`), so that the path goes on. A flock of another size or
//! rate is decoded by a new session; `presenter.rs` fits the screen to it.
//!
//! Start at [`ClipSource::change`].

use super::{ClipSource, Strikes};
use crate::stream::{Generation, path};
use diagnostics::chain;
use flock::{ClipKind, Flock, Itinerary, Leg, Place, SheepId};
use std::sync::Arc;
use tracing::{info, warn};

/// How many joins are waited for one at a sheep that the new flock has, too.
const PATIENCE: u32 = 64;

/// The flock that is to be played instead.
#[derive(Debug, Default)]
pub(crate) struct Successor {
    generation: Option<Generation>,
    /// Joins that were let pass.
    waited: u32,
    /// The last place of the path, from where to go on when there is no next one.
    place: Option<Place>,
    /// That it cannot be read was logged.
    is_told: bool,
}

impl ClipSource {
    /// Goes over to the flock that is to be played by now, if there is another and `leg`, the next one, begins where that
    /// can be. Whether it did: another leg is to be drawn then.
    pub(super) fn change(&mut self, leg: &Leg) -> bool {
        self.successor.place = Some(leg.place.clone());
        let Some(next) = self.next_generation() else { return false };
        let here = match &leg.clip.what {
            ClipKind::Loop { sheep } => sheep,
            ClipKind::Transition { from, .. } => from,
        };
        if !has(&next, here) && shares_a_sheep(&next, &self.generation.flock) && self.successor.waited < PATIENCE {
            self.successor.waited += 1;
            self.successor.generation = Some(next);
            return false;
        }
        self.go_over(next, Some(&leg.place))
    }

    /// Changes to the flock that is to be played by now, or to the one that stands in, when nothing of the one at hand
    /// can be played. Whether there was another one.
    pub(super) fn change_from_nothing(&mut self) -> bool {
        let Some(next) = self.next_generation().or_else(|| self.standing_in()) else { return false };
        let place = self.successor.place.take();
        self.go_over(next, place.as_ref())
    }

    /// The flock that is to be played by now instead of the one at hand, if there is another.
    fn next_generation(&mut self) -> Option<Generation> {
        if self.generation.is_over((self.now)()) {
            return self.awaited();
        }
        if self.generation.is_withdrawn() {
            return self.successor.generation.take().or_else(|| self.standing_in());
        }
        self.successor = Successor { place: self.successor.place.take(), ..Successor::default() };
        None
    }

    fn standing_in(&self) -> Option<Generation> {
        self.generation.standing_in(&self.source, &self.spare, (self.now)())
    }

    /// The flock that is to be played by now, opened.
    fn awaited(&mut self) -> Option<Generation> {
        if let Some(known) = self.successor.generation.take().filter(|known| !known.is_over((self.now)())) {
            return Some(known);
        }
        let is_told = self.successor.is_told;
        self.successor.is_told = true;
        match Generation::open(&self.source) {
            Ok(next) if self.generation.is_to_be_rendered(&next) => {
                if !is_told {
                    warn!(
                        "the manifest has another size or rate, the flock goes on as it was until the player starts anew"
                    );
                }
                None
            }
            Ok(next) => {
                self.successor.is_told = false;
                Some(next)
            }
            Err(error) => {
                if !is_told {
                    warn!(error = chain(&error), "cannot read the new flock, the current one goes on");
                }
                None
            }
        }
    }

    fn go_over(&mut self, mut next: Generation, place: Option<&Place>) -> bool {
        if !next.begin() {
            return false;
        }
        if self.view.get().lit.is_none()
            && let Some(trial) = &next.trial
        {
            trial.excused();
        }
        let flock = Arc::clone(&next.flock);
        let carried = place.map(|place| Itinerary::resume(Arc::clone(&flock), place));
        self.itinerary = match carried {
            Some(Ok(itinerary)) => itinerary,
            // Nothing is shared: another path, of the same seed.
            Some(Err(_)) | None => path(&flock, None, place.map(Place::seed)),
        };
        info!(flock = flock.manifest().name, "switched to another flock");
        self.faults.renew();
        self.generation = next;
        self.strikes = Strikes::default();
        self.successor = Successor::default();
        let form = self.generation.form();
        self.is_reformed |= form != self.form;
        self.form = form;
        true
    }
}

/// Whether the sheep is among those that are played.
fn has(next: &Generation, sheep: &SheepId) -> bool {
    next.flock.graph().find(sheep).is_some()
}

fn shares_a_sheep(next: &Generation, old: &Flock) -> bool {
    old.graph().sheep().any(|sheep| has(next, old.id(sheep)))
}

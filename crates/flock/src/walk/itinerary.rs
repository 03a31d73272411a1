//! The clips of a walk, one after another: what the player drives.
//!
//! Owns the order of clips: a visit's loops, then a transition, then the next visit's loops. Goes around clips that
//! were struck, never into a dead end if there is another way. Never opens a clip.
//!
//! Start at [`Itinerary::next_leg`].

use std::sync::Arc;

use timing::FrameCount;

use super::Walk;
use super::carry::carried;
use super::closed::Closed;
use super::memory::{Keys, Next, Place, PlaceError};
use crate::flock::Flock;
use crate::graph::SheepIx;
use crate::manifest::{Clip, ClipHash, ClipPath, SheepId};

/// The endless path of one unit through its flock.
#[derive(Clone, Debug)]
pub struct Itinerary {
    flock: Arc<Flock>,
    keys: Arc<Keys>,
    /// `None` only where the flock has nothing to show.
    walk: Option<Walk>,
    next: Next,
    closed: Closed,
    /// The last leg handed out, to go back to if its clip is struck.
    issued: Option<(ClipPath, Place)>,
}

/// A clip to be shown next.
#[derive(Clone, Debug)]
pub struct Leg {
    /// The clip.
    pub clip: ClipRef,
    /// The place from which this leg comes first, and then everything as it does now. Save it when the leg's first
    /// frame is on the glass: a power cut then repeats at most this clip.
    pub place: Place,
}

/// A clip as the player needs it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ClipRef {
    /// Where it lies.
    pub path: ClipPath,
    /// How many frames it has.
    pub frames: FrameCount,
    /// What its bytes hash to, where the tools have written it.
    pub hash: Option<ClipHash>,
    /// What it shows.
    pub what: What,
}

/// What a clip shows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum What {
    /// A sheep, once around.
    Loop {
        /// Which.
        sheep: SheepId,
    },
    /// The way from one sheep to another.
    Transition {
        /// Where it starts.
        from: SheepId,
        /// Where it ends.
        to: SheepId,
    },
}

/// How often a sheep has been visited, against how often it should.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Showing {
    /// Which.
    pub id: SheepId,
    /// Visits so far, of the whole path.
    pub visits: u64,
    /// The fraction of visits that it gets in the long run.
    pub share: f64,
}

impl Itinerary {
    /// The path that begins with `seed`.
    pub fn start(flock: Arc<Flock>, seed: u64) -> Self {
        let keys = Arc::new(Keys::of(&flock));
        let walk = Walk::start(Arc::clone(&flock), seed);
        Self { flock, keys, walk, next: Next::Visit { played: 0 }, closed: Closed::default(), issued: None }
    }

    /// The path that goes on at `place`. On another flock than the place's it is carried over by the ids of sheep.
    ///
    /// # Errors
    /// [`PlaceError::Foreign`] if `flock` has none of the place's sheep.
    pub fn resume(flock: Arc<Flock>, place: &Place) -> Result<Self, PlaceError> {
        let keys = Arc::new(Keys::of(&flock));
        let Place { memory, next, .. } = carried(place, &flock, &keys)?;
        let walk = Some(Walk::with(Arc::clone(&flock), (*memory).clone()));
        Ok(Self { flock, keys, walk, next, closed: Closed::default(), issued: None })
    }

    /// The next clip and its place. `None` if nothing can be shown.
    pub fn next_leg(&mut self) -> Option<Leg> {
        let place = self.place()?;
        let Some(clip) = self.next_clip() else {
            // Nothing was handed out: the path stands where it stood.
            self.next = place.next;
            return None;
        };
        self.issued = Some((clip.path.clone(), place.clone()));
        Some(Leg { clip, place })
    }

    /// The next clip, for those who never come back to it. `None` if nothing can be shown.
    pub fn next_clip(&mut self) -> Option<ClipRef> {
        self.issued = None;
        let walk = self.walk.as_mut()?;
        let here = walk.place();
        if let Next::Visit { played } = self.next {
            if played < self.flock.sheep(here).repeat
                && let Some(clip) = open_loop(&self.flock, &self.closed, here)
            {
                self.next = Next::Visit { played: played + 1 };
                return Some(clip);
            }
            self.next = Next::Leave;
        }
        let Some(step) = walk.step_around(&self.closed) else {
            // No exit is left: the loop once more.
            return open_loop(&self.flock, &self.closed, here);
        };
        self.next = Next::Visit { played: 0 };
        let (from, to) = (self.flock.id(step.from).clone(), self.flock.id(step.to).clone());
        Some(clip_ref(&self.flock.transition(step.exit).clip, What::Transition { from, to }))
    }

    /// Takes `clip` out of the path until the next start, because it turned out bad. If it is the clip of the last
    /// leg handed out, the path goes back to before that leg, and the next leg is the one instead of it.
    pub fn strike(&mut self, clip: &ClipPath) {
        self.closed.strike(&self.flock, clip);
        if let Some((_, place)) = self.issued.take_if(|(issued, _)| issued == clip) {
            self.next = place.next;
            self.walk = Some(Walk::with(Arc::clone(&self.flock), (*place.memory).clone()));
        }
    }

    /// Gives every struck clip another chance: the path goes on where it stands, with all of its clips.
    pub fn forgive(&mut self) {
        self.closed = Closed::default();
    }

    /// Whether some way leads on from the sheep that is visited now, around what was struck. Where none does, its loop
    /// plays for ever.
    pub fn leads_on(&self) -> bool {
        let mut ways = self.walk.iter().flat_map(|walk| self.flock.graph().exits(walk.place()));
        ways.any(|exit| self.closed.is_open(exit))
    }

    /// The flock of the path.
    pub fn flock(&self) -> &Arc<Flock> {
        &self.flock
    }

    /// Steps taken since the path began.
    pub fn steps(&self) -> u64 {
        self.walk.as_ref().map_or(0, Walk::steps)
    }

    /// Visits and shares of every sheep that is played, in the order of their ids.
    pub fn showings(&self) -> Vec<Showing> {
        let Some(walk) = &self.walk else { return Vec::new() };
        let showing = |sheep| Showing {
            id: self.flock.id(sheep).clone(),
            visits: walk.visits(sheep),
            share: self.flock.share(sheep),
        };
        self.flock.graph().sheep().map(showing).collect()
    }

    fn place(&self) -> Option<Place> {
        let memory = Arc::new(self.walk.as_ref()?.memory().clone());
        Some(Place { keys: Arc::clone(&self.keys), memory, next: self.next })
    }
}

fn open_loop(flock: &Flock, closed: &Closed, sheep: SheepIx) -> Option<ClipRef> {
    let clip = flock.loop_of(sheep).filter(|_| closed.shows_loop(sheep))?;
    Some(clip_ref(clip, What::Loop { sheep: flock.id(sheep).clone() }))
}

fn clip_ref(clip: &Clip, what: What) -> ClipRef {
    ClipRef { path: clip.path.clone(), frames: clip.frames, hash: clip.hash, what }
}

#[cfg(test)]
mod tests;

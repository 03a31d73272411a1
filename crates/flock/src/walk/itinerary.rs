//! The sequence of clips of a walk, which the player plays.
//!
//! Owns the order of clips: a visit's loops, then a transition, then the next visit's loops. Avoids blocked clips, and
//! dead ends if there is an alternative. Clips are not opened.
//!
//! Start at [`Itinerary::next_leg`].

use std::sync::Arc;

use timing::FrameCount;

use super::Walk;
use super::blocked::BlockedClips;
use super::carry_over::carry_over;
use super::memory::{Keys, Next, Place, PlaceError};
use crate::flock::Flock;
use crate::graph::SheepIx;
use crate::manifest::{Clip, ClipHash, ClipPath, SheepId};

/// The endless path of one unit through its flock.
#[derive(Clone, Debug)]
pub struct Itinerary {
    flock: Arc<Flock>,
    keys: Arc<Keys>,
    /// `None` only if the flock has nothing to show.
    walk: Option<Walk>,
    next: Next,
    blocked: BlockedClips,
    /// The last leg returned, to go back to if its clip is blocked.
    issued: Option<(ClipPath, Place)>,
}

/// A clip to be shown next.
#[derive(Clone, Debug)]
pub struct Leg {
    /// The clip.
    pub clip: ClipRef,
    /// The place that resumes with this leg. Save it when the leg's first frame is shown: a power cut then repeats at
    /// most this clip.
    pub place: Place,
}

/// A clip as the player needs it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ClipRef {
    /// Where it lies.
    pub path: ClipPath,
    /// How many frames it has.
    pub frames: FrameCount,
    /// The hash of its bytes, if the tools have written it.
    pub hash: Option<ClipHash>,
    /// Loop or transition.
    pub what: ClipKind,
}

/// The kind of a clip: a loop or a transition.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ClipKind {
    /// A sheep, once around.
    Loop {
        /// Which.
        sheep: SheepId,
    },
    /// The transition from one sheep to another.
    Transition {
        /// Where it starts.
        from: SheepId,
        /// Where it ends.
        to: SheepId,
    },
}

/// The visits of a sheep, and its share.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct SheepVisits {
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
        Self { flock, keys, walk, next: Next::Visit { played: 0 }, blocked: BlockedClips::default(), issued: None }
    }

    /// Resumes at `place`. For another flock the place is transferred by the ids of sheep.
    ///
    /// # Errors
    /// [`PlaceError::Foreign`] if `flock` has none of the place's sheep.
    pub fn resume(flock: Arc<Flock>, place: &Place) -> Result<Self, PlaceError> {
        let keys = Arc::new(Keys::of(&flock));
        let Place { memory, next, .. } = carry_over(place, &flock, &keys)?;
        let walk = Some(Walk::with(Arc::clone(&flock), (*memory).clone()));
        Ok(Self { flock, keys, walk, next, blocked: BlockedClips::default(), issued: None })
    }

    /// The next clip and its place. `None` if nothing can be shown.
    pub fn next_leg(&mut self) -> Option<Leg> {
        let place = self.place()?;
        let Some(clip) = self.next_clip() else {
            // Nothing was returned: the path is unchanged.
            self.next = place.next;
            return None;
        };
        self.issued = Some((clip.path.clone(), place.clone()));
        Some(Leg { clip, place })
    }

    /// The next clip without its place. `None` if nothing can be shown.
    pub fn next_clip(&mut self) -> Option<ClipRef> {
        self.issued = None;
        let walk = self.walk.as_mut()?;
        let here = walk.place();
        if let Next::Visit { played } = self.next {
            if played < self.flock.sheep(here).repeat
                && let Some(clip) = open_loop(&self.flock, &self.blocked, here)
            {
                self.next = Next::Visit { played: played + 1 };
                return Some(clip);
            }
            self.next = Next::Leave;
        }
        let Some(step) = walk.step_around(&self.blocked) else {
            // Without an exit the loop is repeated.
            return open_loop(&self.flock, &self.blocked, here);
        };
        self.next = Next::Visit { played: 0 };
        let (from, to) = (self.flock.id(step.from).clone(), self.flock.id(step.to).clone());
        Some(clip_ref(&self.flock.transition(step.exit).clip, ClipKind::Transition { from, to }))
    }

    /// Leaves the bad `clip` out until the next start. If it is the clip of the last leg, the path goes back to before
    /// that leg, and the next leg replaces it.
    pub fn block(&mut self, clip: &ClipPath) {
        self.blocked.block(&self.flock, clip);
        if let Some((_, place)) = self.issued.take_if(|(issued, _)| issued == clip) {
            self.next = place.next;
            self.walk = Some(Walk::with(Arc::clone(&self.flock), (*place.memory).clone()));
        }
    }

    /// Unblocks all clips. The path continues at its present place.
    pub fn unblock(&mut self) {
        self.blocked = BlockedClips::default();
    }

    /// Whether the current sheep has an exit that is not blocked. Without one its loop repeats for ever.
    pub fn has_exit(&self) -> bool {
        let mut ways = self.walk.iter().flat_map(|walk| self.flock.graph().exits(walk.place()));
        ways.any(|exit| self.blocked.is_unblocked(exit))
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
    pub fn visits_by_sheep(&self) -> Vec<SheepVisits> {
        let Some(walk) = &self.walk else { return Vec::new() };
        let showing = |sheep| SheepVisits {
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

fn open_loop(flock: &Flock, blocked: &BlockedClips, sheep: SheepIx) -> Option<ClipRef> {
    let clip = flock.loop_of(sheep).filter(|_| blocked.shows_loop(sheep))?;
    Some(clip_ref(clip, ClipKind::Loop { sheep: flock.id(sheep).clone() }))
}

fn clip_ref(clip: &Clip, what: ClipKind) -> ClipRef {
    ClipRef { path: clip.path.clone(), frames: clip.frames, hash: clip.hash, what }
}

#[cfg(test)]
mod tests;

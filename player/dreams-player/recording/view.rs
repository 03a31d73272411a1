//! What is on the screen now and what a run counts, for other threads.
//!
//! Owns the view that the flip thread updates. The flip thread never waits for it: while another thread copies the view,
//! an update is left out, and the next flip brings it.

use crate::stream::{Frame, ScheduledClip};
use player::hold;
use screen::{ConnectorId, ScreenInfo};
use serde::Serialize;
use std::sync::{Arc, Mutex};
use timing::{Nanos, Rate};

/// The counters of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub(crate) struct Tally {
    /// Pictures that arrived on the glass.
    pub(crate) flips: u64,
    /// Vblanks at which a frame was due and was not there.
    pub(crate) late: u64,
    /// Flips that lit the same frame once more: after the screen was away, or to prove a long hold.
    pub(crate) repeated: u64,
    /// Frames that were decoded and never lit. The player never does that; this is the proof.
    pub(crate) skipped: u64,
    /// Flips at which a clip followed another.
    pub(crate) joins: u64,
}

/// What is on the screen; cheap to clone, the pixels are shared.
#[derive(Clone, Debug, Default)]
pub(crate) struct View {
    /// How the screen is lit; `None` while it is away.
    pub(crate) lit: Option<Arc<ScreenInfo>>,
    /// The picture.
    pub(crate) shown: Option<Frame>,
    /// When it arrived, on the clock of the screen.
    pub(crate) at: Nanos,
    /// The clip that it is of, and the one before; nothing in the place of a fault card.
    pub(crate) clips: [LitClip; 2],
    /// The run so far.
    pub(crate) tally: Tally,
    /// Whether frames are late all the time.
    pub(crate) is_slow: bool,
}

/// A clip that is lit, or was.
#[derive(Clone, Debug, Default)]
pub(crate) struct LitClip {
    /// `None` for a fault card, or if there was none.
    pub(crate) scheduled: Option<Arc<ScheduledClip>>,
    /// When its first frame arrived, on the clock of the screen.
    pub(crate) since: Nanos,
}

impl View {
    /// A frame has arrived.
    fn arrive(&mut self, shown: &Frame, tally: Tally, at: Nanos) {
        let number = |scheduled: &Option<Arc<ScheduledClip>>| scheduled.as_ref().map(|scheduled| scheduled.number);
        let [newest, before] = &mut self.clips;
        if self.shown.is_none() || number(&newest.scheduled) != number(&shown.scheduled) {
            let scheduled = shown.scheduled.clone();
            *before = std::mem::replace(newest, LitClip { scheduled, since: at });
        }
        (self.shown, self.tally, self.at) = (Some(shown.clone()), tally, at);
    }
}

/// The view that threads share.
#[derive(Debug, Default)]
pub(crate) struct SharedView(Mutex<View>);

impl SharedView {
    /// Sets what a flip brought at `at`, unless another thread reads the view at this moment.
    pub(crate) fn flipped(&self, shown: &Frame, tally: Tally, at: Nanos) {
        if let Ok(mut view) = self.0.try_lock() {
            view.arrive(shown, tally, at);
        }
    }

    /// Sets the counters while no flip comes, unless another thread reads the view at this moment.
    pub(crate) fn counted(&self, tally: Tally) {
        if let Ok(mut view) = self.0.try_lock() {
            view.tally = tally;
        }
    }

    /// Sets that the screen came or went. Rare enough to wait for the lock.
    pub(crate) fn lit(&self, lit: Option<&Arc<ScreenInfo>>) {
        hold(&self.0).lit = lit.map(Arc::clone);
    }

    /// The size of the picture on the screen, and the notes about the display for people on site.
    pub(crate) fn size_and_notes(&self) -> (Option<(u32, u32)>, Vec<String>) {
        let view = hold(&self.0);
        let picture = view.shown.as_ref().map(|shown| shown.pixels.picture());
        let notes = view.lit.as_ref().map_or_else(Vec::new, |lit| lit.notes.clone());
        (picture.map(|picture| (picture.width, picture.height)), notes)
    }

    /// Where a display is lit; `None` while it is away, and for a screen without a card.
    pub(crate) fn connector(&self) -> Option<ConnectorId> {
        hold(&self.0).lit.as_ref()?.connector.clone()
    }

    /// The counters, and how many vblanks per second the screen has; `None` while it is away.
    pub(crate) fn tally_and_refresh(&self) -> (Tally, Option<Rate>) {
        let view = hold(&self.0);
        (view.tally, view.lit.as_ref().map(|lit| lit.refresh))
    }

    /// Sets whether frames are late all the time.
    pub(crate) fn slow(&self, is_slow: bool) {
        hold(&self.0).is_slow = is_slow;
    }

    /// What is on the screen.
    pub(crate) fn get(&self) -> View {
        hold(&self.0).clone()
    }
}

#[cfg(test)]
mod tests {
    use super::{SharedView, Tally};
    use crate::stream::scheduled_clip::tests::{frames, scheduled_clips};
    use timing::Nanos;

    #[test]
    fn a_clip_is_lit_since_its_first_frame_and_the_one_before_stays_known() {
        let (view, clips) = (SharedView::default(), scheduled_clips(3, 2));
        let mut seen = Vec::new();
        for (index, frame) in frames(&clips).iter().enumerate() {
            view.flipped(frame, Tally::default(), Nanos(100 + index as u64));
            let view = view.get();
            seen.push(view.clips.map(|clip| (clip.scheduled.map_or(0, |scheduled| scheduled.number), clip.since.0)));
        }
        let first = [(1, 100), (0, 0)];
        let (second, third) = ([(2, 102), (1, 100)], [(3, 104), (2, 102)]);
        assert_eq!(seen, [first, first, second, second, third, third]);
        let card = crate::stream::Frame { scheduled: None, ..frames(&clips)[0].clone() };
        view.flipped(&card, Tally::default(), Nanos(200));
        assert_eq!(view.get().clips.map(|clip| clip.scheduled.is_some()), [false, true], "a fault card shows no sheep");
    }
}

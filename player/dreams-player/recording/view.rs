//! What is on the screen now and what a run counts, for other threads.
//!
//! Owns the view that the flip thread updates. The flip thread never waits for it: while another thread copies the view,
//! an update is left out, and the next flip brings it.

use crate::stream::Frame;
use player::hold;
use screen::ScreenInfo;
use serde::Serialize;
use std::sync::{Arc, Mutex};

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
    /// The run so far.
    pub(crate) tally: Tally,
}

/// The view that threads share.
#[derive(Debug, Default)]
pub(crate) struct SharedView(Mutex<View>);

impl SharedView {
    /// Sets what a flip brought, unless another thread reads the view at this moment.
    pub(crate) fn flipped(&self, shown: &Frame, tally: Tally) {
        if let Ok(mut view) = self.0.try_lock() {
            (view.shown, view.tally) = (Some(shown.clone()), tally);
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

    /// What is on the screen.
    pub(crate) fn get(&self) -> View {
        hold(&self.0).clone()
    }
}

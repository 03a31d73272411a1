//! What is on the screen now, for anyone who wants to look.
//!
//! Owns the view that the flip thread shares with the others. The flip thread never waits for it: while someone copies the
//! view, an update is left out, and the next flip brings it.

use crate::recording::tally::Tally;
use crate::stream::scheduled_clip::Shown;
use player::lock::hold;
use screen::Lit;
use std::sync::{Arc, Mutex};

/// What is on the screen; cheap to clone, the pixels are shared.
#[derive(Clone, Debug, Default)]
pub(crate) struct View {
    /// How the screen is lit; `None` while it is away.
    pub(crate) lit: Option<Arc<Lit>>,
    /// The picture.
    pub(crate) shown: Option<Shown>,
    /// The run so far.
    pub(crate) tally: Tally,
}

/// The view that threads share.
#[derive(Debug, Default)]
pub(crate) struct SharedView(Mutex<View>);

impl SharedView {
    /// Shows what a flip brought, unless someone is looking at this very moment.
    pub(crate) fn flipped(&self, shown: &Shown, tally: Tally) {
        if let Ok(mut view) = self.0.try_lock() {
            (view.shown, view.tally) = (Some(shown.clone()), tally);
        }
    }

    /// Tells how the run goes while no flip does, unless someone is looking at this very moment.
    pub(crate) fn counted(&self, tally: Tally) {
        if let Ok(mut view) = self.0.try_lock() {
            view.tally = tally;
        }
    }

    /// Shows that the screen came or went. Rare enough to wait until nobody is looking.
    pub(crate) fn lit(&self, lit: Option<&Arc<Lit>>) {
        hold(&self.0).lit = lit.map(Arc::clone);
    }

    /// The size of the picture on the screen, and what people on site are to be told of the screen.
    pub(crate) fn size_and_notes(&self) -> (Option<(u32, u32)>, Vec<String>) {
        let view = hold(&self.0);
        let picture = view.shown.as_ref().map(|shown| shown.still.picture());
        let notes = view.lit.as_ref().map_or_else(Vec::new, |lit| lit.notes.clone());
        (picture.map(|picture| (picture.width, picture.height)), notes)
    }

    /// What is on the screen.
    pub(crate) fn get(&self) -> View {
        hold(&self.0).clone()
    }
}

//! What a run counts.
//!
//! Owns the counters. `presenter.rs` counts; the trace and the status page show them.

use serde::Serialize;

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

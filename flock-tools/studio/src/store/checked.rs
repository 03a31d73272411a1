//! What the last check of all clips found.
//!
//! Owns it, until the manifest is another one. Never checks.

use std::collections::BTreeSet;

use flock::{ClipPath, Fault, FaultKind, Flock};

use crate::document::Revision;

/// What the last check found.
#[derive(Clone, Debug, Default)]
pub(crate) struct Checked {
    /// The revision of the manifest that was checked, if one was.
    pub(crate) revision: Option<Revision>,
    /// All that was wrong.
    pub(crate) faults: Vec<Fault>,
}

impl Checked {
    /// The clips that are not what they should be.
    pub(crate) fn damaged(&self) -> BTreeSet<ClipPath> {
        let is_of_clip = |fault: &&Fault| matches!(fault.kind, FaultKind::DamagedClip | FaultKind::WrongClip);
        self.faults.iter().filter(is_of_clip).filter_map(|fault| fault.clip.clone()).collect()
    }

    /// The faults of `flock`: those that the last check found, if it was of this revision, or else those of its graph.
    pub(crate) fn faults(&self, flock: &Flock, revision: &Revision) -> Vec<Fault> {
        if self.revision.as_ref() == Some(revision) { self.faults.clone() } else { flock.faults().to_vec() }
    }
}

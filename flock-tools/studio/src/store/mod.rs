//! What the studio reads from the disk and remembers: genomes, candidates, the states of
//! clips, judged joins, the last check, places, keys.
//!
//! Owns these memories, and their files in the folder `.studio`. Never edits the manifest.
//!
//! Start at [`stock::Stock`].

pub(super) mod candidates;
pub(super) mod checked;
pub(super) mod clip_states;
pub(super) mod genomes;
pub(super) mod joins;
pub(super) mod places;
pub(super) mod shipping;
pub(super) mod stock;

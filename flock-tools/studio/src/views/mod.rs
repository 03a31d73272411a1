//! What the page is told: documents in JSON, computed from the flock and from what is known of its files.
//!
//! Owns their forms. Never opens a clip, and never writes.
//!
//! Start at [`state::flock_part`].

pub(super) mod balance;
pub(super) mod figures;
pub(super) mod lineage;
pub(super) mod prune;
pub(super) mod ship;
pub(super) mod state;
pub(super) mod state_delta;
pub(super) mod walk;

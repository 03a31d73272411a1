//! What happened: the trace, the log lines about playing, the counters, the faults, and the place in the path.
//!
//! Owns the files that the player writes. Never decides what is played.
//!
//! Start at [`recorder::Scribe`].

pub(crate) mod faults;
pub(crate) mod place_saver;
pub(crate) mod place_store;
pub(crate) mod recorder;
pub(crate) mod tally;
mod trace;
pub(crate) mod view;

//! What is played: the flock, the clips in the order in which they come, and their frames.
//!
//! Owns the data that travel from the walk to the screen. Never owns a thread.
//!
//! Start at [`generation::Generation`].

pub(crate) mod fault_card;
pub(crate) mod format;
pub(crate) mod generation;
pub(crate) mod path;
pub(crate) mod plan;
pub(crate) mod scheduled_clip;

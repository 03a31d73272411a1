//! What is played: the flock, its clips in their order, and their frames.
//!
//! Owns the data that travel from the walk to the screen. Never owns a thread.
//!
//! Start at [`Generation`].

mod fault_card;
mod generation;
mod path;
pub(crate) mod scheduled_clip;

pub(crate) use fault_card::{FAULT_CARD, FaultCard};
pub(crate) use generation::{Generation, StreamFormat};
pub(crate) use path::path;
pub(crate) use scheduled_clip::{Frame, Pixels, Plan, ScheduledClip};

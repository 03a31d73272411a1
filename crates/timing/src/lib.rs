//! Exact rates, frame and vblank counters, and the cadence between them.
//!
//! Owns the arithmetic of time, in integers, so that nothing drifts over a year of playing. Never reads a clock: the
//! two root packages do, each in its `now.rs`, and pass the time as [`Nanos`].
//!
//! Start at [`Cadence`], which says how many vblanks a frame stays lit.
#![forbid(unsafe_code)]

mod cadence;
mod counters;
mod rate;

pub use cadence::Cadence;
pub use counters::{FrameCount, FrameIndex, Nanos, Vblank};
pub use rate::{Rate, RateError};

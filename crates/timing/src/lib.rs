//! Exact rates, frame and vblank counters, and the cadence between them.
//!
//! Owns the arithmetic of time: nothing here is a float, so nothing drifts in a year of playing.
//! Never reads a clock: the two roots do, each in its `now.rs`, and hand the reading in as [`Nanos`].
//!
//! Start at [`Cadence`], which says for how many vblanks a frame stays lit.
#![forbid(unsafe_code)]

mod cadence;
mod counters;
mod rate;

pub use cadence::Cadence;
pub use counters::{FrameCount, FrameIndex, Nanos, Vblank};
pub use rate::{Rate, RateError};

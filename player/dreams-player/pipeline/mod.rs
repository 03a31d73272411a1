//! From the walk to the screen: three threads that choose, decode and show.
//!
//! Owns the clip source, the decoder, the queue of frames between it and the presenter, and the state machine of playback.
//! What it tells goes to `recording`. Never opens a screen.
//!
//! Start at [`presenter::Show`].

mod black_picture;
pub(crate) mod clip_source;
pub(crate) mod decoder;
pub(crate) mod first_frame;
pub(crate) mod frame_queue;
mod pacing;
mod playback;
pub(crate) mod presenter;
pub(crate) mod start_gate;

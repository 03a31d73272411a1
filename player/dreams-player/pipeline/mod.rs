//! From the walk to the screen: three threads that choose, decode and show.
//!
//! Owns the clip source, the decoder, the queue of frames between it and the presenter, and the state machine of
//! playback. Its events go to `recording`. Never opens a screen.
//!
//! Start at [`Presenter`].

mod black_picture;
mod clip_source;
mod decoder;
mod first_frame;
mod frame_queue;
mod glass;
#[cfg(test)]
mod grey_clip;
mod pacing;
mod playback;
mod presenter;
mod start_gate;

pub(crate) use clip_source::{ClipSource, Strikes, Successor};
pub(crate) use decoder::DecoderSettings;
pub(crate) use first_frame::FirstFrame;
pub(crate) use frame_queue::{FrameReceiver, frame_queue};
pub(crate) use presenter::{Presenter, PresenterHandles, RunEnd};
pub(crate) use start_gate::StartGate;

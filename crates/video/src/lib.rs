//! The fence around ffmpeg: one endless decoder session, the probe, the encoder.
//!
//! Owns everything that is known of video files and of the flock's form. Never knows a screen or the walk: frames
//! leave as planes of bytes, clips come in as paths.
//!
//! Start at [`Session`], which turns clips into frames; [`probe`] tells whether a clip may go in, [`Encoder`] makes one
//! that may, [`Foreign`] reads the videos of others. All `unsafe` stands in `raw.rs`.
#![deny(unsafe_code)]

mod clip;
mod code;
mod damage;
mod encoder;
mod foreign;
mod form;
mod frame;
mod nal;
mod pixels;
mod probe;
mod raw;
mod session;
mod sps;
mod yuv;

pub use clip::{Clip, ClipError};
pub use damage::Damage;
pub use encoder::{EncodeError, Encoder, Quality};
pub use foreign::{About, Foreign, ForeignError, ForeignPicture};
pub use form::{Difference, Form};
pub use frame::Frame;
pub use probe::{Probe, ProbeError, decodes, is_shortage, probe};
pub use session::{ClipNumber, Poll, Session, SessionError, opening};
pub use yuv::{PictureError, Yuv420p};

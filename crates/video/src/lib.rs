//! The fence around ffmpeg: one endless decoder session, the probe, the encoder.
//!
//! Owns all access to video files, and the flock's form. It knows neither the screen nor the walk: clips come in as
//! paths, frames leave as planes of bytes.
//!
//! Start at [`Session`], which turns clips into frames; [`probe`] examines a clip, [`Encoder`] makes one, [`fragment`] and
//! [`packets`] copy one for a browser, [`ForeignVideo`] reads any other video. All `unsafe` stands in `raw.rs`.
#![deny(unsafe_code)]

mod clip;
mod code;
mod damage;
mod encoder;
mod foreign;
mod form;
mod fragments;
mod frame;
mod index;
mod length;
mod nal;
mod orientation;
mod packets;
mod pixels;
mod probe;
mod quantiser;
mod raw;
mod session;
mod sps;
mod yuv;

pub use clip::{Clip, ClipError};
pub use damage::Damage;
pub use encoder::{EncodeError, Encoder, Quality, Tuning};
pub use foreign::{ForeignError, ForeignPicture, ForeignVideo, VideoInfo};
pub use form::{Difference, Form};
pub use fragments::{FragmentError, Fragments, fragment};
pub use frame::Frame;
pub use orientation::Orientation;
pub use packets::{ClipPacket, ClipPackets, packets};
pub use pixels::{Matrix, MatrixRule};
pub use probe::{Probe, ProbeError, decode_whole, is_shortage, probe};
pub use session::{ClipNumber, Poll, Session, SessionError, first_frame};
pub use yuv::{PictureError, Yuv420p};

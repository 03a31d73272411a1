//! What is lit: a KMS display, the firmware's framebuffer, or the virtual screen, behind one trait.
//!
//! Owns cards, modes, planes, buffers, atomic commits, flips and hot-plug. Never knows a video file: pictures
//! come in as [`Picture`], and leave as light.
//!
//! Start at [`Screen`], the trait that the player drives.
#![deny(unsafe_code)]

mod beat;
mod convert;
mod display;
mod firmware_screen;
mod fit;
mod kms;
mod output;
mod paint;
mod picture;
mod raw;
mod screen;
mod virtual_screen;

pub use display::{Display, is_card};
pub use kms::{Keeper, KmsScreen, KmsSettings};
pub use output::{Margin, OutputError, OutputSettings, RequestedMode, Rotation, SignalRange};
pub use picture::Picture;
pub use screen::{Event, Light, Lit, Screen, ScreenError};
pub use virtual_screen::{Pace, VirtualScreen};

//! Displays behind one trait: a KMS card, the firmware's framebuffer, or the virtual screen.
//!
//! Owns cards, modes, planes, buffers, atomic commits, flips and hot-plug, and the power of a display itself. Pictures come
//! in as [`Picture`]; video files are unknown here.
//!
//! Start at [`Screen`], the trait that the player drives.
#![deny(unsafe_code)]

mod convert;
mod display;
mod firmware_screen;
mod kms;
mod output;
mod paint;
mod picture;
mod power;
mod raw;
mod screen;
mod transform;
mod vblank_clock;
mod virtual_screen;

pub use display::{Display, is_card};
pub use kms::{FdStore, KmsScreen, KmsSettings};
pub use output::{Margin, OutputError, OutputSettings, RequestedMode, Rotation, SignalRange};
pub use picture::Picture;
pub use power::{PowerError, PowerMeans, switch_display};
pub use screen::{ConnectorId, DimmedBy, Event, Light, Screen, ScreenError, ScreenInfo};
pub use transform::Dim;
pub use virtual_screen::{Pace, VirtualScreen};

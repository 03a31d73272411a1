//! The folder of a flock: its manifest, locked while it is edited, and the usual paths of its files.
//!
//! Owns the lock that every program takes which edits a manifest. Never touches another file than the manifest.
//!
//! Start at [`Draft::lock`].

mod draft;
pub mod paths;
mod rename;

pub use draft::{Draft, DraftError};

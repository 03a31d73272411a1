//! The folder of a flock: its manifest, locked while it is edited, and the usual paths of its files.
//!
//! Owns the lock that every program takes which edits a manifest, and the removal of what a killed editor has left. Never
//! touches another file of the flock than the manifest.
//!
//! Start at [`Draft::lock`].

mod draft;
pub mod paths;
mod rename;
mod turn;

pub use draft::{Draft, DraftError};
pub use turn::Turn;

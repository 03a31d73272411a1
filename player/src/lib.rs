//! What the two programs of a unit share, the player and the updater.
//!
//! Owns how both end, where both speak, how both read their settings, and what the one tells the other. Never plays
//! and never fetches.
//!
//! Start at `main.rs` for the player, at `update/main.rs` for the updater.
#![forbid(unsafe_code)]

pub mod config_file;
pub mod day;
pub mod ending;
pub mod journal;
pub mod log_level;
pub mod notice;
pub mod now;

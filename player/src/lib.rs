//! What the programs of a unit share: the player, the updater, and the one that takes in what the owner has set.
//!
//! Owns how they end, where they speak, how they read their settings, and what the one tells the other. Never plays
//! and never fetches.
//!
//! Start at `main.rs` for the player, at `update/main.rs` for the updater, at `owner/main.rs` for the third.
#![forbid(unsafe_code)]

pub mod config_file;
pub mod contact;
pub mod day;
pub mod ending;
pub mod hours;
pub mod journal;
pub mod log_level;
pub mod notice;
pub mod now;
pub mod owner;
pub mod wifi;

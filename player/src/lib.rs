//! What the four programs of a unit share; each has a folder of its name beside this one.
//!
//! Owns how they end, where they log, how they read their settings, and the files through which one tells the other.
//! Never plays and never fetches.
//!
//! Start at the `main.rs` of `dreams-player`, `dreams-update`, `dreams-owner` or `dreams-mend`.
#![forbid(unsafe_code)]

pub mod config_file;
pub mod contact;
pub mod day;
pub mod ending;
pub mod file_version;
pub mod flushed_writer;
pub mod hours;
pub mod journal;
pub mod lock;
pub mod log_level;
pub mod notice;
pub mod now;
pub mod owner;
pub mod threads;
pub mod wifi;

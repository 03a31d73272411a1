//! The settings of a unit: what its owner may set, and how any file of settings is read.
//!
//! Owns the owner's file `dreams.toml` with every key and its form, what a unit keeps of it, and the hours, buttons, Wi-Fi
//! and authorities that it names. The programs of a unit and the artist's command read the file with the same code. Never
//! acts on a setting.
//!
//! Start at [`Owner::parse`].
#![forbid(unsafe_code)]
#![allow(clippy::missing_errors_doc, reason = "the library of our own programs, which has no other readers")]

pub mod authorities;
pub mod button;
pub mod config_file;
pub mod day;
pub mod file_version;
pub mod hours;
pub mod kept;
pub mod owner;
pub mod owners_text;
pub mod week;
pub mod wifi;

pub use button::{ButtonDevice, Key};
pub use config_file::ConfigError;
pub use file_version::FileVersion;
pub use owner::Owner;

//! What the five programs of a unit share; each has a folder of its name beside this one.
//!
//! Owns how they answer, where they log, how they read their settings, and the files through which one tells the other.
//! Never plays and never fetches.
//!
//! Start at the `main.rs` of `dreams-player`, `dreams-update`, `dreams-owner`, `dreams-votes` or `dreams-mend`.
#![forbid(unsafe_code)]
#![allow(clippy::missing_errors_doc, reason = "the library of our own programs, which has no other readers")]

pub mod acknowledgement;
pub mod authorities;
pub mod button;
pub mod clock;
pub mod config_file;
pub mod contact;
pub mod day;
pub mod file_version;
pub mod hours;
pub mod journal;
pub mod kept;
pub mod notice;
pub mod now;
pub mod output;
pub mod owner;
pub mod rollback;
pub mod threads;
pub mod week;
pub mod wifi;

pub use acknowledgement::MarkSocket;
pub use button::{ButtonDevice, Key};
pub use clock::{Clock, ClockReader};
pub use config_file::ConfigError;
pub use contact::Contact;
pub use file_version::FileVersion;
pub use journal::LogLevel;
pub use notice::{Lasting, Notice};
pub use now::{clock_s, clock_us, now, up_s};
pub use output::Output;
pub use owner::Owner;
pub use rollback::Rollback;
pub use threads::{ThreadError, hold};

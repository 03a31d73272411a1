//! What the six programs of a unit share; each has a folder of its name beside this one.
//!
//! Owns how they answer, where they log, and the files through which one informs the other. Their settings are in
//! `settings`.
//! Never plays and never fetches.
//!
//! Start at the `main.rs` of `dreams-player`, `dreams-update`, `dreams-owner`, `dreams-votes`, `dreams-mend` or
//! `dreams-install`.
#![forbid(unsafe_code)]
#![allow(clippy::missing_errors_doc, reason = "the library of our own programs, which has no other readers")]

pub mod acknowledgement;
pub mod clock;
pub mod contact;
pub mod host_name;
pub mod input_devices;
pub mod journal;
pub mod notice;
pub mod now;
pub mod output;
pub mod rollback;
pub mod threads;

pub use acknowledgement::MarkSocket;
pub use clock::{Clock, ClockReader};
pub use contact::Contact;
pub use host_name::{HOST_NAME, host_name};
pub use journal::LogLevel;
pub use notice::{Lasting, Notice};
pub use now::{clock_s, clock_us, now, up_s};
pub use output::Output;
pub use rollback::Rollback;
pub use threads::{ThreadError, hold};

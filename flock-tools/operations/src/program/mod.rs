//! What every command needs: exit codes, printing, progress bars, the clock, contact sheets.
//!
//! Owns no command and opens no flock.
//!
//! Start at [`Fatal`].

pub mod contact_sheet;
mod fatal;
pub mod now;
pub mod print;
pub mod progress;
pub mod reasons;

pub use diagnostics::{Exit, chain};
pub use fatal::{Fatal, end, misuse};

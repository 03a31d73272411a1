//! What every command needs: arguments, exit codes, printing, progress bars, the clock, contact sheets.
//!
//! Owns no command and opens no flock.
//!
//! Start at [`Fatal`].

pub(crate) mod arguments;
pub(crate) mod contact_sheet;
mod fatal;
pub(crate) mod now;
pub(crate) mod print;
pub(crate) mod progress;

pub(crate) use diagnostics::{Exit, chain};
pub(crate) use fatal::{Fatal, finish};

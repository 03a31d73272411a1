//! The manual, made from the same source as the help.
//!
//! Owns the commands that write completions and man pages, and the answers to a shell that completes. Holds no text of
//! either: clap makes both from the command line that `lib.rs` declares.

pub(crate) mod completions;
pub(crate) mod man;

//! What the claims in `it/` and `image/` and the crash laboratory in `crash/` share.
//!
//! Owns the maker of bundles, the mutator of sticks, a web server that misbehaves, waits with a limit, and what a power
//! cut leaves of a disk. Never starts a program.
#![forbid(unsafe_code)]
#![allow(clippy::unwrap_used, clippy::panic, clippy::missing_panics_doc, reason = "a claim fails by panicking")]

pub mod block_log;
pub mod bundle_maker;
pub mod cuts;
pub mod mutator;
pub mod wait;
pub mod web;

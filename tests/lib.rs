//! Whole-system claims live in `it/`, the crash laboratory in `crash/`: this is what both need.
//!
//! Owns the press for bundles and the web server of bad manners. Never runs a program.
#![forbid(unsafe_code)]
#![allow(clippy::unwrap_used, clippy::panic, clippy::missing_panics_doc, reason = "a claim fails by panicking")]

pub mod press;
pub mod web;

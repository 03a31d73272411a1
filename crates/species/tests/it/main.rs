//! Claims about what every species shares, tried through what the crate shows to others.
//!
//! Owns one module for each subject.
#![forbid(unsafe_code)]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod pictures;

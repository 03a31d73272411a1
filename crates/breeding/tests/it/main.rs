//! Claims about pools, tried through what the crate shows to others.
//!
//! Owns one module for each subject. `meadow` makes the pools that the others try.
#![forbid(unsafe_code)]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod editions;
mod folders;
mod meadow;
mod rules;
#[allow(dead_code, reason = "the claims try fewer rules than the example `simulate-votes`")]
mod simulation;
mod taste;

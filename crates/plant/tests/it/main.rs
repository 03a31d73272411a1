//! Claims about plants, tried through what the crate shows to others.
//!
//! Owns one module for each subject. `grove` makes the plants that the others try.
#![forbid(unsafe_code)]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod breeding;
mod corpus;
mod grove;
mod loops;
mod pictures;
#[path = "../../fuzz/target.rs"]
mod target;
mod texts;

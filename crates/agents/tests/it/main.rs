//! Claims about agents, tried through what the crate shows to others.
//!
//! Owns one module for each subject. `bred` makes the globes that the others try.
#![forbid(unsafe_code)]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod bred;
mod breeding;
mod corpus;
mod loops;
mod pictures;
mod texts;

//! Claims about expressions, tried through what the crate shows to others.
//!
//! Owns one module for each subject. `bred`, `drawing` and `many` make what the others try.
#![forbid(unsafe_code)]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod bred;
mod breeding;
mod contract;
mod corpus;
mod drawing;
mod loops;
mod many;
mod meanings;
mod pictures;
mod texts;

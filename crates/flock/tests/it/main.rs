//! Claims about whole flocks that take a million steps, or thousands of flocks.
//!
//! Owns one module for each subject; what one module promises by itself is tested beside it.
#![forbid(unsafe_code)]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on has failed")]

mod balances;
mod walks;

//! The walk in figures: the clips that it plays, how varied it is, how often each sheep is shown.
//!
//! Owns the commands that ask this of a manifest alone. Never chooses a step: the flock crate does.

pub mod share;
pub mod simulate;
pub mod walk;

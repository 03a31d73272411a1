//! Claims about flames, tried through what the crate shows to others.
//!
//! Owns one module for each subject. `bred` and `mixed` make the genomes that the others try.
#![forbid(unsafe_code)]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod bred;
mod breeding;
mod corpus;
mod escape;
mod flam3;
mod flam3_genome;
#[cfg(feature = "gpu")]
mod gpu;
mod hostile;
mod joins;
mod middles;
mod mixed;
mod motion;
mod odd;
mod pictures;
mod stages;
mod tone;
mod unsupported;
mod xml;

//! What every kind of sheep shares: the finished picture, and random numbers that mean the same on every machine.
//!
//! Owns the layout of displayable light ([`Image`]) and the one generator ([`Rng`]). Never knows a genome: a species is a
//! package of its own, and species do not know each other.
//!
//! Start at [`Image`].
#![forbid(unsafe_code)]

mod image;
mod rng;

pub use image::Image;
pub use rng::Rng;

//! How sheep are drawn: their places in a graph, their pictures and colours.
//!
//! Owns what a report and the studio show alike of each sheep. Never judges a flock.

pub mod colour;
pub mod layout;
pub mod picture;

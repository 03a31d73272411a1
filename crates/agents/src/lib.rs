//! L-system agents after Langdon's Pfeiffer: strings, snow globes of them, exact loops, transitions, pictures and breeding.
//!
//! Owns everything that knows what an agent is. Never opens a file, reads a clock or knows what a flock or a clip is.
//!
//! | file | what is there |
//! |---|---|
//! | `pfeiffer.rs`, `turtle.rs` | an agent's string, and the walk along it |
//! | `shape.rs` | an agent at rest: its measures, and what is refused before it is shown |
//! | `globe.rs`, `reader.rs`, `writer.rs`, `lineage.rs`, `error.rs` | a file of agents, with places and limits |
//! | `path.rs`, `motion.rs` | where everything is at a moment of a loop or a transition |
//! | `sprite.rs`, `raster.rs`, `bloom.rs`, `colour.rs`, `picture.rs` | strokes, light, glow, and the picture |
//! | `strings.rs`, `random.rs`, `breed.rs` | agents and globes at random, mutation, mating |
//! | `species.rs` | the contract |
//!
//! Start at [`Agents`] and [`Globe::parse`].
//!
//! # Source
//! W. B. Langdon, *Global Distributed Evolution of L-Systems Fractals* (Pfeiffer, 2004).
#![forbid(unsafe_code)]
#![allow(clippy::float_cmp, reason = "what is equal is equal to the bit")]

mod bloom;
mod breed;
mod colour;
mod error;
mod globe;
mod lineage;
mod motion;
mod path;
mod pfeiffer;
mod picture;
mod random;
mod raster;
mod reader;
mod shape;
mod species;
mod sprite;
mod strings;
mod turtle;
mod writer;

pub use breed::crossover;
pub use colour::Colour;
pub use error::AgentsError;
pub use globe::{Globe, MOST_AGENTS, MOST_BYTES, MOST_COLOURS, MOST_DUST, MOST_GLOW, MOST_IN_A_GLOBE};
pub use pfeiffer::{DEFAULT, MOST_PUBLISHED, MOST_ROUNDS, MOST_SEGMENTS, PARAMETERS, Pfeiffer};
pub use shape::{Invisible, LEAST_POINTS, LEAST_SIZE};
pub use species::{Agents, VERSION};

//! Symbolic expressions after Sims: the language, its exact loops and dissolves, its pictures, and how they breed.
//!
//! Owns everything that knows what an expression is. Never opens a file, reads a clock or knows what a flock or a clip is.
//!
//! | file | what is there |
//! |---|---|
//! | `functions.rs` | the one table of functions: names, types, rules, weights |
//! | `node.rs`, `genome.rs` | an expression as a tree; a file's parts |
//! | `form.rs`, `reader.rs`, `writer.rs`, `lineage.rs`, `error.rs` | text, with places and limits |
//! | `motion.rs`, `dissolve.rs`, `still.rs` | loops, transitions, and what both are at a moment |
//! | `lower.rs`, `graph.rs`, `tape.rs` | from a moment to instructions: types, sharing, registers |
//! | `kernels`, `math.rs` | what the machine does with 512 samples |
//! | `picture.rs`, `tile.rs`, `sampling.rs` | tiles and samples |
//! | `random.rs`, `mutate.rs`, `cross.rs` | breeding |
//! | `species.rs`, `breed.rs` | the contract of a species: what others see, and which candidates they are shown |
//!
//! Start at [`Expressions`]; inside, at [`Genome::parse`], [`Loop::new`] and [`render`].
//!
//! # Source
//! Karl Sims, *Artificial Evolution for Computer Graphics*, SIGGRAPH 1991.
#![forbid(unsafe_code)]
#![allow(clippy::inline_always, reason = "a call that is not inlined would use other instructions than its caller")]
#![allow(clippy::float_cmp, reason = "0 and 1 mean `not at all` and `whole` exactly, and loops are equal to the bit")]

mod breed;
mod cross;
mod dissolve;
mod error;
mod form;
mod functions;
mod genome;
mod graph;
mod kernels;
mod lineage;
mod lower;
mod math;
mod motion;
mod mutate;
mod node;
mod picture;
mod random;
mod reader;
mod sampling;
mod species;
mod still;
mod tape;
mod tile;
mod writer;

pub use self::species::{Expressions, VERSION};
pub use ::species::Place;
pub use breed::FASTEST_NS;
pub use cross::Mating;
pub use dissolve::{LEAST_SHARED, Transition};
pub use error::ExpressionError;
pub use form::MOST_BYTES;
pub use functions::{Argument, FUNCTIONS, Function, Wants};
pub use genome::{Drift, Genome, MOST_TURNS, Map, STRONGEST_ZOOM, View, Zoom};
pub use math::LARGEST;
pub use motion::{Loop, Moving};
pub use mutate::Mutation;
pub use node::{DEEPEST, FASTEST_WAVE, MOST_NODES, MOST_TIMES, Node};
pub use picture::{Cost, MOST_NS, Settings, cost, render};
pub use still::Still;
pub use tile::Samples;

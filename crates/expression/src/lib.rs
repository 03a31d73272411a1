//! Symbolic expressions after Sims: the language, its exact loops and dissolves, its pictures, and how they breed.
//!
//! Owns everything that knows what an expression is. Never opens a file, reads a clock or knows what a flock or a clip is.
//!
//! | file | what is there |
//! |---|---|
//! | `functions.rs` | the one table of functions: names, types, rules, weights |
//! | `node.rs`, `genome.rs` | an expression as a tree; a file's parts |
//! | `form.rs`, `reader.rs`, `writer.rs`, `error.rs` | text, with places and limits |
//! | `motion.rs`, `dissolve.rs`, `still.rs` | loops, transitions, and what both are at a moment |
//! | `lower.rs`, `graph.rs`, `tape.rs` | from a moment to instructions: types, sharing, registers |
//! | `kernels`, `math.rs` | what the machine does with 512 samples |
//! | `picture.rs`, `tile.rs`, `sampling.rs` | threads, tiles and samples |
//! | `random.rs`, `mutate.rs`, `cross.rs` | breeding |
//!
//! Start at [`Genome::parse`], [`Loop::new`] and [`Renderer::render`].
//!
//! # Source
//! Karl Sims, *Artificial Evolution for Computer Graphics*, SIGGRAPH 1991.
#![forbid(unsafe_code)]
#![allow(clippy::float_cmp, reason = "0 and 1 mean `not at all` and `whole` exactly, and loops are equal to the bit")]

mod cross;
mod dissolve;
mod error;
mod form;
mod functions;
mod genome;
mod graph;
mod kernels;
mod lower;
mod math;
mod motion;
mod mutate;
mod node;
mod picture;
mod random;
mod reader;
mod sampling;
mod still;
mod tape;
mod tile;
mod writer;

pub use cross::Mating;
pub use dissolve::Transition;
pub use error::{ExpressionError, Place};
pub use form::MOST_BYTES;
pub use functions::{Argument, FUNCTIONS, Function, Wants};
pub use genome::{Genome, MOST_TURNS, Map};
pub use motion::{Loop, Motion};
pub use mutate::Mutation;
pub use node::{DEEPEST, FASTEST_WAVE, LARGEST, MOST_NODES, MOST_TIMES, Node};
pub use picture::{Cost, MOST_NS, Renderer, Settings, cost};
pub use still::Still;
pub use tile::Samples;

//! Plants after Sims: 21 genes, how they grow, their loops in the wind, their transitions, pictures, and how they breed.
//!
//! Owns everything that knows what a plant is. Never opens a file, reads a clock or knows what a flock or a clip is.
//!
//! | file | what is there |
//! |---|---|
//! | `genes.rs`, `genome.rs` | the one table of genes; a file's parts |
//! | `reader.rs`, `writer.rs`, `lineage.rs`, `error.rs` | text, with places and limits |
//! | `chance.rs`, `growth.rs`, `skeleton.rs` | from genes to bones and leaves |
//! | `stand.rs` | the composition: eleven plants, from the front to the haze |
//! | `wind.rs`, `motion.rs` | loops and transitions |
//! | `view.rs`, `colour.rs`, `vector.rs` | light and shade: from bones to shapes on the screen |
//! | `sky.rs`, `raster.rs`, `picture.rs` | shapes into pixels |
//! | `breed.rs`, `look.rs` | breeding, and the figures by which what is bred is judged |
//! | `species.rs` | the contract of a species |
//!
//! Start at [`Plants`] and [`Plant::parse`].
//!
//! # Source
//! Karl Sims, *Artificial Evolution for Computer Graphics*, SIGGRAPH 1991, section 3.
#![forbid(unsafe_code)]
#![allow(clippy::float_cmp, reason = "0 and 1 mean `not at all` and `whole` exactly, and loops are equal to the bit")]

mod breed;
mod chance;
mod colour;
mod error;
mod genes;
mod genome;
mod growth;
mod lineage;
mod look;
mod motion;
mod picture;
mod raster;
mod reader;
mod skeleton;
mod sky;
mod species;
mod stand;
mod vector;
mod view;
mod wind;
mod writer;

pub use error::PlantError;
pub use genes::{GENES, Gene, MANY};
pub use genome::{MOST_BYTES, MOST_TURNS, Plant};
pub use look::Look;
pub use skeleton::MOST_PARTS;
pub use species::{Plants, VERSION};

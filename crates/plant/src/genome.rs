//! What a file of this species says.
//!
//! Owns the genome's parts. Never reads or writes them (`reader.rs`, `writer.rs`), never draws.
//!
//! Start at [`Plant`].

use crate::genes::{GENES, MANY};

/// The most turns of a loop.
pub const MOST_TURNS: u32 = 16;
/// The most bytes of a text.
pub const MOST_BYTES: usize = 64 * 1024;

/// The genome of a plant.
#[derive(Clone, Debug, PartialEq)]
pub struct Plant {
    /// What the artist calls it.
    pub name: Option<String>,
    /// Which chances it takes, `0..2^63`.
    pub seed: u64,
    /// How often the wind comes round in a loop, `1..=16`.
    pub turns: u32,
    /// The sky above and at the horizon: red, green and blue as displayable light, `0.0..=1.0`.
    pub sky: [[f64; 3]; 2],
    /// Numbers `0.0..=1.0` in the order of [`GENES`].
    pub genes: [f64; MANY],
    /// What is not known of its table and of its file, each by its key, in TOML, as it is written.
    pub unknown: [Vec<(String, String)>; 2],
}

impl Default for Plant {
    /// The plant of a text that says nothing.
    fn default() -> Plant {
        Plant {
            name: None,
            seed: 1,
            turns: 1,
            sky: [[0.16, 0.24, 0.36], [0.86, 0.70, 0.54]],
            genes: GENES.map(|gene| gene.default),
            unknown: [Vec::new(), Vec::new()],
        }
    }
}

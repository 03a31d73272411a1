//! What a file of this species says: a picture, and how it is turned and framed.
//!
//! Owns the genome's parts. Never reads or writes them (`reader.rs`, `writer.rs`), never draws.
//!
//! Start at [`Genome`].

use crate::node::Node;

/// The most turns of a loop.
pub const MOST_TURNS: u32 = 16;

/// Which part of the plane is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Map {
    /// Half the picture's height, `0.001..=1000`.
    pub scale: f32,
    /// The position in the middle.
    pub center: [f32; 2],
}

/// An expression that is drawn, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct Genome {
    /// What the artist calls it.
    pub name: Option<String>,
    /// How often time goes round in a loop, `1..=16`.
    pub turns: u32,
    /// Which part of the plane is seen.
    pub map: Map,
    /// Forms that are not known, as they were written.
    pub unknown: Vec<String>,
    /// A scalar is grey, a vector red, green and blue, both in displayable light from 0 to 1.
    pub picture: Node,
}

impl Default for Map {
    fn default() -> Map {
        Map { scale: 1.0, center: [0.0; 2] }
    }
}

impl Genome {
    /// Whether what was bred may be kept: its text may be read, and its loop be drawn.
    pub(crate) fn is_sound(&self) -> bool {
        self.picture.is_within_limits() && self.ns_per_sample().is_ok()
    }
}

impl From<Node> for Genome {
    /// The genome of a picture, without a name, turned once, with the usual frame.
    fn from(picture: Node) -> Genome {
        Genome { name: None, turns: 1, map: Map::default(), unknown: Vec::new(), picture }
    }
}

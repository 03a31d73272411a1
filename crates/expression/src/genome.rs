//! What a file of this species says: a picture, and how it is turned and framed.
//!
//! Owns the genome's parts. Never reads or writes them (`reader.rs`, `writer.rs`), never draws.
//!
//! Start at [`Genome`].

use crate::math::exp;
use crate::node::Node;
use crate::still::wave;

/// The most turns of a loop.
pub const MOST_TURNS: u32 = 16;

/// The strongest zoom: from its middle by the factor e^3, about 20, to either side.
pub const STRONGEST_ZOOM: f32 = 3.0;

/// Which part of the plane is seen, and how that moves. It is periodic by construction, as everything that moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Map {
    /// Half the picture's height, `0.001..=1000`.
    pub scale: f32,
    /// The position in the middle.
    pub center: [f32; 2],
    /// How the scale swells and shrinks.
    pub zoom: Option<Zoom>,
    /// How the position in the middle goes round.
    pub drift: Option<Drift>,
}

/// A periodic zoom: the scale times e^(by sin(n theta + 2 pi p)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Zoom {
    /// Periods a turn, `1..=4`.
    pub n: u8,
    /// How far, `-3..=3`: the natural logarithm of the largest factor.
    pub by: f32,
    /// The phase in turns.
    pub p: f32,
}

/// A periodic drift on an ellipse around the middle: by (x cos, y sin)(n theta + 2 pi p).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drift {
    /// Periods a turn, `1..=4`.
    pub n: u8,
    /// How far to the right and up.
    pub by: [f32; 2],
    /// The phase in turns.
    pub p: f32,
}

/// Which part of the plane is seen at a moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Half the picture's height.
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
        Map { scale: 1.0, center: [0.0; 2], zoom: None, drift: None }
    }
}

impl Map {
    /// What is seen after so many turns, `0.0..1.0`.
    pub(crate) fn at(&self, turns: f64) -> View {
        let Map { scale, center, zoom, drift } = *self;
        let scale = zoom.map_or(scale, |Zoom { n, by, p }| scale * exp(by * wave(n, p, turns)));
        let center = drift.map_or(center, |Drift { n, by: [right, up], p }| {
            [center[0] + right * wave(n, p + 0.25, turns), center[1] + up * wave(n, p, turns)]
        });
        View { scale, center }
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

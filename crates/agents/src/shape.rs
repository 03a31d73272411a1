//! What an agent looks like at rest.
//!
//! Owns its measures, and which agents are refused before they are shown: those that nobody sees, and twins. Never moves.
//!
//! Start at [`Shape::of`].

use std::fmt::{Display, Formatter};

use crate::pfeiffer::Pfeiffer;
use crate::turtle::{Stroke, walk};

/// The least number of different points.
pub const LEAST_POINTS: usize = 3;
/// The least length of the shorter side of its box, in parts of a picture's height: a line straight down is not seen as an
/// agent.
pub const LEAST_SIZE: f64 = 0.01;
/// Pixels that Pfeiffer's page is high.
const PAGE: f64 = 80.0;
/// Points nearer to each other than this part of the agent's reach are the same.
const GRAIN: f64 = 1.0 / 512.0;

/// An agent at rest, measured. Lengths are in steps.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Shape {
    pub(crate) agent: Pfeiffer,
    /// How many strokes it has.
    pub(crate) strokes: usize,
    /// The root mean square of its strokes' distances from their mean.
    pub(crate) spread: f64,
    /// The greatest distance from that mean.
    pub(crate) reach: f64,
    /// How large it is drawn, from side to side in heights of the picture, where it is nearest.
    pub(crate) size: f64,
    /// The shorter side of its box in parts of the longer one.
    pub(crate) aspect: f64,
    /// Whether the walk came to the string's end.
    pub(crate) is_whole: bool,
    /// Equal for equal drawings, however large, wide, coloured and in whatever order.
    pub(crate) hash: u64,
}

/// Why nobody would see an agent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Invisible {
    /// It has so many different points.
    Points(usize),
    /// The shorter side of its box, in parts of the picture's height.
    Size(f64),
}

impl Display for Invisible {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> std::fmt::Result {
        match self {
            Invisible::Points(points) => {
                write!(formatter, "has {points} different points, at least {LEAST_POINTS} are needed")
            }
            Invisible::Size(size) => {
                let (size, least) = (100.0 * size, 100.0 * LEAST_SIZE);
                write!(
                    formatter,
                    "has a box whose shorter side is {size:.2} % of the picture's height, at least {least} % is needed"
                )
            }
        }
    }
}

impl Shape {
    /// Measures an agent.
    pub(crate) fn of(agent: Pfeiffer) -> Result<Shape, Invisible> {
        let mut strokes = Vec::new();
        let is_whole = walk(&agent, agent.v, |stroke| strokes.push(stroke));
        let Middle { at, spread, reach } = Middle::of(&strokes);
        let ends = || strokes.iter().flat_map(|stroke| [stroke.from, stroke.to]);
        let mut grid: Vec<[i32; 2]> = ends().map(|end| on_grid(end, at, reach)).collect();
        let mut lines: Vec<[[i32; 2]; 2]> =
            grid.as_chunks().0.iter().map(|[from, to]| [*from.min(to), *from.max(to)]).collect();
        lines.sort_unstable();
        lines.dedup();
        grid.sort_unstable();
        grid.dedup();
        if grid.len() < LEAST_POINTS {
            return Err(Invisible::Points(grid.len()));
        }
        let pixels = agent.sc / 5.0;
        let side = |axis: usize| {
            let (low, high) =
                ends().fold((f64::MAX, f64::MIN), |(low, high), end| (low.min(end[axis]), high.max(end[axis])));
            (high - low) * pixels / PAGE
        };
        let (size, longer) = (side(0).min(side(1)), side(0).max(side(1)));
        let aspect = size / longer;
        if size < LEAST_SIZE {
            return Err(Invisible::Size(size));
        }
        let across = 2.0 * reach * pixels;
        // Exponents grow quickly, and pictures don't: every size has its place between these.
        let size = 0.12 + 0.72 * across / (across + 55.0);
        Ok(Shape { agent, strokes: strokes.len(), spread, reach, size, aspect, is_whole, hash: hash(&lines) })
    }
}

/// The middle of strokes, and how far they are from it.
pub(crate) struct Middle {
    pub(crate) at: [f64; 2],
    pub(crate) spread: f64,
    pub(crate) reach: f64,
}

impl Middle {
    pub(crate) fn of(strokes: &[Stroke]) -> Middle {
        let many = strokes.len().max(1) as f64;
        let middle = |stroke: &Stroke| [0, 1].map(|axis| f64::midpoint(stroke.from[axis], stroke.to[axis]));
        let sum = strokes.iter().map(middle).fold([0.0; 2], |sum, middle| [sum[0] + middle[0], sum[1] + middle[1]]);
        let at = sum.map(|sum| sum / many);
        let square = |point: [f64; 2]| {
            let [x, y] = [point[0] - at[0], point[1] - at[1]];
            x * x + y * y
        };
        let spread = strokes.iter().map(|stroke| square(middle(stroke))).sum::<f64>() / many;
        let reach = strokes.iter().fold(0.0_f64, |most, stroke| most.max(square(stroke.from)).max(square(stroke.to)));
        Middle { at, spread: spread.sqrt(), reach: reach.sqrt() }
    }
}

/// A point in grains. Simple fractions of the reach are not where two grains meet.
fn on_grid(point: [f64; 2], middle: [f64; 2], reach: f64) -> [i32; 2] {
    let grain = (reach * GRAIN).max(f64::MIN_POSITIVE);
    [0, 1].map(|axis| ((point[axis] - middle[axis]) / grain + 0.137).round() as i32)
}

/// FNV-1a.
fn hash(lines: &[[[i32; 2]; 2]]) -> u64 {
    let bytes = lines.as_flattened().as_flattened().iter().flat_map(|number| number.to_le_bytes());
    bytes.fold(0xcbf2_9ce4_8422_2325, |sum, byte| (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

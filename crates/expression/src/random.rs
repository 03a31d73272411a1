//! Expressions by chance.
//!
//! Owns how often chance takes what. Every random number comes in as an argument. Never judges a picture.
//!
//! Start at [`Genome::random`].

use ::species::Rng;

use crate::functions::{Argument, FUNCTIONS, Function, Wants};
use crate::genome::Genome;
use crate::node::{FASTEST_WAVE, MOST_TIMES, Node};

/// How often a node that may be a function is a leaf.
const LEAF: f64 = 0.45;
/// The most nodes within each other in a whole expression by chance.
const DEPTH: usize = 6;
/// The fewest nodes of it.
const FEWEST: usize = 4;
/// Sizes of features.
const SIZES: [f64; 2] = [0.05, 4.0];
/// Seeds are whole numbers below.
const SEEDS: f64 = 100.0;
/// How often chance is asked for something that may be read; after that a leaf is taken.
const TRIES: usize = 100;

impl Genome {
    /// A genome by chance, in the usual frame: at least 4 nodes, one of which is a position, at most 6 within each other.
    pub fn random(rng: &mut Rng) -> Genome {
        let varies = |node: &Node| node.all().iter().any(|node| matches!(node, Node::X | Node::Y));
        let is_usable =
            |genome: &Genome| genome.picture.size() >= FEWEST && varies(&genome.picture) && genome.is_sound();
        let mut any = (0..TRIES).map(|_| Genome::from(node(ANY, DEPTH, rng)));
        any.find(is_usable).unwrap_or(Genome::from(Node::X))
    }
}

/// An argument that may be anything.
pub(crate) const ANY: Argument = Argument { wants: Wants::Any, times: 1 };

/// An expression for an argument, of at most `depth` nodes within each other (> 0).
pub(crate) fn node(argument: Argument, depth: usize, rng: &mut Rng) -> Node {
    let is_constant = matches!(argument.wants, Wants::Seed | Wants::Size);
    if depth <= 1 || is_constant || rng.unit() < LEAF {
        return leaf(argument.wants, rng);
    }
    let function = function(rng);
    let arguments = function.arguments.iter().map(|argument| node(*argument, depth - 1, rng)).collect();
    let call = Node::Call(function, arguments);
    if call.times() > MOST_TIMES { leaf(argument.wants, rng) } else { call }
}

/// A function, by the weights of the table.
pub(crate) fn function(rng: &mut Rng) -> &'static Function {
    let weights: Vec<f64> = FUNCTIONS.iter().map(|function| f64::from(function.weight)).collect();
    &FUNCTIONS[rng.weighted(&weights).unwrap_or(0)]
}

/// A leaf for an argument.
pub(crate) fn leaf(wants: Wants, rng: &mut Rng) -> Node {
    match wants {
        Wants::Seed => Node::Number((rng.unit() * SEEDS).floor() as f32),
        Wants::Size => Node::Number(rounded(SIZES[0] * power_of(SIZES[1] / SIZES[0], rng.unit()))),
        Wants::Any | Wants::Scalar | Wants::Vector => {
            let vectors = if wants == Wants::Scalar { 0.0 } else { 0.10 };
            match rng.weighted(&[0.175, 0.175, 0.15, 0.40, vectors]).unwrap_or(0) {
                0 => Node::X,
                1 => Node::Y,
                2 => Node::Wave { n: 1 + rng.below(FASTEST_WAVE.into()) as u8, p: rounded(rng.unit()) },
                3 => Node::Number(rounded(2.0 * rng.signed())),
                _ => Node::Vector([0; 3].map(|_| rounded(rng.unit()))),
            }
        }
    }
}

/// A base to a power, the same on every machine.
fn power_of(base: f64, power: f64) -> f64 {
    f64::from(crate::math::exp(crate::math::ln(base as f32) * power as f32))
}

/// With three digits after the point, which keeps texts short.
pub(crate) fn rounded(value: f64) -> f32 {
    ((value * 1000.0).round() / 1000.0) as f32 + 0.0
}

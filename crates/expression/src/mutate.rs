//! The seven mutations of an expression.
//!
//! Owns what may become of a node, and how often. The rate falls with the parent's length, so that most children differ
//! from it in one or two places; shrinking is slightly likelier than growing. Never judges a picture.
//!
//! Start at [`Genome::mutated`].
//!
//! # Source
//! Sims, *Artificial Evolution for Computer Graphics* (1991), section 4.2; he gives no numbers but the two above.

use ::species::Rng;

use crate::functions::{Argument, FUNCTIONS, Function, Wants};
use crate::genome::Genome;
use crate::math::LARGEST;
use crate::node::{FASTEST_WAVE, Node};
use crate::random::{ANY, leaf, node, rounded};

/// Mutations of an expression of average luck.
const RATE: f64 = 1.5;
/// A new part has at most so many nodes within each other: two functions and a leaf.
const NEW_DEPTH: usize = 3;
/// How far numbers go, of their magnitude or of the least one that counts.
const STRIDE: f64 = 0.3;
const LEAST_MAGNITUDE: f64 = 0.3;
/// How often a seed that is adjusted changes at all.
const SEED_CHANGES: f64 = 0.2;
/// How often a child that may not be read is bred again.
const TRIES: usize = 20;

/// What became of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mutation {
    /// A new random expression.
    New,
    /// Its number, changed a little; a position is the other one.
    Adjusted,
    /// The numbers of a vector, changed a little.
    AdjustedVector,
    /// Another function, its arguments fitted.
    OtherFunction,
    /// The argument of a new function.
    Wrapped,
    /// One of its own arguments.
    Unwrapped,
    /// A copy of another node of the parent.
    Copied,
}

/// How often what, in hundredths, for functions and for leaves.
const OF_FUNCTIONS: [(Mutation, f64); 5] = [
    (Mutation::New, 10.0),
    (Mutation::OtherFunction, 35.0),
    (Mutation::Wrapped, 15.0),
    (Mutation::Unwrapped, 25.0),
    (Mutation::Copied, 15.0),
];
const OF_LEAVES: [(Mutation, f64); 4] =
    [(Mutation::New, 12.0), (Mutation::Adjusted, 72.0), (Mutation::Wrapped, 8.0), (Mutation::Copied, 8.0)];

/// A parent whose child is made.
struct Breeding<'p> {
    parent: &'p Node,
    rate: f64,
    done: Vec<Mutation>,
}

impl Genome {
    /// A child with mutations, and which they are, in the order of the text. `strength` multiplies their number, which is
    /// 1.5 on average at 1. The child is within all limits; where twenty are not, it is the parent.
    pub fn mutated(&self, strength: f64, rng: &mut Rng) -> (Genome, Vec<Mutation>) {
        for _ in 0..TRIES {
            let rate = RATE * strength / self.picture.size() as f64;
            let mut breeding = Breeding { parent: &self.picture, rate, done: Vec::new() };
            let child = Genome { picture: breeding.node(&self.picture, ANY, rng), ..self.clone() };
            if child.is_sound() {
                return (child, breeding.done);
            }
        }
        (self.clone(), Vec::new())
    }
}

impl Breeding<'_> {
    /// What becomes of a node of the parent that is this argument. What is mutated is not mutated again.
    fn node(&mut self, of: &Node, argument: Argument, rng: &mut Rng) -> Node {
        if rng.unit() < self.rate {
            let mutation = if argument.wants == Wants::Seed { Mutation::Adjusted } else { chosen(of, rng) };
            self.done.push(mutation);
            return self.mutated(of, mutation, argument, rng);
        }
        let Node::Call(function, arguments) = of else { return of.clone() };
        let each = function.arguments.iter().zip(arguments);
        Node::Call(function, each.map(|(argument, of)| self.node(of, *argument, rng)).collect())
    }

    fn mutated(&self, of: &Node, mutation: Mutation, argument: Argument, rng: &mut Rng) -> Node {
        match mutation {
            Mutation::Adjusted | Mutation::AdjustedVector => adjusted(of, argument.wants, rng),
            Mutation::Copied => {
                let all = self.parent.all();
                all[rng.below(all.len())].clone()
            }
            Mutation::New => node(argument, NEW_DEPTH, rng),
            Mutation::OtherFunction => other_function(of, rng),
            Mutation::Unwrapped => match of.arguments() {
                [] => of.clone(),
                arguments => arguments[rng.below(arguments.len())].clone(),
            },
            Mutation::Wrapped => {
                let weight =
                    |function: &Function| if frees(function).is_empty() { 0.0 } else { f64::from(function.weight) };
                let weights: Vec<f64> = FUNCTIONS.iter().map(weight).collect();
                let function = &FUNCTIONS[rng.weighted(&weights).unwrap_or(0)];
                let mut arguments: Vec<Node> =
                    function.arguments.iter().map(|argument| leaf(argument.wants, rng)).collect();
                let free = frees(function);
                arguments[free[rng.below(free.len())]] = of.clone();
                Node::Call(function, arguments)
            }
        }
    }
}

/// The numbers of the arguments that may be any expression when chance puts it there.
fn frees(function: &Function) -> Vec<usize> {
    (0..function.arguments.len()).filter(|at| is_free(function, *at)).collect()
}

fn is_free(function: &Function, at: usize) -> bool {
    !matches!(function.arguments[at].wants, Wants::Seed | Wants::Size)
}

fn chosen(of: &Node, rng: &mut Rng) -> Mutation {
    let table: &[(Mutation, f64)] = if matches!(of, Node::Call(..)) { &OF_FUNCTIONS } else { &OF_LEAVES };
    let weights: Vec<f64> = table.iter().map(|(_, weight)| *weight).collect();
    let (mutation, _) = table[rng.weighted(&weights).unwrap_or(0)];
    let is_of_vector = mutation == Mutation::Adjusted && matches!(of, Node::Vector(_));
    if is_of_vector { Mutation::AdjustedVector } else { mutation }
}

/// Another function, the likelier the nearer its number of arguments is to what there is. Arguments stay in order;
/// those that are missing are leaves by chance, as are those that would stand for seeds and sizes.
fn other_function(of: &Node, rng: &mut Rng) -> Node {
    let Node::Call(now, arguments) = of else { return of.clone() };
    let weight = |function: &Function| {
        let distance = function.arguments.len().abs_diff(arguments.len()) as f64;
        if function == *now { 0.0 } else { f64::from(function.weight) / (1.0 + distance * distance) }
    };
    let weights: Vec<f64> = FUNCTIONS.iter().map(weight).collect();
    let function = &FUNCTIONS[rng.weighted(&weights).unwrap_or(0)];
    let fitted = function.arguments.iter().enumerate().map(|(at, argument)| match arguments.get(at) {
        Some(old) if is_free(function, at) || now.arguments[at].wants == argument.wants => old.clone(),
        _ => leaf(argument.wants, rng),
    });
    Node::Call(function, fitted.collect())
}

/// The same leaf with other numbers; a position is the other one.
fn adjusted(of: &Node, wants: Wants, rng: &mut Rng) -> Node {
    match of {
        Node::Call(..) => of.clone(),
        Node::Number(number) => Node::Number(match wants {
            Wants::Seed if rng.unit() >= SEED_CHANGES => *number,
            Wants::Seed => number + if rng.unit() < 0.5 { 1.0 } else { -1.0 },
            Wants::Any | Wants::Scalar | Wants::Size | Wants::Vector => moved(*number, rng),
        }),
        Node::Vector(vector) => Node::Vector(vector.map(|number| moved(number, rng))),
        Node::Wave { n, p } if rng.unit() < 0.5 => Node::Wave { n: *n, p: moved(*p, rng) },
        Node::Wave { n, p } => {
            let n = if rng.unit() < 0.5 { n + 1 } else { n - 1 };
            Node::Wave { n: n.clamp(1, FASTEST_WAVE), p: *p }
        }
        Node::X => Node::Y,
        Node::Y => Node::X,
    }
}

fn moved(number: f32, rng: &mut Rng) -> f32 {
    let number = f64::from(number);
    let moved = number + STRIDE * number.abs().max(LEAST_MAGNITUDE) * rng.normal();
    rounded(moved).clamp(-LARGEST, LARGEST)
}

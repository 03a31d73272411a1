//! An expression as a tree.
//!
//! Owns its shape: size, depth, and what a text or a breeding may not exceed. Never reads or writes text (`reader.rs`,
//! `writer.rs`), never calculates.
//!
//! Start at [`Node`].

use crate::functions::Function;

/// The most parentheses within each other in a file. The two outermost are `(expression (picture ...))`.
pub const DEEPEST: usize = 64;
/// The most nodes of a picture.
pub const MOST_NODES: usize = 2000;
/// The most evaluations of a node for one sample: the product of all neighbour functions around it.
pub const MOST_TIMES: u32 = 72;
/// The fastest `wave`, in periods a turn.
pub const FASTEST_WAVE: u8 = 4;

/// An expression.
#[derive(Clone, Debug, PartialEq)]
pub enum Node {
    /// A function of expressions, as many as its table says.
    Call(&'static Function, Vec<Node>),
    /// A constant.
    Number(f32),
    /// Three constants, `#(a b c)`.
    Vector([f32; 3]),
    /// The only way in which time enters, beside noise: sin(n theta + 2 pi p). `z` is the wave of n = 1, p = 0.
    Wave {
        /// Periods a turn, `1..=4`.
        n: u8,
        /// The phase in turns.
        p: f32,
    },
    /// From left to right, -16/9 to 16/9 in a wide picture.
    X,
    /// From the bottom up, -1 to 1.
    Y,
}

impl Node {
    /// Its arguments; none for a leaf.
    pub fn arguments(&self) -> &[Node] {
        match self {
            Node::Call(_, arguments) => arguments,
            Node::Number(_) | Node::Vector(_) | Node::Wave { .. } | Node::X | Node::Y => &[],
        }
    }

    /// The number of nodes.
    pub fn size(&self) -> usize {
        1 + self.arguments().iter().map(Node::size).sum::<usize>()
    }

    /// The most nodes from here to a leaf, both counted.
    pub fn depth(&self) -> usize {
        1 + self.arguments().iter().map(Node::depth).max().unwrap_or(0)
    }

    /// How often the most evaluated node is evaluated for one sample.
    pub fn times(&self) -> u32 {
        let Node::Call(function, arguments) = self else { return 1 };
        let each = function.arguments.iter().zip(arguments);
        each.map(|(wants, argument)| wants.times.saturating_mul(argument.times())).max().unwrap_or(1)
    }

    /// All nodes, each before its arguments, from left to right.
    pub fn all(&self) -> Vec<&Node> {
        let below = self.arguments().iter().flat_map(Node::all);
        std::iter::once(self).chain(below).collect()
    }

    /// This tree with the node numbered `at`, as in [`Node::all`], replaced.
    #[must_use]
    pub fn with(&self, at: usize, node: &Node) -> Node {
        if at == 0 {
            return node.clone();
        }
        let Node::Call(function, arguments) = self else { return self.clone() };
        let mut first = 1;
        let mut changed = Vec::with_capacity(arguments.len());
        for argument in arguments {
            let size = argument.size();
            let is_inside = (first..first + size).contains(&at);
            changed.push(if is_inside { argument.with(at - first, node) } else { argument.clone() });
            first += size;
        }
        Node::Call(function, changed)
    }

    /// Whether its text may be read: not too large, too deep, or too often evaluated.
    pub fn is_within_limits(&self) -> bool {
        self.size() <= MOST_NODES && self.depth() <= DEEPEST - 2 && self.times() <= MOST_TIMES
    }
}

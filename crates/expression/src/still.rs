//! An expression at one moment: a tree in which only the position is left to vary.
//!
//! Owns what becomes of time: every `wave` is a number, and every function knows how far its noise has turned. Loops
//! (`motion.rs`) and transitions (`dissolve.rs`) make such trees; `lower.rs` compiles them.
//!
//! Start at [`Still`].

use crate::functions::Function;
use crate::math::sin_of_turns;
use crate::node::Node;

/// Time as a part of an expression sees it: turns at the middle of a frame, and turns a frame while the shutter is open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Clock {
    pub(crate) turns: f64,
    pub(crate) turns_per_frame: f64,
}

impl Clock {
    /// Turns, `0.0..1.0`, `shutter` frames from the middle of the frame.
    pub(crate) fn at(self, shutter: f64) -> f64 {
        // Whole turns go first, so that equal fractions stay equal.
        let turns = (self.turns - self.turns.floor()) + self.turns_per_frame * shutter;
        turns - turns.floor()
    }
}

/// An expression at a moment.
#[derive(Clone, Debug, PartialEq)]
pub enum Still {
    /// A function.
    Call {
        /// Which.
        function: &'static Function,
        /// How far its noise has turned, `0.0..1.0`.
        turns: f64,
        /// Its arguments.
        arguments: Vec<Still>,
    },
    /// A constant.
    Number(f32),
    /// Three constants.
    Vector([f32; 3]),
    /// The position from left to right.
    X,
    /// The position from the bottom up.
    Y,
}

impl Still {
    /// Bytes of all its nodes.
    pub(crate) fn bytes(&self) -> u64 {
        let below: u64 = match self {
            Still::Call { arguments, .. } => arguments.iter().map(Still::bytes).sum(),
            Still::Number(_) | Still::Vector(_) | Still::X | Still::Y => 0,
        };
        below + size_of::<Still>() as u64
    }

    /// An expression after so many turns, `0.0..1.0`.
    pub(crate) fn of(node: &Node, turns: f64) -> Still {
        match node {
            Node::Call(function, arguments) => {
                let arguments = arguments.iter().map(|argument| Still::of(argument, turns)).collect();
                Still::Call { function, turns, arguments }
            }
            Node::Number(number) => Still::Number(*number),
            Node::Vector(vector) => Still::Vector(*vector),
            Node::Wave { n, p } => Still::Number(wave(*n, *p, turns)),
            Node::X => Still::X,
            Node::Y => Still::Y,
        }
    }
}

/// sin(n theta + 2 pi p) after so many turns of theta.
pub(crate) fn wave(n: u8, p: f32, turns: f64) -> f32 {
    let turns = f64::from(n) * turns + f64::from(p);
    sin_of_turns(turns - turns.floor())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_turns_do_not_count_not_even_in_the_last_bit() {
        for shutter in [-0.1875, -0.0625, 0.0625, 0.1875] {
            let at = |turns: f64| Clock { turns, turns_per_frame: 1.0 / 37.0 }.at(shutter);
            assert_eq!(at(3.0).to_bits(), at(0.0).to_bits());
            assert!((0.0..1.0).contains(&at(-2.0)));
        }
    }
}

//! The genetic cross dissolve of two loops.
//!
//! Owns how two expressions become one (what is equal is shared, where they differ both results are dissolved), and the
//! clocks of its parts. All that changes is eased by s = 3b^2 - 2b^3, whose speed is 0 at both ends; what only one side has
//! turns on at that side's speed; what is shared starts and ends at the loops' own speeds. Within a frame, while the
//! shutter is open, s stands still and every clock goes on evenly: so frame 0 is the first loop's, to the bit. Never draws.
//!
//! Start at [`Transition`].
//!
//! # Source
//! Sims, *Artificial Evolution for Computer Graphics* (1991), section 4.5.

use std::collections::HashMap;
use std::ptr::from_ref;

use crate::functions::{Function, Wants};
use crate::genome::View;
use crate::motion::{Loop, Moving};
use crate::node::Node;
use crate::still::{Clock, Still, wave};

/// Where less is shared, a dissolve of pictures is better.
pub const LEAST_SHARED: f64 = 0.25;

/// Two expressions in one.
#[derive(Clone, Debug)]
enum Merged {
    /// The same function of merged arguments.
    Call(&'static Function, Vec<Merged>),
    /// Nothing in common.
    Dissolve(Node, Node),
    Numbers(f32, f32),
    Same(Node),
    Vectors([f32; 3], [f32; 3]),
    /// Waves of equal n, their phases interpolated the shorter way round.
    Waves(u8, f32, f32),
}

/// Shared, the first side's, the second side's.
#[derive(Clone, Copy, Debug)]
struct Clocks {
    shared: f64,
    sides: [f64; 2],
    eased: f32,
}

/// The way from one loop to another: frame 0 is frame 0 of the first, the last is frame 0 of the second.
#[derive(Clone, Debug)]
pub struct Transition {
    loops: [Loop; 2],
    merged: Merged,
    /// Nodes that both have, of all that the larger one has.
    shared: f64,
    frames: f64,
}

impl Transition {
    /// The way from `from` to `to` in `frames` frames (> 0).
    pub fn new(from: &Loop, to: &Loop, frames: f64) -> Transition {
        let (a, b) = (from.picture(), to.picture());
        let mut likeness = Likeness::default();
        let shared = f64::from(likeness.of(a, b)) / a.size().max(b.size()) as f64;
        Transition { merged: likeness.merged(a, b), shared, loops: [from.clone(), to.clone()], frames }
    }

    /// The part of the larger expression's nodes that both share, `0.0..=1.0`. Under [`LEAST_SHARED`], there is little to
    /// be seen of a genetic dissolve.
    pub fn shared(&self) -> f64 {
        self.shared
    }

    /// The loop that it leaves, and the one that it reaches.
    pub(crate) fn loops(&self) -> [&Loop; 2] {
        self.loops.each_ref()
    }

    /// How far it has come, `0.0..=1.0`, and how far as it is eased.
    fn progress(&self, frame: f64) -> [f64; 2] {
        let b = (frame / self.frames).clamp(0.0, 1.0);
        [b, b * b * (3.0 - 2.0 * b)]
    }

    /// A cubic from 0 to whole turns that starts and ends at the loops' speeds.
    fn shared_clock(&self, b: f64) -> Clock {
        let [first, last] = [0, 1].map(|side| self.loops[side].speed() * self.frames);
        let whole = f64::midpoint(first, last).round();
        let turns =
            whole * (b * b * (3.0 - 2.0 * b)) + first * (b * (b - 1.0) * (b - 1.0)) + last * (b * b * (b - 1.0));
        let slope = whole * (6.0 * b * (1.0 - b)) / self.frames;
        let [first, last] = [0, 1].map(|side| self.loops[side].speed());
        let turns_per_frame = slope + first * (1.0 - b * (4.0 - 3.0 * b)) + last * (b * (3.0 * b - 2.0));
        Clock { turns, turns_per_frame }
    }
}

impl Moving for Transition {
    /// Between what both loops see then. The scale changes by equal factors.
    fn view(&self, frame: f64, shutter: f64) -> View {
        let views = [self.loops[0].view(frame, shutter), self.loops[1].view(frame - self.frames, shutter)];
        let [_, eased] = self.progress(frame);
        if eased == 0.0 || eased == 1.0 || views[0] == views[1] {
            return views[usize::from(eased == 1.0)];
        }
        let [from, to] = views.map(|view| view.center);
        let center = [0, 1].map(|axis| blended(from[axis], to[axis], eased as f32));
        let factor = crate::math::ln(views[1].scale / views[0].scale);
        View { scale: views[0].scale * crate::math::exp(factor * eased as f32), center }
    }

    fn still(&self, frame: f64, shutter: f64) -> Still {
        let [b, eased] = self.progress(frame);
        let sides = [self.loops[0].clock(frame), self.loops[1].clock(frame - self.frames)];
        let sides = sides.map(|clock| clock.at(shutter));
        let clocks = Clocks { shared: self.shared_clock(b).at(shutter), sides, eased: eased as f32 };
        self.merged.still(clocks)
    }
}

impl Merged {
    fn still(&self, clocks: Clocks) -> Still {
        let Clocks { shared, sides, eased } = clocks;
        match self {
            Merged::Call(function, arguments) => {
                let arguments = arguments.iter().map(|argument| argument.still(clocks)).collect();
                Still::Call { function, turns: shared, arguments }
            }
            Merged::Dissolve(a, _) if eased == 0.0 => Still::of(a, sides[0]),
            Merged::Dissolve(_, b) if eased == 1.0 => Still::of(b, sides[1]),
            Merged::Dissolve(a, b) => {
                let function = Function::named("dissolve").expect("the table has it");
                let arguments = vec![Still::of(a, sides[0]), Still::of(b, sides[1]), Still::Number(eased)];
                Still::Call { function, turns: shared, arguments }
            }
            Merged::Numbers(a, b) => Still::Number(blended(*a, *b, eased)),
            Merged::Same(node) => Still::of(node, shared),
            Merged::Vectors(a, b) => Still::Vector([0, 1, 2].map(|number| blended(a[number], b[number], eased))),
            Merged::Waves(n, _, b) if eased == 1.0 => Still::Number(wave(*n, *b, shared)),
            Merged::Waves(n, a, b) => {
                let nearest = b - (b - a).round();
                Still::Number(wave(*n, blended(*a, nearest, eased), shared))
            }
        }
    }
}

/// From `a` to `b`, both exactly at the ends.
fn blended(a: f32, b: f32, eased: f32) -> f32 {
    a * (1.0 - eased) + b * eased
}

/// How many nodes two expressions share, remembered for every pair that was asked for.
#[derive(Default)]
struct Likeness {
    known: HashMap<[*const Node; 2], u32>,
}

impl Likeness {
    /// Nodes that the two share when they are merged.
    fn of(&mut self, a: &Node, b: &Node) -> u32 {
        let pair = [from_ref(a), from_ref(b)];
        if let Some(known) = self.known.get(&pair) {
            return *known;
        }
        let shared = if a == b {
            a.size() as u32
        } else {
            match (a, b) {
                (Node::Call(f, left), Node::Call(g, right)) if f == g && seeds_agree(f, left, right) => {
                    1 + self.ordered(f, left, right).1
                }
                (Node::Number(_), Node::Number(_)) | (Node::Vector(_), Node::Vector(_)) => 1,
                (Node::Wave { n, .. }, Node::Wave { n: m, .. }) if n == m => 1,
                _ => 0,
            }
        };
        self.known.insert(pair, shared);
        shared
    }

    /// The order of the second's arguments in which more is shared, and how much.
    fn ordered(&mut self, function: &Function, left: &[Node], right: &[Node]) -> (Vec<usize>, u32) {
        let mut count = |order: Vec<usize>| {
            let shared = left.iter().zip(&order).map(|(a, b)| self.of(a, &right[*b])).sum();
            (order, shared)
        };
        let straight = count((0..right.len()).collect());
        if !function.commutes {
            return straight;
        }
        let crossed = count((0..right.len()).rev().collect());
        if crossed.1 > straight.1 { crossed } else { straight }
    }

    fn merged(&mut self, a: &Node, b: &Node) -> Merged {
        if a == b {
            return Merged::Same(a.clone());
        }
        match (a, b) {
            (Node::Call(f, left), Node::Call(g, right)) if f == g && seeds_agree(f, left, right) => {
                let (order, _) = self.ordered(f, left, right);
                Merged::Call(f, left.iter().zip(order).map(|(a, b)| self.merged(a, &right[b])).collect())
            }
            (Node::Number(a), Node::Number(b)) => Merged::Numbers(*a, *b),
            (Node::Vector(a), Node::Vector(b)) => Merged::Vectors(*a, *b),
            (Node::Wave { n, p }, Node::Wave { n: m, p: q }) if n == m => Merged::Waves(*n, *p, *q),
            _ => Merged::Dissolve(a.clone(), b.clone()),
        }
    }
}

/// Whether no seed differs: between two seeds there is nothing but other patterns.
fn seeds_agree(function: &Function, left: &[Node], right: &[Node]) -> bool {
    let arguments = function.arguments.iter().zip(left.iter().zip(right));
    arguments.filter(|(argument, _)| argument.wants == Wants::Seed).all(|(_, (a, b))| a == b)
}

//! From a genome to text.
//!
//! Owns how a genome is written: always in one way, so that equal genomes have equal texts. Never knows a function but by
//! the table (`functions.rs`).
//!
//! Start at [`Genome`]'s and [`Node`]'s `Display`.

use std::fmt::{Display, Formatter, Result};

use crate::genome::{Drift, Genome, Map, Zoom};
use crate::node::Node;

/// Below this, a number is written with an exponent.
const SMALL: f32 = 1e-4;

/// A number in the fewest digits that mean the same.
struct Short(f32);

impl Display for Genome {
    /// Writes the text that [`Genome::parse`] reads: what has its usual value is left out.
    fn fmt(&self, text: &mut Formatter<'_>) -> Result {
        writeln!(text, "(expression 1")?;
        if let Some(name) = &self.name {
            writeln!(text, "  (name {})", quoted(name))?;
        }
        if self.turns != 1 {
            writeln!(text, "  (turns {})", self.turns)?;
        }
        if self.map != Map::default() {
            let Map { scale, center: [x, y], zoom, drift } = self.map;
            write!(text, "  (map (scale {scale}) (center {} {})", Short(x), Short(y))?;
            if let Some(Zoom { n, by, p }) = zoom {
                write!(text, " (zoom {n} {} {})", Short(by), Short(p))?;
            }
            if let Some(Drift { n, by: [x, y], p }) = drift {
                write!(text, " (drift {n} {} {} {})", Short(x), Short(y), Short(p))?;
            }
            writeln!(text, ")")?;
        }
        for form in &self.unknown {
            writeln!(text, "  {form}")?;
        }
        writeln!(text, "  (picture {}))", self.picture)
    }
}

/// A text in quotes.
pub(crate) fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

impl Display for Node {
    fn fmt(&self, text: &mut Formatter<'_>) -> Result {
        match self {
            Node::Call(function, arguments) => {
                write!(text, "({}", function.name)?;
                for argument in arguments {
                    write!(text, " {argument}")?;
                }
                write!(text, ")")
            }
            Node::Number(number) => write!(text, "{}", Short(*number)),
            Node::Vector([a, b, c]) => write!(text, "#({} {} {})", Short(*a), Short(*b), Short(*c)),
            Node::Wave { n: 1, p: 0.0 } => write!(text, "z"),
            Node::Wave { n, p } => write!(text, "(wave {n} {})", Short(*p)),
            Node::X => write!(text, "x"),
            Node::Y => write!(text, "y"),
        }
    }
}

impl Display for Short {
    fn fmt(&self, text: &mut Formatter<'_>) -> Result {
        let Short(number) = self;
        if *number != 0.0 && number.abs() < SMALL { write!(text, "{number:e}") } else { write!(text, "{number}") }
    }
}

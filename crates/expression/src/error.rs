//! What is refused, and where.
//!
//! Owns the one error of this crate. Never prints it.
//!
//! Start at [`ExpressionError`]; [`ExpressionError::place`] is where in a text it is.

use ::species::Place;
use thiserror::Error;

/// Why a text is not read, or a genome is not drawn.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ExpressionError {
    /// A function has too few or too many arguments.
    #[error("{place}: `{name}` takes {wants} arguments, not {has}")]
    Arity {
        /// Where the function is.
        place: Place,
        /// The function.
        name: String,
        /// How many it takes.
        wants: usize,
        /// How many there are.
        has: usize,
    },
    /// More parentheses are within each other than may be.
    #[error("{place}: more than {most} parentheses within each other")]
    Deep {
        /// Where the first that is too deep opens.
        place: Place,
        /// The limit.
        most: usize,
    },
    /// The text is longer than may be.
    #[error("{place}: the text goes on after {most} bytes")]
    Long {
        /// Where the limit is passed.
        place: Place,
        /// The limit.
        most: usize,
    },
    /// The picture has more nodes than may be.
    #[error("{place}: more than {most} nodes")]
    Many {
        /// Where the first that is too many is.
        place: Place,
        /// The limit.
        most: usize,
    },
    /// Functions that look at neighbours are within each other.
    #[error("{place}: `{name}` evaluates its argument {times} times a sample, with all around it; {most} is the most")]
    Neighbours {
        /// Where the function is.
        place: Place,
        /// The function.
        name: String,
        /// How often it would.
        times: u32,
        /// The limit.
        most: u32,
    },
    /// A number is none, or not in its range.
    #[error("{place}: `{text}` is not {wants}")]
    Number {
        /// Where it is.
        place: Place,
        /// What is there.
        text: String,
        /// What must be there.
        wants: &'static str,
    },
    /// The picture's size is not in the range.
    #[error("a picture of {width} by {height} pixels; 1 to {most} are possible")]
    Size {
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
        /// The limit of both.
        most: u32,
    },
    /// The picture takes longer than may be.
    #[error("the picture takes over {most_ns} ns a sample")]
    Slow {
        /// The limit.
        most_ns: f32,
    },
    /// The text is no expression.
    #[error("{place}: {wants} is expected")]
    Syntax {
        /// Where it is not as expected.
        place: Place,
        /// What is expected there.
        wants: &'static str,
    },
    /// A name is not known.
    #[error("{place}: `{name}` is not known")]
    Unknown {
        /// Where it is.
        place: Place,
        /// The name.
        name: String,
    },
}

impl ExpressionError {
    /// Where in the text it is; none for what is refused later.
    pub fn place(&self) -> Option<Place> {
        match self {
            ExpressionError::Arity { place, .. }
            | ExpressionError::Deep { place, .. }
            | ExpressionError::Long { place, .. }
            | ExpressionError::Many { place, .. }
            | ExpressionError::Neighbours { place, .. }
            | ExpressionError::Number { place, .. }
            | ExpressionError::Syntax { place, .. }
            | ExpressionError::Unknown { place, .. } => Some(*place),
            ExpressionError::Size { .. } | ExpressionError::Slow { .. } => None,
        }
    }
}

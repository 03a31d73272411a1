//! What is refused, and where.
//!
//! Owns the one error of this crate. Never prints it.
//!
//! Start at [`PlantError`]; [`PlantError::place`] is where in a text it is.

use species::Place;
use thiserror::Error;

/// Why a text is not read, or a plant is not drawn.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PlantError {
    /// A key that must be there is missing.
    #[error("{place}: `{name}` is missing")]
    Missing {
        /// Where the table opens.
        place: Place,
        /// The key.
        name: &'static str,
    },
    /// The text is longer than may be, or becomes so when it is written.
    #[error("{place}: {bytes} bytes of text, {most} are the most")]
    Long {
        /// Where the limit is passed.
        place: Place,
        /// How long it is.
        bytes: usize,
        /// The limit.
        most: usize,
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
    /// The text is no TOML.
    #[error("{place}: {reason}")]
    Syntax {
        /// Where it is not.
        place: Place,
        /// What the reader of TOML says.
        reason: String,
    },
    /// A value is not what its key wants.
    #[error("{place}: `{name}` is {value}, it must be {wants}")]
    Value {
        /// Where the value is.
        place: Place,
        /// The key.
        name: String,
        /// What is there.
        value: String,
        /// What must be there.
        wants: &'static str,
    },
}

impl PlantError {
    /// Where in the text it is; none for what is refused later.
    pub fn place(&self) -> Option<Place> {
        match self {
            PlantError::Missing { place, .. }
            | PlantError::Long { place, .. }
            | PlantError::Syntax { place, .. }
            | PlantError::Value { place, .. } => Some(*place),
            PlantError::Size { .. } => None,
        }
    }
}

//! What is refused, and where.
//!
//! Owns the one error of this crate. Never prints it.
//!
//! Start at [`AgentsError`]; [`AgentsError::place`] is where in a text it is.

use species::Place;
use thiserror::Error;

use crate::shape::Invisible;

/// Why a text is no globe of agents, or a globe is not drawn. Agents are counted from 1.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum AgentsError {
    /// The agents have more segments than may be.
    #[error("{place}: with agent {agent} the globe has {segments} segments, at most {most} are possible")]
    Heavy {
        /// Where the agent is.
        place: Place,
        /// Its number.
        agent: usize,
        /// The segments of all up to it.
        segments: usize,
        /// The limit.
        most: usize,
    },
    /// Nobody would see an agent.
    #[error("{place}: agent {agent} {why}")]
    Invisible {
        /// Where the agent is.
        place: Place,
        /// Its number.
        agent: usize,
        /// Why not.
        why: Invisible,
    },
    /// The text is longer than may be.
    #[error("{place}: the text goes on after {most} bytes")]
    Long {
        /// Where the limit is passed.
        place: Place,
        /// The limit.
        most: usize,
    },
    /// A part that must be there is not.
    #[error("{place}: `{key}` is missing")]
    Missing {
        /// Where it should be.
        place: Place,
        /// What is missing.
        key: &'static str,
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
    #[error("{place}: {message}")]
    Syntax {
        /// Where it is not.
        place: Place,
        /// What the parser says.
        message: String,
    },
    /// Two agents draw the same.
    #[error("{place}: agent {agent} draws what agent {twin} draws")]
    Twin {
        /// Where the second of them is.
        place: Place,
        /// Its number.
        agent: usize,
        /// The number of the first.
        twin: usize,
    },
    /// A value is not what it must be.
    #[error("{place}: `{key}` is {found}, not {wants}")]
    Value {
        /// Where it is.
        place: Place,
        /// Whose value.
        key: &'static str,
        /// What is there.
        found: String,
        /// What must be there.
        wants: &'static str,
    },
}

impl AgentsError {
    /// Where in the text it is; none for what is refused later.
    pub fn place(&self) -> Option<Place> {
        match self {
            AgentsError::Heavy { place, .. }
            | AgentsError::Invisible { place, .. }
            | AgentsError::Long { place, .. }
            | AgentsError::Missing { place, .. }
            | AgentsError::Syntax { place, .. }
            | AgentsError::Twin { place, .. }
            | AgentsError::Value { place, .. } => Some(*place),
            AgentsError::Size { .. } => None,
        }
    }
}

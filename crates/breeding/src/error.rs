//! Why a pool is not read, changed or bred from.
//!
//! Owns the error of this package. Never prints it.
//!
//! Start at [`BreedingError`].

use std::io;

use crate::event::Stamp;
use crate::id::{Id, Origin};

/// What goes wrong with a pool.
#[derive(Debug, thiserror::Error)]
pub enum BreedingError {
    /// A line of a ledger is no event that this version knows.
    #[error("line {line} of ledger `{file}` is no event known here: {reason}")]
    BadEvent {
        /// The file.
        file: String,
        /// The line, from 1.
        line: usize,
        /// What is wrong with it.
        reason: String,
    },
    /// Two events or genomes have one name.
    #[error("two pools have different events {} of pool `{}`: one is a copy that went its own way", stamp.number, stamp.pool)]
    Clash {
        /// The name.
        stamp: Stamp,
    },
    /// There is a pool already.
    #[error("`{folder}` is a pool already")]
    Exists {
        /// Its folder.
        folder: String,
    },
    /// Another program changes the pool.
    #[error("pool `{folder}` is being changed by another program")]
    InUse {
        /// Its folder.
        folder: String,
    },
    /// A disk fails.
    #[error("cannot {action} `{path}`")]
    Io {
        /// What was tried.
        action: &'static str,
        /// On what.
        path: String,
        /// What the disk says.
        source: io::Error,
    },
    /// A sheep's genome is missing.
    #[error("the genome of sheep `{id}` is missing: `{path}`")]
    NoGenome {
        /// The sheep.
        id: Id,
        /// The file.
        path: String,
    },
    /// Settings contradict each other or a limit.
    #[error("{what} is {value}, {limit}")]
    Setting {
        /// The setting.
        what: &'static str,
        /// Its value.
        value: String,
        /// What it must be, with the other value.
        limit: String,
    },
    /// The settings are no TOML, or not of a pool.
    #[error("`{file}` is not the settings of a pool")]
    Settings {
        /// The file.
        file: String,
        /// Where, and what.
        source: Box<toml::de::Error>,
    },
    /// A figure is missing.
    #[error("event {} of pool `{}`: sheep `{id}` has {found} figures, the others of the pool have {expected}", stamp.number, stamp.pool)]
    Traits {
        /// The event.
        stamp: Stamp,
        /// The sheep.
        id: Id,
        /// Its figures.
        found: usize,
        /// Those of others.
        expected: usize,
    },
    /// A sheep is born twice.
    #[error("event {} of pool `{}`: sheep `{id}` was born already", stamp.number, stamp.pool)]
    Twice {
        /// The event.
        stamp: Stamp,
        /// The sheep.
        id: Id,
    },
    /// An event or a request names a sheep that was never born.
    #[error("event {} of pool `{}` names sheep `{id}`, which was not born before", stamp.number, stamp.pool)]
    Unborn {
        /// The event.
        stamp: Stamp,
        /// The sheep.
        id: Id,
    },
    /// A sheep asked for is not there.
    #[error("no sheep `{id}` in pool `{origin}`")]
    Unknown {
        /// The text.
        id: String,
        /// The pool.
        origin: Origin,
    },
}

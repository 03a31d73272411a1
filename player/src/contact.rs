//! The result of the last update run.
//!
//! Owns the small file in the store that the updater writes and the status page reads. It has our own words alone:
//! nothing that a stranger wrote.

use serde::{Deserialize, Serialize};
use std::io;
use std::path::Path;

/// Beside the state of a store.
const FILE_NAME: &str = "contact.json";
/// What the file may have, in bytes.
const LARGEST: u64 = 64 << 10;

/// The result of an update run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Contact {
    /// When, in seconds since 1970; none where the time was not known.
    pub clock_s: Option<u64>,
    /// `stick` or `network`.
    pub source: String,
    /// How it ended, in words for people.
    pub result: String,
    /// The ids of the keys that were trusted then.
    pub trusted: Vec<String>,
    /// The ids of those that were called back.
    pub revoked: Vec<String>,
}

impl Contact {
    /// The last one in `store`; none if there is none, or it cannot be read.
    pub fn last(store: &Path) -> Option<Self> {
        serde_json::from_slice(&durable::read_plain(&store.join(FILE_NAME), LARGEST).ok()?).ok()
    }

    /// Writes it to `store`.
    pub fn tell(&self, store: &Path) -> io::Result<()> {
        durable::write(&store.join(FILE_NAME), &serde_json::to_vec(self).map_err(io::Error::other)?)
    }
}

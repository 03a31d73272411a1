//! The newer system that a unit has tried and left.
//!
//! Owns the small file that `dreams-mend` writes and `dreams-update` reports. Never decides whether a system was left:
//! `dreams-mend/plan.rs` does.

use serde::{Deserialize, Serialize};
use std::io;
use std::path::Path;

/// The file that holds it on a unit, below the root of its system.
pub const FILE: &str = "var/lib/dreams/mend/rollback";
/// Bytes of the file that are read, at most.
const LARGEST: u64 = 4 << 10;

/// A system that was left.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Rollback {
    /// Its version.
    pub from: String,
    /// The reason, one sentence.
    pub why: String,
}

impl Rollback {
    /// The one in the file `path`; `None` if there is none, or it cannot be read.
    pub fn read(path: &Path) -> Option<Self> {
        serde_json::from_slice(&durable::read_plain(path, LARGEST).ok()?).ok()
    }

    /// Writes it to the file `path`.
    pub fn write(&self, path: &Path) -> io::Result<()> {
        durable::write(path, &serde_json::to_vec(self).map_err(io::Error::other)?)
    }
}

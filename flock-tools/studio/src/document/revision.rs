//! The name of a manifest's text.
//!
//! Owns it: the BLAKE3 hash of the bytes, so that the same text always has the same name. Never tells which is newer.

use serde::{Deserialize, Serialize};

/// 64 hexadecimal digits.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub(crate) struct Revision(String);

impl Revision {
    /// That of `text`.
    pub(crate) fn of(text: &str) -> Self {
        Self(blake3::hash(text.as_bytes()).to_hex().to_string())
    }
}

impl std::fmt::Display for Revision {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

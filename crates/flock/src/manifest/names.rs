//! Types of validated names: sheep ids, clip paths, clip hashes.
//!
//! Owns their rules, and the table by which an id that is read many times is in memory once. The tools check whether a path
//! exists.

use std::borrow::Borrow;
use std::collections::HashSet;
use std::fmt;
use std::path::{Path, PathBuf};

use arcstr::ArcStr;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Longest id of a sheep, in bytes.
const MAX_ID_BYTES: usize = 64;

/// The id of a sheep: 1 to 64 of `A-Z a-z 0-9 . _ -`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SheepId(ArcStr);

/// The path of a clip: relative to the flock's folder, inside it, without `..`, written with `/`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ClipPath(ArcStr);

/// The ids that were read so far. A million transitions name each of their sheep ten times or more.
#[derive(Debug, Default)]
pub(crate) struct KnownIds(HashSet<SheepId>);

/// The BLAKE3 digest of a clip's bytes, written `b3:` and 64 hex digits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ClipHash([u8; 32]);

/// Why a text is no such name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NameError {
    /// A fingerprint of another form.
    #[error("wanted `b3:` and 64 hex digits, found `{found}`")]
    Hash {
        /// As given.
        found: String,
    },
    /// An id with other characters, or too long, or empty.
    #[error("wanted 1 to 64 of `A-Z a-z 0-9 . _ -`, found `{found}`")]
    Id {
        /// As given.
        found: String,
    },
    /// A path that is empty, absolute, or leaves the folder.
    #[error("wanted a relative path inside the folder, without `..`, found `{found}`")]
    Path {
        /// As given.
        found: String,
    },
}

impl SheepId {
    /// The id `text`.
    ///
    /// # Errors
    /// [`NameError::Id`] if it is empty, longer than 64 bytes, or has other characters.
    pub fn new(text: &str) -> Result<Self, NameError> {
        let allowed = |b: u8| b.is_ascii_alphanumeric() || b"._-".contains(&b);
        if (1..=MAX_ID_BYTES).contains(&text.len()) && text.bytes().all(allowed) {
            Ok(Self(text.into()))
        } else {
            Err(NameError::Id { found: text.to_owned() })
        }
    }

    /// The id as text.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl KnownIds {
    /// The id `text`: the one in memory if it was read before.
    /// Errors: As [`SheepId::new`].
    pub(crate) fn id(&mut self, text: &str) -> Result<SheepId, NameError> {
        if let Some(known) = self.0.get(text) {
            return Ok(known.clone());
        }
        let new = SheepId::new(text)?;
        self.0.insert(new.clone());
        Ok(new)
    }
}

impl ClipPath {
    /// The path `text`.
    ///
    /// # Errors
    /// [`NameError::Path`] if it is empty, absolute, has `.`, `..` or empty parts, a backslash or a control character.
    pub fn new(text: &str) -> Result<Self, NameError> {
        let part_is_fine = |part: &[u8]| !matches!(part, b"" | b"." | b"..");
        let char_is_fine = |c: char| !c.is_control() && c != '\\';
        let byte_is_fine = |b: u8| (0x20..0x7f).contains(&b) && b != b'\\';
        // Almost every path is plain ASCII, and there may be a million.
        let chars_are_fine = text.bytes().all(byte_is_fine) || text.chars().all(char_is_fine);
        if chars_are_fine && text.as_bytes().split(|&b| b == b'/').all(part_is_fine) {
            Ok(Self(text.into()))
        } else {
            Err(NameError::Path { found: text.to_owned() })
        }
    }

    /// The path as it stands in the manifest.
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// The path inside `folder`.
    pub fn inside(&self, folder: &Path) -> PathBuf {
        folder.join(self.as_str())
    }
}

impl ClipHash {
    /// The fingerprint of `digest`.
    pub fn new(digest: [u8; 32]) -> Self {
        Self(digest)
    }

    /// Reads `b3:` and 64 hex digits.
    ///
    /// # Errors
    /// [`NameError::Hash`] if `text` has another form.
    pub fn parse(text: &str) -> Result<Self, NameError> {
        let refused = || NameError::Hash { found: text.to_owned() };
        let hex = text.strip_prefix("b3:").ok_or_else(refused)?;
        blake3::Hash::from_hex(hex).map(|hash| Self(*hash.as_bytes())).map_err(|_| refused())
    }

    /// The hash of everything that `reader` yields.
    ///
    /// # Errors
    /// The error of the reader.
    pub fn of(reader: impl std::io::Read) -> std::io::Result<Self> {
        let mut hasher = blake3::Hasher::new();
        hasher.update_reader(reader)?;
        Ok(Self(*hasher.finalize().as_bytes()))
    }
}

/// For look-ups by text: ids are equal, ordered and hashed as their texts are.
impl Borrow<str> for SheepId {
    fn borrow(&self) -> &str {
        &self.0
    }
}

impl Serialize for SheepId {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.0)
    }
}

impl<'de> Deserialize<'de> for SheepId {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Self::new(&String::deserialize(deserializer)?).map_err(D::Error::custom)
    }
}

impl Serialize for ClipPath {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.0)
    }
}

impl fmt::Display for SheepId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl fmt::Display for ClipPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl fmt::Display for ClipHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "b3:{}", blake3::Hash::from_bytes(self.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_have_plain_characters_only() {
        for fine in ["191.21054", "a", "A-b_c.9", &"x".repeat(64)] {
            assert_eq!(SheepId::new(fine).unwrap().as_str(), fine);
        }
        for bad in ["", "a b", "a/b", "ä", &"x".repeat(65)] {
            assert!(SheepId::new(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn an_id_that_is_read_again_is_not_in_memory_again() {
        let mut known = KnownIds::default();
        let (first, again) = (known.id("191.21054").unwrap(), known.id("191.21054").unwrap());
        assert!(std::ptr::eq(first.as_str(), again.as_str()));
        assert_ne!(first, known.id("191.2105").unwrap());
        assert!(known.id("a b").is_err());
    }

    #[test]
    fn clip_paths_cannot_leave_the_folder() {
        assert!(ClipPath::new("loops/a.mp4").is_ok());
        assert!(ClipPath::new("a..b/c...mp4").is_ok());
        for bad in ["", "/a", "../a", "a/../b", "a/..", "./a", "a//b", "a/", "a\\b", "a\0b"] {
            assert!(ClipPath::new(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_fingerprint_reads_back_as_written() {
        let hash = ClipHash::of(&b"a clip"[..]).unwrap();
        assert_eq!(ClipHash::parse(&hash.to_string()), Ok(hash));
        for bad in ["", "b3:", "b3:12", "9f86d0", &format!("{hash}0"), &hash.to_string().replace("b3", "b2")] {
            assert!(ClipHash::parse(bad).is_err(), "{bad}");
        }
    }
}

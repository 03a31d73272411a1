//! Public keys.
//!
//! Owns their id and their file format, which is minisign's: a comment, and the key in Base64. Trust is decided in `trust`.
//!
//! Start at [`PublicKey`].

use std::cmp::Ordering;
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use flock::excerpt;

use crate::limits;
use crate::signed::exact;

/// Algorithm, id, key.
const KEY: usize = 2 + KeyId::BYTES + 32;

/// The id of a key: eight bytes, which minisign writes as 16 capital hex digits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct KeyId([u8; Self::BYTES]);

/// A key that verifies signatures.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PublicKey {
    id: KeyId,
    line: String,
    verifier: minisign_verify::PublicKey,
}

/// Why a key could not be used.
#[derive(Debug, thiserror::Error)]
pub enum KeyError {
    /// The secret key could not be decrypted.
    #[error("wrong passphrase for the secret key `{path}`")]
    Locked {
        /// Its file.
        path: PathBuf,
    },
    /// Not a key.
    #[error("`{path}` is not a minisign {kind}")]
    Malformed {
        /// The file.
        path: PathBuf,
        /// What it should hold.
        kind: &'static str,
    },
    /// Others could read a secret.
    #[error("the secret key `{path}` can be read by others (mode {mode:04o}, wanted 0600)")]
    Open {
        /// Its file.
        path: PathBuf,
        /// Its permissions.
        mode: u32,
    },
    /// The file could not be read.
    #[error("cannot read key `{path}`")]
    Read {
        /// The file.
        path: PathBuf,
        /// The system error.
        source: io::Error,
    },
    /// Two keys of the same id.
    #[error("`{path}` has a different key with the same id {id}")]
    SameId {
        /// The second one's file.
        path: PathBuf,
        /// The id.
        id: KeyId,
    },
    /// The signing failed.
    #[error("cannot sign: {why}")]
    Sign {
        /// The error of the signer.
        why: String,
    },
    /// More keys than a unit looks at.
    #[error("`{path}` has more than {limit} keys")]
    TooMany {
        /// The folder.
        path: PathBuf,
        /// The most.
        limit: usize,
    },
    /// The file could not be written.
    #[error("cannot write key `{path}`")]
    Write {
        /// The file.
        path: PathBuf,
        /// The system error.
        source: io::Error,
    },
}

impl KeyId {
    pub(crate) const BYTES: usize = 8;

    /// The id that `bytes` begin with.
    pub(crate) fn of(bytes: &[u8]) -> Option<Self> {
        Some(Self(*bytes.first_chunk()?))
    }

    /// Reads 16 capital hex digits.
    pub fn parse(text: &str) -> Option<Self> {
        let canonical = text.len() == 2 * Self::BYTES && !text.bytes().any(|b| b.is_ascii_lowercase() || b == b'+');
        let number = if canonical { u64::from_str_radix(text, 16).ok()? } else { return None };
        Some(Self(number.to_le_bytes()))
    }
}

impl PublicKey {
    /// Reads a key: its line of Base64, or the two lines of its file.
    pub fn parse(text: &str) -> Option<Self> {
        let line = text.lines().find(|line| !line.starts_with("untrusted comment:"))?.trim();
        let raw = exact::<KEY>(line)?;
        let verifier = minisign_verify::PublicKey::from_base64(line).ok()?;
        Some(Self { id: KeyId::of(&raw[2..])?, line: line.to_owned(), verifier })
    }

    /// Reads the key in the file `path`.
    ///
    /// # Errors
    /// [`KeyError::Read`], or [`KeyError::Malformed`] if it is not a key.
    pub fn read(path: &Path) -> Result<Self, KeyError> {
        let refused = || KeyError::Malformed { path: path.to_owned(), kind: "public key" };
        let bytes = durable::read_plain(path, limits::PUBLIC_KEY)
            .map_err(|source| KeyError::Read { path: path.to_owned(), source })?;
        std::str::from_utf8(&bytes).ok().and_then(Self::parse).ok_or_else(refused)
    }

    /// What the key is called.
    pub fn id(&self) -> KeyId {
        self.id
    }

    /// The key in Base64, one line.
    pub fn line(&self) -> &str {
        &self.line
    }

    /// The text of its file.
    pub fn to_text(&self) -> String {
        format!("untrusted comment: minisign public key {}\n{}\n", self.id, self.line)
    }

    pub(crate) fn verifier(&self) -> &minisign_verify::PublicKey {
        &self.verifier
    }
}

/// By their lines, because ids may collide.
impl Ord for PublicKey {
    fn cmp(&self, other: &Self) -> Ordering {
        self.line.cmp(&other.line)
    }
}

impl PartialOrd for PublicKey {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl fmt::Display for KeyId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016X}", u64::from_le_bytes(self.0))
    }
}

impl serde::Serialize for KeyId {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> serde::Deserialize<'de> for KeyId {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        let refused = || serde::de::Error::custom(format!("wanted 16 capital hex digits, found `{}`", excerpt(&text)));
        Self::parse(&text).ok_or_else(refused)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::secret::tests::artist;

    #[test]
    fn a_key_reads_back_as_written_and_is_called_as_minisign_calls_it() {
        let key = artist().public();
        assert_eq!(PublicKey::parse(&key.to_text()), Some(key.clone()));
        assert_eq!(PublicKey::parse(key.line()), Some(key.clone()));
        assert_eq!(KeyId::parse(&key.id().to_string()), Some(key.id()));
        let public = minisign::PublicKey::from_base64(key.line()).unwrap();
        assert!(public.to_box().unwrap().to_string().contains(&key.id().to_string()));
    }

    #[test]
    fn what_is_no_key_is_none() {
        let line = artist().public().line().to_owned();
        for bad in ["", "\n", "RWQ", &line[1..], &format!("{line}A"), &line[..55], &"A".repeat(1000)] {
            assert_eq!(PublicKey::parse(bad), None, "{bad}");
        }
        for bad in ["", "0", "00000000000000ff", "+0000000000000FF", "0000000000000000F"] {
            assert_eq!(KeyId::parse(bad), None, "{bad}");
        }
    }
}

//! Why a bundle, or a part of it, was refused.
//!
//! Owns the errors of untrusted data. A refusal changes nothing.

use std::fmt;
use std::io;

use crate::key::KeyId;
use crate::names::{Addressees, FilePath, NameError, ObjectId, Sequence, UnitId};

/// A part of a bundle.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Part {
    /// The list of files.
    Contents,
    /// `flock.toml`.
    Flock,
    /// One object.
    Object(ObjectId),
    /// The seal.
    Seal,
    /// Signed settings.
    Settings,
    /// One or all statements of keys about keys.
    Statement,
}

/// Why a bundle was refused. Nothing was changed.
#[derive(Debug, thiserror::Error)]
pub enum Refusal {
    /// The data differ from what was signed.
    #[error("{part} of the bundle is damaged: expected {expected}, found {found}")]
    Damaged {
        /// Which.
        part: Part,
        /// Its digest as signed.
        expected: ObjectId,
        /// The digest of what was read.
        found: ObjectId,
    },
    /// For all units, but this unit has bundles of its own.
    #[error("the bundle is for every unit, but this unit takes only bundles for `{unit}` since it was given one")]
    ForEverybody {
        /// This unit.
        unit: UnitId,
    },
    /// The signature does not match the key that it names.
    #[error("{part} of the bundle has an invalid signature of key {signer}")]
    Forged {
        /// Which.
        part: Part,
        /// The key that it names.
        signer: KeyId,
    },
    /// For other units.
    #[error("the bundle is for `{}`, this unit is `{unit}`", .addressees.summary())]
    ForOthers {
        /// For whom it is.
        addressees: Addressees,
        /// This unit.
        unit: UnitId,
    },
    /// Longer or shorter than the seal says.
    #[error(
        "{part} of the bundle is {} than its seal says: expected {expected} bytes, read {found}",
        if .found > .expected { "longer" } else { "shorter" }
    )]
    Length {
        /// Which.
        part: Part,
        /// Its bytes, as signed.
        expected: u64,
        /// The bytes that were read: at most one more than expected.
        found: u64,
    },
    /// A line that is not as it must be.
    #[error("{part} of the bundle, line {line}: wanted {wanted}, found `{found}`")]
    Line {
        /// Which.
        part: Part,
        /// From 1, without the lines of the signature.
        line: usize,
        /// The expected value.
        wanted: &'static str,
        /// An excerpt of the value found.
        found: String,
    },
    /// It has failed its trial on this unit before.
    #[error("the bundle with sequence {sequence} failed its trial on this unit before")]
    MarkedBad {
        /// Its sequence.
        sequence: Sequence,
    },
    /// The flock names a file that is not in the bundle.
    #[error("the flock names `{path}`, which is not in the bundle")]
    MissingFile {
        /// The file.
        path: String,
    },
    /// A name that is none.
    #[error("{part} of the bundle, line {line}")]
    Name {
        /// Which.
        part: Part,
        /// From 1, without the lines of the signature.
        line: usize,
        /// The cause.
        source: NameError,
    },
    /// The flock is invalid.
    #[error("the flock of the bundle cannot be read")]
    NotAFlock {
        /// Why not.
        source: flock::ManifestError,
    },
    /// Not in the form of a signed text.
    #[error("{part} of the bundle is not signed: {why}")]
    NotSigned {
        /// Which.
        part: Part,
        /// The missing path.
        why: &'static str,
    },
    /// Not newer than the last bundle of this key.
    #[error("the bundle has sequence {sequence}, but this unit has already played {floor} of key {signer}")]
    Older {
        /// Its sequence.
        sequence: Sequence,
        /// The highest that this unit has played.
        floor: Sequence,
        /// Whose.
        signer: KeyId,
    },
    /// A duplicate path, one out of order, or one that is both file and folder.
    #[error("{part} of the bundle, line {line}: `{path}` is a duplicate, both file and folder, or out of order")]
    Order {
        /// Which.
        part: Part,
        /// From 1.
        line: usize,
        /// The path.
        path: FilePath,
    },
    /// The statements of a key exceed their quota.
    #[error("key {signer} has used up its quota: {used} of {limit} {things}")]
    Quota {
        /// The key.
        signer: KeyId,
        /// How much was said already.
        used: usize,
        /// The most.
        limit: usize,
        /// Of what.
        things: &'static str,
    },
    /// It could not be read.
    #[error("cannot read {part} of the bundle")]
    Read {
        /// Which.
        part: Part,
        /// The system error.
        source: io::Error,
    },
    /// Signed by a revoked key.
    #[error("{part} of the bundle is signed by key {signer}, which was revoked")]
    RevokedKey {
        /// Which.
        part: Part,
        /// The key.
        signer: KeyId,
    },
    /// Above its size limit.
    #[error("{part} of the bundle is larger than {limit} bytes")]
    TooLarge {
        /// Which.
        part: Part,
        /// The most, in bytes.
        limit: u64,
    },
    /// Above a limit on counts.
    #[error("{part} of the bundle has more than {limit} {things}")]
    TooMany {
        /// Which.
        part: Part,
        /// The most.
        limit: usize,
        /// Of what.
        things: &'static str,
    },
    /// Signed by a key that is not trusted here.
    #[error("{part} of the bundle is signed by key {signer}, which is not trusted (trusted: {})", list(.trusted))]
    UnknownKey {
        /// Which.
        part: Part,
        /// The key.
        signer: KeyId,
        /// Those that are trusted.
        trusted: Vec<KeyId>,
    },
    /// The statements about keys that the seal expects are missing.
    #[error(
        "the statements about keys are missing or outdated: the seal expects {expected}, found {}",
        .found.as_ref().map_or_else(|| "nothing".to_owned(), ObjectId::to_string)
    )]
    Withheld {
        /// Their digest as signed.
        expected: ObjectId,
        /// The digest of what was read; `None` if there is nothing.
        found: Option<ObjectId>,
    },
}

impl Refusal {
    /// Whether reading failed, instead of a check: another attempt may succeed.
    pub fn is_io(&self) -> bool {
        matches!(self, Self::Read { .. })
    }
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Contents => f.write_str("the list of files"),
            Self::Flock => f.write_str("`flock.toml`"),
            Self::Object(id) => write!(f, "object {id}"),
            Self::Seal => f.write_str("the seal"),
            Self::Settings => f.write_str("the file of settings"),
            Self::Statement => f.write_str("a statement about keys"),
        }
    }
}

fn list(keys: &[KeyId]) -> String {
    let names: Vec<String> = keys.iter().map(KeyId::to_string).collect();
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}

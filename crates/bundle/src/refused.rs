//! Why a bundle, or a part of it, was refused.
//!
//! Owns the errors of everything that comes from outside. Never says what to do with a refusal: nothing was changed.

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
    /// The signed letter in front of it all.
    Seal,
    /// A word of one key about another, or all of them.
    Statement,
}

/// Why a bundle was refused. Nothing was changed.
#[derive(Debug, thiserror::Error)]
pub enum Refused {
    /// What is read differs from what was signed.
    #[error("{part} of the bundle is damaged: expected {expected}, found {found}")]
    Damaged {
        /// Which.
        part: Part,
        /// Its digest as signed.
        expected: ObjectId,
        /// The digest of what was read.
        found: ObjectId,
    },
    /// For every unit, on one that has its own.
    #[error("the bundle is for every unit, this unit takes only those for `{unit}` since it was given one")]
    ForEverybody {
        /// This unit.
        unit: UnitId,
    },
    /// The signature is not that of the key that it names.
    #[error("{part} of the bundle is not what key {signer} signed")]
    Forged {
        /// Which.
        part: Part,
        /// The key that it names.
        signer: KeyId,
    },
    /// For other units.
    #[error("the bundle is for `{}`, this unit is `{unit}`", .addressees.told())]
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
        /// The bytes that were read. No more than one beyond those expected is asked for.
        found: u64,
    },
    /// A line that is not as it must be.
    #[error("{part} of the bundle, line {line}: wanted {wanted}, found `{found}`")]
    Line {
        /// Which.
        part: Part,
        /// From 1, without the lines of the signature.
        line: usize,
        /// What should stand there.
        wanted: &'static str,
        /// What does, cut short.
        found: String,
    },
    /// Tried on this unit before, and lost.
    #[error("the bundle with sequence {sequence} was tried on this unit and did not play")]
    MarkedBad {
        /// Its sequence.
        sequence: Sequence,
    },
    /// Names a file that it does not carry.
    #[error("the flock names `{path}`, which the bundle does not carry")]
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
        /// What is wrong with it.
        source: NameError,
    },
    /// The flock cannot be read, whoever signed it.
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
        /// What is missing.
        why: &'static str,
    },
    /// Not newer than what this unit has seen.
    #[error("the bundle has sequence {sequence}, and key {signer} has already brought this unit {floor}")]
    Older {
        /// Its sequence.
        sequence: Sequence,
        /// The highest that this unit has played.
        floor: Sequence,
        /// Whose.
        signer: KeyId,
    },
    /// A path that stands twice, or before its turn, or in two roles.
    #[error("{part} of the bundle, line {line}: `{path}` stands twice, in two roles, or out of order")]
    Order {
        /// Which.
        part: Part,
        /// From 1.
        line: usize,
        /// The path.
        path: FilePath,
    },
    /// A key has said as much about other keys as it may.
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
        /// What the world says.
        source: io::Error,
    },
    /// Signed by a key that was called back.
    #[error("{part} of the bundle is signed by key {signer}, which was revoked")]
    RevokedKey {
        /// Which.
        part: Part,
        /// The key.
        signer: KeyId,
    },
    /// Larger than anything of its kind may be.
    #[error("{part} of the bundle is larger than {limit} bytes")]
    TooLarge {
        /// Which.
        part: Part,
        /// The most, in bytes.
        limit: u64,
    },
    /// More of something than there may be.
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
    #[error("{part} of the bundle is signed by key {signer}, trusted are {}", list(.trusted))]
    UnknownKey {
        /// Which.
        part: Part,
        /// The key.
        signer: KeyId,
        /// Those that are trusted.
        trusted: Vec<KeyId>,
    },
    /// Without the statements about keys that its seal expects.
    #[error(
        "what keys say about keys is withheld: the seal expects {expected}, found {}",
        .found.as_ref().map_or_else(|| "nothing".to_owned(), ObjectId::to_string)
    )]
    Withheld {
        /// Their digest as signed.
        expected: ObjectId,
        /// The digest of what was read; `None` if there is nothing.
        found: Option<ObjectId>,
    },
}

impl Refused {
    /// Whether reading failed, and not a check of the bundle: another attempt may succeed.
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
            Self::Statement => f.write_str("a statement about keys"),
        }
    }
}

fn list(keys: &[KeyId]) -> String {
    let names: Vec<String> = keys.iter().map(KeyId::to_string).collect();
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}

//! The seal: the signed head of a bundle.
//!
//! Owns its fields and their only spelling. It is small (see [`crate::limits`]), so that checking for a new bundle is
//! cheap: the bytes are compared with those of the last time. It contains the digest of the list of files, so that one
//! signature covers everything; many units may share that list, which is parsed by [`crate::Contents`].
//!
//! ```text
//! dreams seal 1
//! flock aurora
//! units lobby stairs
//! sequence 7
//! created 2026-03-01T12:00:00Z
//! contents 81234 3fa91c...
//! statements 1432 77b0e4...
//! ```
//!
//! The last line is missing if the seal expects no statements about keys.
//!
//! Start at [`UnverifiedSeal::verify`], the only constructor of a [`Seal`].
#![allow(
    clippy::missing_errors_doc,
    reason = "a function that does not say otherwise fails with `Refusal::Read` or `Refusal::TooLarge`"
)]

use std::io::Read;

use crate::contents::{Contents, VerifiedBundle};
use crate::envelope::{
    SealHeader, SignError, object, open_text, read, read_expected, signed, statements, statements_text,
};
use crate::key::KeyId;
use crate::limits;
use crate::lines::Lines;
use crate::names::{Addressees, ObjectId, Sequence, UnitId};
use crate::refusal::{Part, Refusal};
use crate::secret::SecretKey;
use crate::signed::SignedText;
use crate::source::Source;
use crate::trust::Trust;

/// The first line of a seal.
const HEADING: &str = "dreams seal 1";

/// The bytes of a seal before verification. This is the only way from it to files:
///
/// ```
/// # use bundle::{Contents, Refusal, Source, Trust, UnverifiedSeal};
/// fn files(seal: UnverifiedSeal, trust: &Trust, from: &mut dyn Source) -> Result<Contents, Refusal> {
///     Ok(seal.verify(trust)?.fetch(from)?.contents().clone())
/// }
/// ```
///
/// Neither the signature nor the list of files can be skipped:
///
/// ```compile_fail
/// # use bundle::{Contents, Refusal, Source, Trust, UnverifiedSeal};
/// fn files(seal: UnverifiedSeal, trust: &Trust, from: &mut dyn Source) -> Result<Contents, Refusal> {
///     Ok(seal.fetch(from)?.contents().clone())
/// }
/// ```
///
/// ```compile_fail
/// # use bundle::{Contents, Refusal, Source, Trust, UnverifiedSeal};
/// fn files(seal: UnverifiedSeal, trust: &Trust, from: &mut dyn Source) -> Result<Contents, Refusal> {
///     Ok(seal.verify(trust)?.contents().clone())
/// }
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnverifiedSeal(Vec<u8>);

/// The fields of a seal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SealBody {
    /// The name of the flock: 1 to 128 bytes on one line.
    pub flock: String,
    /// For whom it is.
    pub addressees: Addressees,
    /// Its number among the bundles of this key.
    pub sequence: Sequence,
    /// When it was made, as `2026-03-01T12:00:00Z`. For people only: units do not check it.
    pub created: String,
    /// The list of files.
    pub contents: ObjectId,
    /// The list's size in bytes.
    pub contents_size: u64,
    /// The statements about keys that a unit must have learned before, and their size in bytes.
    pub statements: Option<(ObjectId, u64)>,
}

/// A seal signed by a trusted key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Seal {
    letter: SealBody,
    signer: KeyId,
    bytes: Vec<u8>,
}

impl UnverifiedSeal {
    /// Reads the seal of `source` for `unit`, or else the one for all units.
    pub fn open(source: &mut dyn Source, unit: &UnitId) -> Result<Self, Refusal> {
        let own = Addressees::of([unit.clone()]);
        match Self::addressed(source, &own) {
            Err(Refusal::Read { source: error, .. }) if error.kind() == std::io::ErrorKind::NotFound => {
                Self::addressed(source, &Addressees::Anyone)
            }
            read => read,
        }
    }

    /// Reads the seal of `source` for the first of `addressees`.
    pub fn addressed(source: &mut dyn Source, addressees: &Addressees) -> Result<Self, Refusal> {
        let stem = addressees.file_stems().first().copied().unwrap_or_default();
        read(source, &path(stem)).map(Self)
    }

    /// The seal in `bytes`.
    pub fn new(bytes: impl Into<Vec<u8>>) -> Self {
        Self(bytes.into())
    }

    /// Its bytes; if they are unchanged there is no new bundle.
    pub fn bytes(&self) -> &[u8] {
        &self.0
    }

    /// Verifies the signature, and then parses the text.
    ///
    /// # Errors
    /// [`Refusal`] if no trusted key signed it, or it is invalid.
    pub fn verify(self, trust: &Trust) -> Result<Seal, Refusal> {
        let (signer, text) = open_text(&self.0, trust, HEADING)?;
        let letter = SealBody::parse(text)?;
        Ok(Seal { letter, signer, bytes: self.0 })
    }
}

impl SealBody {
    /// Signs the fields; returns the bytes of the seal's file.
    ///
    /// # Errors
    /// [`SignError`] if units would refuse it, or signing fails.
    pub fn sign(&self, key: &SecretKey) -> Result<Vec<u8>, SignError> {
        let text = self.to_text();
        let read = Self::parse(&text).map_err(SignError::Refused)?;
        debug_assert_eq!(&read, self, "a letter reads back as written");
        let comment = format!("flock {} sequence {}", self.flock, self.sequence);
        signed(key, &comment, &text)
    }

    fn to_text(&self) -> String {
        let address = SealHeader::to_text(&self.addressees, self.sequence, &self.created);
        let statements = statements_text(self.statements);
        let Self { flock, contents, contents_size, .. } = self;
        format!("{HEADING}\nflock {flock}\n{address}contents {contents_size} {contents}\n{statements}")
    }

    fn parse(text: &str) -> Result<Self, Refusal> {
        let mut lines = Lines::new(Part::Seal, text);
        lines.expect_line(HEADING)?;
        let wanted = "`flock` and a name of 1 to 128 bytes";
        let flock = lines.value("flock", wanted)?;
        if !(1..=limits::FLOCK_NAME).contains(&flock.len()) || flock.chars().any(char::is_control) {
            return Err(lines.wrong_line(wanted, flock));
        }
        let flock = flock.to_owned();
        let SealHeader { addressees, sequence, created } = SealHeader::parse(&mut lines)?;
        let (contents, contents_size) = object(&mut lines, "contents", "`contents`, a size and a digest")?;
        if contents_size > limits::CONTENTS {
            return Err(Refusal::TooLarge { part: Part::Contents, limit: limits::CONTENTS });
        }
        let statements = statements(&mut lines)?;
        lines.end()?;
        Ok(Self { flock, addressees, sequence, created, contents, contents_size, statements })
    }
}

impl Seal {
    /// A seal that was verified when its generation was installed, read from the unit's disk.
    pub(crate) fn kept(bytes: Vec<u8>, signer: KeyId, expected: ObjectId) -> Result<Self, Refusal> {
        let found = ObjectId::of(&bytes);
        if found != expected {
            return Err(Refusal::Damaged { part: Part::Seal, expected, found });
        }
        let text = SignedText::open(&Part::Seal, &bytes)?.kept(&Part::Seal)?;
        Ok(Self { letter: SealBody::parse(text)?, signer, bytes })
    }

    /// What it says.
    pub fn letter(&self) -> &SealBody {
        &self.letter
    }

    /// Who says so.
    pub fn signer(&self) -> KeyId {
        self.signer
    }

    /// The bytes of its file.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The digest of those bytes, which identifies the bundle.
    pub fn id(&self) -> ObjectId {
        ObjectId::of(&self.bytes)
    }

    /// Reads the expected statements about keys from `source`: the caller must learn them, and verify the seal again.
    /// Empty if it expects none.
    ///
    /// # Errors
    /// [`Refusal::Withheld`] if `source` lacks them, or [`Refusal::Read`].
    pub fn expected_statements(&self, source: &mut dyn Source) -> Result<Vec<u8>, Refusal> {
        read_expected(self.letter.statements, source)
    }

    /// Reads the list of files from `source` and verifies it.
    ///
    /// # Errors
    /// [`Refusal`] if it cannot be read, or its length, digest or contents are wrong.
    pub fn fetch(self, source: &mut dyn Source) -> Result<VerifiedBundle, Refusal> {
        let (id, size) = (self.letter.contents, self.letter.contents_size);
        let read = source.object(&id, size, 0).and_then(|reader| {
            let mut bytes = Vec::new();
            reader.take(size + 1).read_to_end(&mut bytes)?;
            Ok(bytes)
        });
        let bytes = read.map_err(|source| Refusal::Read { part: Part::Contents, source })?;
        self.open(bytes)
    }

    /// Verifies the list of files in `bytes`, and then parses it.
    ///
    /// # Errors
    /// [`Refusal`] if its length, digest or contents are wrong.
    pub fn open(self, bytes: Vec<u8>) -> Result<VerifiedBundle, Refusal> {
        let (expected, found) = (self.letter.contents_size, bytes.len() as u64);
        if found != expected {
            return Err(Refusal::Length { part: Part::Contents, expected, found });
        }
        let (expected, found) = (self.letter.contents, ObjectId::of(&bytes));
        if found != expected {
            return Err(Refusal::Damaged { part: Part::Contents, expected, found });
        }
        let contents = Contents::parse(&bytes)?;
        Ok(VerifiedBundle::new(self, contents, bytes))
    }
}

/// The path of the seal with this file stem in a bundle.
pub fn path(stem: &str) -> String {
    format!("seals/{stem}.seal")
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A seal for all units with this sequence, which expects no statements.
    pub(crate) fn letter(sequence: u64) -> SealBody {
        SealBody {
            flock: "aurora".to_owned(),
            addressees: Addressees::Anyone,
            sequence: Sequence(sequence),
            created: "2026-03-01T12:00:00Z".to_owned(),
            contents: ObjectId::of(b"list"),
            contents_size: 4,
            statements: None,
        }
    }
}

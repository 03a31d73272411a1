//! The seal: the signed letter in front of a bundle.
//!
//! Owns what it says and the one spelling of it. It is small (see [`crate::limits`]): who looks for news reads it, sees
//! the same bytes as last time, and goes home. It names the list of files by its digest, so that one signature covers
//! everything; many units may share that list. Never reads the list: [`crate::Contents`] does.
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
//! The last line is left out if there are no statements about keys that a unit should know before it takes the bundle.
//!
//! Start at [`Unverified::verify`], which is the only way to a [`Seal`].

use std::io::Read;

use crate::contents::{Contents, Verified};
use crate::envelope::{Address, SignError, expected, object, opened, read, signed, statements, statements_text};
use crate::key::KeyId;
use crate::limits;
use crate::lines::Lines;
use crate::names::{Addressees, ObjectId, Sequence, UnitId};
use crate::refused::{Part, Refused};
use crate::secret::SecretKey;
use crate::signed::Signed;
use crate::source::Source;
use crate::trust::Trust;

/// The first line of a seal.
const HEADING: &str = "dreams seal 1";

/// The bytes of a seal, of which nothing is known yet. It leads to files by one way only:
///
/// ```
/// # use bundle::{Contents, Refused, Source, Trust, Unverified};
/// fn files(seal: Unverified, trust: &Trust, from: &mut dyn Source) -> Result<Contents, Refused> {
///     Ok(seal.verify(trust)?.fetch(from)?.contents().clone())
/// }
/// ```
///
/// There is none around the signature, nor around the list of files:
///
/// ```compile_fail
/// # use bundle::{Contents, Refused, Source, Trust, Unverified};
/// fn files(seal: Unverified, trust: &Trust, from: &mut dyn Source) -> Result<Contents, Refused> {
///     Ok(seal.fetch(from)?.contents().clone())
/// }
/// ```
///
/// ```compile_fail
/// # use bundle::{Contents, Refused, Source, Trust, Unverified};
/// fn files(seal: Unverified, trust: &Trust, from: &mut dyn Source) -> Result<Contents, Refused> {
///     Ok(seal.verify(trust)?.contents().clone())
/// }
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unverified(Vec<u8>);

/// What an artist says in front of a bundle.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Letter {
    /// What the artist calls the flock: 1 to 128 bytes on one line.
    pub flock: String,
    /// For whom it is.
    pub addressees: Addressees,
    /// Its number among the bundles of this key.
    pub sequence: Sequence,
    /// When it was made, as `2026-03-01T12:00:00Z`. For people only: no unit asks what time it is.
    pub created: String,
    /// The list of files.
    pub contents: ObjectId,
    /// The list's size in bytes.
    pub contents_size: u64,
    /// What keys say about keys, which whoever takes the bundle must know, and its size in bytes.
    pub statements: Option<(ObjectId, u64)>,
}

/// A letter that a trusted key has signed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Seal {
    letter: Letter,
    signer: KeyId,
    bytes: Vec<u8>,
}

impl Unverified {
    /// Reads the seal that `source` has for `unit`, or else its seal for everybody.
    ///
    /// # Errors
    /// [`Refused::Read`], or [`Refused::TooLarge`].
    pub fn open(source: &mut dyn Source, unit: &UnitId) -> Result<Self, Refused> {
        let own = Addressees::of([unit.clone()]);
        match Self::addressed(source, &own) {
            Err(Refused::Read { source: error, .. }) if error.kind() == std::io::ErrorKind::NotFound => {
                Self::addressed(source, &Addressees::Anyone)
            }
            read => read,
        }
    }

    /// Reads the seal that `source` has for the first of `addressees`.
    ///
    /// # Errors
    /// [`Refused::Read`], or [`Refused::TooLarge`].
    pub fn addressed(source: &mut dyn Source, addressees: &Addressees) -> Result<Self, Refused> {
        let stem = addressees.stems().first().copied().unwrap_or_default();
        read(source, &path(stem)).map(Self)
    }

    /// The seal in `bytes`, wherever they come from.
    pub fn new(bytes: impl Into<Vec<u8>>) -> Self {
        Self(bytes.into())
    }

    /// Its bytes: if they are those of the last time, there is no news.
    pub fn bytes(&self) -> &[u8] {
        &self.0
    }

    /// Checks the signature, and only then reads what it says.
    ///
    /// # Errors
    /// [`Refused`] if nobody trusted signed it, or it says nothing that makes sense.
    pub fn verify(self, trust: &Trust) -> Result<Seal, Refused> {
        let (signer, text) = opened(&self.0, trust, HEADING)?;
        let letter = Letter::parse(text)?;
        Ok(Seal { letter, signer, bytes: self.0 })
    }
}

impl Letter {
    /// Signs the letter: the bytes of the seal's file.
    ///
    /// # Errors
    /// [`Refused`] if it says what no unit would take; [`crate::KeyError::Sign`] within.
    pub fn sign(&self, key: &SecretKey) -> Result<Vec<u8>, SignError> {
        let text = self.to_text();
        let read = Self::parse(&text).map_err(SignError::Refused)?;
        debug_assert_eq!(&read, self, "a letter reads back as written");
        let comment = format!("flock {} sequence {}", self.flock, self.sequence);
        signed(key, &comment, &text)
    }

    fn to_text(&self) -> String {
        let address = Address::to_text(&self.addressees, self.sequence, &self.created);
        let statements = statements_text(self.statements);
        let Self { flock, contents, contents_size, .. } = self;
        format!("{HEADING}\nflock {flock}\n{address}contents {contents_size} {contents}\n{statements}")
    }

    fn parse(text: &str) -> Result<Self, Refused> {
        let mut lines = Lines::new(Part::Seal, text);
        lines.exactly(HEADING)?;
        let wanted = "`flock` and a name of 1 to 128 bytes";
        let flock = lines.value("flock", wanted)?;
        if !(1..=limits::FLOCK_NAME).contains(&flock.len()) || flock.chars().any(char::is_control) {
            return Err(lines.unlike(wanted, flock));
        }
        let flock = flock.to_owned();
        let Address { addressees, sequence, created } = Address::parse(&mut lines)?;
        let (contents, contents_size) = object(&mut lines, "contents", "`contents`, a size and a digest")?;
        if contents_size > limits::CONTENTS {
            return Err(Refused::TooLarge { part: Part::Contents, limit: limits::CONTENTS });
        }
        let statements = statements(&mut lines)?;
        lines.end()?;
        Ok(Self { flock, addressees, sequence, created, contents, contents_size, statements })
    }
}

impl Seal {
    /// The seal that was verified when its generation was installed, read again from the unit's own disk.
    pub(crate) fn kept(bytes: Vec<u8>, signer: KeyId, expected: ObjectId) -> Result<Self, Refused> {
        let found = ObjectId::of(&bytes);
        if found != expected {
            return Err(Refused::Damaged { part: Part::Seal, expected, found });
        }
        let text = Signed::open(&Part::Seal, &bytes)?.kept(&Part::Seal)?;
        Ok(Self { letter: Letter::parse(text)?, signer, bytes })
    }

    /// What it says.
    pub fn letter(&self) -> &Letter {
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

    /// The digest of those bytes: what tells this very bundle from all others.
    pub fn id(&self) -> ObjectId {
        ObjectId::of(&self.bytes)
    }

    /// Reads from `source` the statements about keys that the seal expects: whoever takes the bundle must learn them, and
    /// verify the seal again. Empty if it expects none.
    ///
    /// # Errors
    /// [`Refused::Withheld`] if `source` has none or others, or [`Refused::Read`].
    pub fn expected_statements(&self, source: &mut dyn Source) -> Result<Vec<u8>, Refused> {
        expected(self.letter.statements, source)
    }

    /// Reads the list of files from `source` and checks it against what was signed.
    ///
    /// # Errors
    /// [`Refused`] if it cannot be read, has another length or is another list, or one that breaks a limit.
    pub fn fetch(self, source: &mut dyn Source) -> Result<Verified, Refused> {
        let (id, size) = (self.letter.contents, self.letter.contents_size);
        let read = source.object(&id, size, 0).and_then(|reader| {
            let mut bytes = Vec::new();
            reader.take(size + 1).read_to_end(&mut bytes)?;
            Ok(bytes)
        });
        let bytes = read.map_err(|source| Refused::Read { part: Part::Contents, source })?;
        self.open(bytes)
    }

    /// Checks the list of files in `bytes` against what was signed, and only then reads it.
    ///
    /// # Errors
    /// [`Refused`] if it has another length or is another list, or one that breaks a limit.
    pub fn open(self, bytes: Vec<u8>) -> Result<Verified, Refused> {
        let (expected, found) = (self.letter.contents_size, bytes.len() as u64);
        if found != expected {
            return Err(Refused::Length { part: Part::Contents, expected, found });
        }
        let (expected, found) = (self.letter.contents, ObjectId::of(&bytes));
        if found != expected {
            return Err(Refused::Damaged { part: Part::Contents, expected, found });
        }
        let contents = Contents::parse(&bytes)?;
        Ok(Verified::new(self, contents, bytes))
    }
}

/// Where the seal for the unit with this stem lies in a bundle.
pub fn path(stem: &str) -> String {
    format!("seals/{stem}.seal")
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A letter to everybody with this number, which expects no statements.
    pub(crate) fn letter(sequence: u64) -> Letter {
        Letter {
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

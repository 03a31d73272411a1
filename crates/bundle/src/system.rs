//! A signed system for transfer to units.
//!
//! Owns its seal and its only spelling. A system lies beside the flocks of a bundle, with the same kinds of keys and
//! addressees; its two halves are objects like others: the start file, and the root with its hash tree. The seal names
//! both, so there is no list of files. A flock's seal is not accepted as a system's. The updater writes the slot.
//!
//! ```text
//! dreams system 1
//! version 0.2.0
//! units *
//! sequence 8
//! created 2026-03-01T12:00:00Z
//! start 15203328 3fa91c...
//! root 154742784 9f86d0...
//! statements 1432 77b0e4...
//! ```
//!
//! The last line is optional, as in a flock's seal.
//!
//! Start at [`UnverifiedSystem::verify`], the only constructor of a [`System`].
#![allow(
    clippy::missing_errors_doc,
    reason = "a function that does not say otherwise fails with `Refusal::Read` or `Refusal::TooLarge`"
)]

use std::io::{self, ErrorKind};

use crate::contents::FileEntry;
use crate::envelope::{
    SealHeader, SignError, object, open_text, own_or_common, read, read_addressed, read_expected, signed, statements,
    statements_text,
};
use crate::key::KeyId;
use crate::limits;
use crate::lines::Lines;
use crate::names::{Addressees, FilePath, ObjectId, Sequence, UnitId, Version};
use crate::refusal::{Part, Refusal};
use crate::secret::SecretKey;
use crate::source::Source;
use crate::trust::Trust;

/// The first line of a system's seal.
const HEADING: &str = "dreams system 1";
/// The halves of a system, as its seal names them.
const START: &str = "start";
const ROOT: &str = "root";

/// The bytes of a system's seal before verification.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnverifiedSystem(Vec<u8>);

/// The fields of a system's seal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Release {
    /// Its version: a unit accepts only a higher one than its own.
    pub version: Version,
    /// For whom it is.
    pub addressees: Addressees,
    /// Its sequence number among the systems of its key.
    pub sequence: Sequence,
    /// When it was signed, as `2026-03-01T12:00:00Z`. For people only.
    pub created: String,
    /// The start file, and its size in bytes.
    pub start: (ObjectId, u64),
    /// The verified root, the tree of its hashes included, and its size in bytes.
    pub root: (ObjectId, u64),
    /// The statements about keys that a unit must have learned before, and their size in bytes.
    pub statements: Option<(ObjectId, u64)>,
}

/// A system signed by a trusted key. Only this type has halves.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct System {
    release: Release,
    signer: KeyId,
    bytes: Vec<u8>,
}

impl UnverifiedSystem {
    /// Reads the system's seal of `source` for `unit`, or else the one for all units; `None` if it has neither.
    pub fn open(source: &mut dyn Source, unit: &UnitId) -> Result<Option<Self>, Refusal> {
        own_or_common(unit, |addressees| Self::addressed(source, addressees))
    }

    /// Reads the system's seal of `source` for the first of `addressees`; `None` if it has none.
    pub fn addressed(source: &mut dyn Source, addressees: &Addressees) -> Result<Option<Self>, Refusal> {
        Ok(read_addressed(addressees, |stem| read(source, &path(stem)))?.map(Self))
    }

    /// The seal in `bytes`.
    pub fn new(bytes: impl Into<Vec<u8>>) -> Self {
        Self(bytes.into())
    }

    /// Verifies the signature, and then parses the text.
    ///
    /// # Errors
    /// [`Refusal`] if no trusted key signed it, or it is invalid.
    pub fn verify(self, trust: &Trust) -> Result<System, Refusal> {
        let (signer, text) = open_text(&self.0, trust, HEADING)?;
        let release = Release::parse(text)?;
        Ok(System { release, signer, bytes: self.0 })
    }
}

impl Release {
    /// Signs the fields; returns the bytes of the seal's file.
    ///
    /// # Errors
    /// [`SignError`] if units would refuse it, or signing fails.
    pub fn sign(&self, key: &SecretKey) -> Result<Vec<u8>, SignError> {
        let text = self.to_text();
        let read = Self::parse(&text).map_err(SignError::Refused)?;
        debug_assert_eq!(&read, self, "a release reads back as written");
        let comment = format!("system {} sequence {}", self.version, self.sequence);
        signed(key, &comment, &text)
    }

    fn to_text(&self) -> String {
        let Self { version, addressees, sequence, created, start, root, statements } = self;
        let (address, statements) = (SealHeader::to_text(addressees, *sequence, created), statements_text(*statements));
        format!(
            "{HEADING}\nversion {version}\n{address}{START} {} {}\n{ROOT} {} {}\n{statements}",
            start.1, start.0, root.1, root.0
        )
    }

    fn parse(text: &str) -> Result<Self, Refusal> {
        let mut lines = Lines::new(Part::Seal, text);
        lines.expect_line(HEADING)?;
        let version = lines.value("version", "`version` and a version")?;
        let version = Version::parse(version).map_err(|error| lines.bad_name(error))?;
        let SealHeader { addressees, sequence, created } = SealHeader::parse(&mut lines)?;
        let start = half(&mut lines, START, "`start`, a size and a digest")?;
        let root = half(&mut lines, ROOT, "`root`, a size and a digest")?;
        let statements = statements(&mut lines)?;
        lines.end()?;
        Ok(Self { version, addressees, sequence, created, start, root, statements })
    }
}

impl System {
    /// What is said of it.
    pub fn release(&self) -> &Release {
        &self.release
    }

    /// Who says so.
    pub fn signer(&self) -> KeyId {
        self.signer
    }

    /// The bytes of its seal.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Reads the expected statements about keys from `source`, as
    /// [`Seal::expected_statements`](crate::Seal::expected_statements) does.
    ///
    /// # Errors
    /// [`Refusal::Withheld`] if `source` lacks them, or [`Refusal::Read`].
    pub fn expected_statements(&self, source: &mut dyn Source) -> Result<Vec<u8>, Refusal> {
        read_expected(self.release.statements, source)
    }

    /// The objects that it consists of: both halves, the smaller one first.
    pub fn halves(&self) -> [FileEntry; 2] {
        [(START, self.release.start), (ROOT, self.release.root)].map(|(name, (id, size))| FileEntry {
            path: FilePath::word(name),
            id,
            size,
        })
    }
}

/// The path of the system's seal with this file stem in a bundle.
pub fn path(stem: &str) -> String {
    format!("systems/{stem}.seal")
}

/// Copies `size` bytes from `from` to `to`, and verifies that they are the object `id`.
///
/// # Errors
/// The error of either; [`ErrorKind::InvalidData`] if the bytes are wrong or too few: they were written nevertheless.
pub fn copy_object(id: &ObjectId, size: u64, from: &mut dyn io::Read, to: &mut dyn io::Write) -> io::Result<()> {
    let mut tee = Tee { to, hasher: blake3::Hasher::new() };
    let copied = io::copy(&mut io::Read::take(from, size), &mut tee)?;
    let found = ObjectId::new(*tee.hasher.finalize().as_bytes());
    if (copied, found) == (size, *id) {
        return Ok(());
    }
    Err(io::Error::new(ErrorKind::InvalidData, format!("expected {size} bytes {id}, found {copied} bytes {found}")))
}

/// Writes and hashes.
struct Tee<'t> {
    to: &'t mut dyn io::Write,
    hasher: blake3::Hasher,
}

impl io::Write for Tee<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.to.write(bytes)?;
        self.hasher.update(&bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.to.flush()
    }
}

fn half(lines: &mut Lines<'_>, name: &str, wanted: &'static str) -> Result<(ObjectId, u64), Refusal> {
    let (id, size) = object(lines, name, wanted)?;
    if size > limits::SYSTEM {
        return Err(Refusal::TooLarge { part: Part::Object(id), limit: limits::SYSTEM });
    }
    Ok((id, size))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::seal::UnverifiedSeal;
    use crate::seal::tests::letter;
    use crate::secret::tests::{artist, stranger};

    /// A system for all units, signed by the artist.
    pub(crate) fn system(version: &str, sequence: u64) -> System {
        let bytes = release(version, sequence).sign(artist()).unwrap();
        UnverifiedSystem::new(bytes).verify(&Trust::of([artist().public()])).unwrap()
    }

    fn release(version: &str, sequence: u64) -> Release {
        Release {
            version: Version::parse(version).unwrap(),
            addressees: Addressees::Anyone,
            sequence: Sequence(sequence),
            created: "2026-03-01T12:00:00Z".to_owned(),
            start: (ObjectId::of(b"start"), 5),
            root: (ObjectId::of(b"the root"), 8),
            statements: None,
        }
    }

    #[test]
    fn a_system_is_what_a_trusted_key_signed_as_one() {
        let trust = Trust::of([artist().public()]);
        let found = system("0.2.0", 8);
        assert_eq!(found.release(), &release("0.2.0", 8));
        assert_eq!(
            found.halves().map(|half| (half.path.to_string(), half.size)),
            [("start".to_owned(), 5), ("root".to_owned(), 8)]
        );
        let strange = UnverifiedSystem::new(release("0.2.0", 8).sign(&stranger()).unwrap());
        assert!(matches!(strange.verify(&trust), Err(Refusal::UnknownKey { .. })));
        // A flock's seal is not accepted as a system's, and vice versa.
        let flock = letter(8).sign(artist()).unwrap();
        assert!(matches!(UnverifiedSystem::new(flock).verify(&trust), Err(Refusal::Forged { .. })));
        assert!(matches!(UnverifiedSeal::new(found.bytes()).verify(&trust), Err(Refusal::Forged { .. })));
        let huge = Release { root: (ObjectId::of(b""), limits::SYSTEM + 1), ..release("1", 1) };
        assert!(matches!(huge.sign(artist()), Err(SignError::Refused(Refusal::TooLarge { .. }))));
    }

    #[test]
    fn any_changed_bit_of_a_systems_seal_is_refused() {
        let (whole, trust) = (system("0.2.0", 8).bytes, Trust::of([artist().public()]));
        for bit in 0..whole.len() * 8 {
            let mut bytes = whole.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            assert!(UnverifiedSystem::new(bytes).verify(&trust).is_err(), "bit {bit}");
        }
    }

    #[test]
    fn only_the_object_itself_is_copied_without_complaint() {
        let (id, mut to) = (ObjectId::of(b"the root"), Vec::new());
        copy_object(&id, 8, &mut &b"the root, and what stands behind it"[..], &mut to).unwrap();
        assert_eq!(to, b"the root");
        for other in [&b"the roof"[..], b"the ro", b""] {
            let refused = copy_object(&id, 8, &mut &other[..], &mut Vec::new()).unwrap_err();
            assert_eq!(refused.kind(), ErrorKind::InvalidData);
        }
    }
}

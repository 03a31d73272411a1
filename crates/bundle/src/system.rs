//! A system ready to travel: what a unit starts from.
//!
//! Owns its seal and the one spelling of it. A system lies beside the flocks of a bundle, is signed by the same keys and
//! addressed to the same units; its two halves are objects like all others: the file that the firmware starts, and the
//! verified root. Its seal names both, so there is no list. What was signed as a flock is never taken for a system.
//! Never writes a slot: the updater does.
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
//! The last line is as in a flock's seal.
//!
//! Start at [`UnverifiedSystem::verify`], which is the only way to a [`System`].

use std::io::{self, ErrorKind};

use crate::contents::FileEntry;
use crate::envelope::{Address, SignError, expected, object, opened, read, signed, statements, statements_text};
use crate::key::KeyId;
use crate::limits;
use crate::lines::Lines;
use crate::names::{Addressees, FilePath, ObjectId, Sequence, UnitId, Version};
use crate::refused::{Part, Refused};
use crate::secret::SecretKey;
use crate::source::Source;
use crate::trust::Trust;

/// The first line of a system's seal.
const HEADING: &str = "dreams system 1";
/// The halves of a system, as its seal names them.
const START: &str = "start";
const ROOT: &str = "root";

/// The bytes of a system's seal, of which nothing is known yet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnverifiedSystem(Vec<u8>);

/// What is said in front of a system.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Release {
    /// Its version: a unit takes none that is not above its own.
    pub version: Version,
    /// For whom it is.
    pub addressees: Addressees,
    /// Its number among all that its key has signed.
    pub sequence: Sequence,
    /// When it was signed, as `2026-03-01T12:00:00Z`. For people only.
    pub created: String,
    /// What the firmware starts, and its size in bytes.
    pub start: (ObjectId, u64),
    /// The verified root, the tree of its hashes included, and its size in bytes.
    pub root: (ObjectId, u64),
    /// What keys say about keys, which whoever takes the system must know, and its size in bytes.
    pub statements: Option<(ObjectId, u64)>,
}

/// A system that a trusted key has signed: the only thing that has halves to be written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct System {
    release: Release,
    signer: KeyId,
    bytes: Vec<u8>,
}

impl UnverifiedSystem {
    /// Reads the system's seal that `source` has for `unit`, or else the one for everybody; `None` if it has neither.
    ///
    /// # Errors
    /// [`Refused::Read`], or [`Refused::TooLarge`].
    pub fn open(source: &mut dyn Source, unit: &UnitId) -> Result<Option<Self>, Refused> {
        for addressees in [Addressees::of([unit.clone()]), Addressees::Anyone] {
            if let Some(found) = Self::addressed(source, &addressees)? {
                return Ok(Some(found));
            }
        }
        Ok(None)
    }

    /// Reads the system's seal that `source` has for the first of `addressees`; `None` if it has none.
    ///
    /// # Errors
    /// [`Refused::Read`], or [`Refused::TooLarge`].
    pub fn addressed(source: &mut dyn Source, addressees: &Addressees) -> Result<Option<Self>, Refused> {
        let stem = addressees.stems().first().copied().unwrap_or_default();
        match read(source, &path(stem)) {
            Ok(bytes) => Ok(Some(Self(bytes))),
            Err(Refused::Read { source, .. }) if source.kind() == ErrorKind::NotFound => Ok(None),
            Err(refused) => Err(refused),
        }
    }

    /// The seal in `bytes`, wherever they come from.
    pub fn new(bytes: impl Into<Vec<u8>>) -> Self {
        Self(bytes.into())
    }

    /// Checks the signature, and only then reads what it says.
    ///
    /// # Errors
    /// [`Refused`] if nobody trusted signed it, or it says nothing that makes sense.
    pub fn verify(self, trust: &Trust) -> Result<System, Refused> {
        let (signer, text) = opened(&self.0, trust, HEADING)?;
        let release = Release::parse(text)?;
        Ok(System { release, signer, bytes: self.0 })
    }
}

impl Release {
    /// Signs it: the bytes of the seal's file.
    ///
    /// # Errors
    /// [`Refused`] if it says what no unit would take; [`crate::KeyError::Sign`] within.
    pub fn sign(&self, key: &SecretKey) -> Result<Vec<u8>, SignError> {
        let text = self.to_text();
        let read = Self::parse(&text).map_err(SignError::Refused)?;
        debug_assert_eq!(&read, self, "a release reads back as written");
        let comment = format!("system {} sequence {}", self.version, self.sequence);
        signed(key, &comment, &text)
    }

    fn to_text(&self) -> String {
        let Self { version, addressees, sequence, created, start, root, statements } = self;
        let (address, statements) = (Address::to_text(addressees, *sequence, created), statements_text(*statements));
        format!(
            "{HEADING}\nversion {version}\n{address}{START} {} {}\n{ROOT} {} {}\n{statements}",
            start.1, start.0, root.1, root.0
        )
    }

    fn parse(text: &str) -> Result<Self, Refused> {
        let mut lines = Lines::new(Part::Seal, text);
        lines.exactly(HEADING)?;
        let version = lines.value("version", "`version` and a version")?;
        let version = Version::parse(version).map_err(|error| lines.misnamed(error))?;
        let Address { addressees, sequence, created } = Address::parse(&mut lines)?;
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

    /// Reads from `source` the statements about keys that the seal expects, as
    /// [`Seal::expected_statements`](crate::Seal::expected_statements) does.
    ///
    /// # Errors
    /// [`Refused::Withheld`] if `source` has none or others, or [`Refused::Read`].
    pub fn expected_statements(&self, source: &mut dyn Source) -> Result<Vec<u8>, Refused> {
        expected(self.release.statements, source)
    }

    /// What has to be there before it can be written: both halves, the smaller one first.
    pub fn halves(&self) -> [FileEntry; 2] {
        [(START, self.release.start), (ROOT, self.release.root)].map(|(name, (id, size))| FileEntry {
            path: FilePath::word(name),
            id,
            size,
        })
    }
}

/// Where the system's seal for the unit with this stem lies in a bundle.
pub fn path(stem: &str) -> String {
    format!("systems/{stem}.seal")
}

/// Copies what `from` yields to `to`, `size` bytes of it, which must be the object `id`.
///
/// # Errors
/// What either says; [`ErrorKind::InvalidData`] if the bytes are others or too few: they were written all the same.
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

fn half(lines: &mut Lines<'_>, name: &str, wanted: &'static str) -> Result<(ObjectId, u64), Refused> {
    let (id, size) = object(lines, name, wanted)?;
    if size > limits::SYSTEM {
        return Err(Refused::TooLarge { part: Part::Object(id), limit: limits::SYSTEM });
    }
    Ok((id, size))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::seal::Unverified;
    use crate::seal::tests::letter;
    use crate::secret::tests::{artist, stranger};

    /// A system for everybody, signed by the artist.
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
        assert!(matches!(strange.verify(&trust), Err(Refused::UnknownKey { .. })));
        // A flock is no system, and the other way round, whoever signed it.
        let flock = letter(8).sign(artist()).unwrap();
        assert!(matches!(UnverifiedSystem::new(flock).verify(&trust), Err(Refused::Forged { .. })));
        assert!(matches!(Unverified::new(found.bytes()).verify(&trust), Err(Refused::Forged { .. })));
        let huge = Release { root: (ObjectId::of(b""), limits::SYSTEM + 1), ..release("1", 1) };
        assert!(matches!(huge.sign(artist()), Err(SignError::Refused(Refused::TooLarge { .. }))));
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

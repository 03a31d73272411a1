//! Settings that have arrived on a stick, and the numbers of those that were taken in before.
//!
//! Owns three files beside the kept settings: a lock, the highest number of each key in two copies, and the settings that
//! wait for the owner's partition, which nobody else may read. The number is raised only when the partition has the
//! settings: after a power cut between the two, the same settings are written there once more. Never verifies anything,
//! and mounts nothing.
//!
//! Start at [`Inbox::open`].

use bundle::{KeyId, Sequence};
use durable::{Checksummed, Copies, Found, LocalFolder, framed, unframed};
use rustix::fs::{FlockOperation, flock};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

/// The settings that wait. `dreams-owner-write@.path` waits for a file of this name.
const ARRIVED: &str = "arrived.json";
/// The lock, which is held for as long as an [`Inbox`] lives.
const LOCK: &str = "arrived.lock";
/// Bytes of the settings that wait, at most: six for each byte of the owner's file, as JSON may need them.
const LARGEST: u64 = 7 * bundle::limits::SETTINGS;
/// What a file with numbers begins with: its kind and version.
const MAGIC: [u8; 8] = *b"d-setnr\x01";

/// Settings that wait for the owner's partition.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Arrived {
    /// Who signed them.
    pub(crate) signer: KeyId,
    /// Their number among all that this key has signed.
    pub(crate) sequence: Sequence,
    /// The owner's file.
    pub(crate) text: String,
}

/// The highest number of each key whose settings were taken in.
#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(transparent)]
struct Numbers(BTreeMap<KeyId, Sequence>);

/// The folder with these files, locked against a second program.
#[derive(Debug)]
pub(crate) struct Inbox {
    path: PathBuf,
    folder: LocalFolder,
    copies: Copies<Numbers>,
    numbers: Numbers,
    _lock: File,
}

impl Inbox {
    /// Opens the files in `folder`, and waits until no other program has them open. Numbers of which both copies are
    /// damaged are begun anew.
    /// Errors: What the disk says.
    pub(crate) fn open(folder: &Path) -> io::Result<Self> {
        let path = folder.to_owned();
        let lock = OpenOptions::new().write(true).create(true).truncate(false).mode(0o600).open(path.join(LOCK))?;
        flock(&lock, FlockOperation::LockExclusive)?;
        let folder = LocalFolder::new(&path);
        let (copies, found) = Copies::read(&folder);
        let numbers = match found {
            Found::State { state, .. } => state,
            Found::Nothing | Found::Damaged => Numbers::default(),
            Found::Unreadable(error) => return Err(error),
        };
        Ok(Self { path, folder, copies, numbers, _lock: lock })
    }

    /// The highest number of the key `signer`, also of settings that still wait.
    /// Errors: Those of [`Self::arrived`].
    pub(crate) fn last(&self, signer: KeyId) -> io::Result<Option<Sequence>> {
        let waiting = self.arrived()?.filter(|arrived| arrived.signer == signer).map(|arrived| arrived.sequence);
        Ok(self.numbers.0.get(&signer).copied().max(waiting))
    }

    /// The settings that wait; `None` if there are none, or they make no sense.
    /// Errors: What the disk says.
    pub(crate) fn arrived(&self) -> io::Result<Option<Arrived>> {
        match durable::read_plain(&self.path.join(ARRIVED), LARGEST) {
            Ok(bytes) => Ok(serde_json::from_slice(&bytes).ok()),
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Has these settings wait, in place of others that waited.
    /// Errors: What the disk says; those before still wait.
    pub(crate) fn put(&self, arrived: &Arrived) -> io::Result<()> {
        let bytes = serde_json::to_vec(arrived).map_err(io::Error::other)?;
        durable::write_with_mode(&self.path.join(ARRIVED), &bytes, 0o600)
    }

    /// The owner's partition has these settings: those with this number or a lower one are older from now on.
    /// Errors: What the disk says; the number before stays.
    pub(crate) fn accept(&mut self, arrived: &Arrived) -> io::Result<()> {
        let last = self.numbers.0.entry(arrived.signer).or_insert(arrived.sequence);
        *last = arrived.sequence.max(*last);
        self.copies.write_both(&self.folder, &self.numbers)
    }

    /// Nothing waits any more.
    /// Errors: What the disk says.
    pub(crate) fn clear(&self) -> io::Result<()> {
        match fs::remove_file(self.path.join(ARRIVED)) {
            Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
            Ok(()) | Err(_) => durable::sync_folder(&self.path),
        }
    }
}

impl Checksummed for Numbers {
    const FILES: [&'static str; 2] = ["numbers.0", "numbers.1"];
    const LIMIT: u64 = 64 << 10;

    fn to_file(&self, number: u64) -> io::Result<Vec<u8>> {
        framed(MAGIC, number, &serde_json::to_vec(self).map_err(io::Error::other)?)
    }

    fn from_file(bytes: &[u8]) -> Option<(u64, Self)> {
        let (number, numbers) = unframed(MAGIC, bytes)?;
        Some((number, serde_json::from_slice(numbers).ok()?))
    }
}

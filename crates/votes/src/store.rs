//! The two files of a ledger.
//!
//! Owns their form: a number, the ledger as JSON, and a checksum over both. They are written in turn, so that one of them is
//! whole at every moment ([`durable::Copies`]): what [`Store::save`] has told survives a power cut. The number counts the
//! writes on this machine and is never sent. Never knows what a ledger means.
//!
//! Start at [`Store::open`].

use crate::error::VotesError;
use crate::ledger::Ledger;
use durable::{Checksummed, Copies, Found, LocalFolder, framed, unframed};
use std::io;
use std::path::{Path, PathBuf};

/// What a file begins with: its kind and version.
const MAGIC: [u8; 8] = *b"d-votes\x01";

/// The files of a unit.
#[derive(Debug)]
pub struct Store {
    path: PathBuf,
    folder: LocalFolder,
    copies: Copies<Ledger>,
}

impl Store {
    /// Opens the files in `folder`, and reads the newest whole ledger; `None` if there is none that is whole.
    ///
    /// # Errors
    /// [`VotesError::Store`] if the disk does not give what may be there.
    pub fn open(folder: &Path) -> Result<(Self, Option<Ledger>), VotesError> {
        let path = folder.to_owned();
        let folder = LocalFolder::new(&path);
        let (copies, found) = Copies::read(&folder);
        let store = Self { path, folder, copies };
        match found {
            Found::State { state, .. } => Ok((store, Some(state))),
            Found::Nothing | Found::Damaged => Ok((store, None)),
            Found::Unreadable(source) => Err(store.error("read", source)),
        }
    }

    /// Saves `ledger`; returns when the disk has it.
    ///
    /// # Errors
    /// [`VotesError::Store`]. The ledger saved before stays.
    pub fn save(&mut self, ledger: &Ledger) -> Result<(), VotesError> {
        self.copies.write_older(&self.folder, ledger).map_err(|source| self.error("write", source))
    }

    fn error(&self, doing: &'static str, source: io::Error) -> VotesError {
        VotesError::Store { doing, path: self.path.display().to_string(), source }
    }
}

impl Checksummed for Ledger {
    const FILES: [&'static str; 2] = ["votes.0", "votes.1"];
    const LIMIT: u64 = 4 << 20;

    fn to_file(&self, number: u64) -> io::Result<Vec<u8>> {
        framed(MAGIC, number, &serde_json::to_vec(self).map_err(io::Error::other)?)
    }

    fn from_file(bytes: &[u8]) -> Option<(u64, Self)> {
        let (number, ledger) = unframed(MAGIC, bytes)?;
        Some((number, serde_json::from_slice(ledger).ok()?))
    }
}

#[cfg(test)]
mod tests {
    use super::Store;
    use crate::ledger::Ledger;
    use crate::showing::{Visit, Vote};
    use crate::totals::LedgerId;
    use durable::Checksummed;
    use std::fs;

    /// A ledger with a vote of step `step`.
    fn ledger(step: u64) -> Ledger {
        let mut ledger = Ledger::new(LedgerId(1), 20_412, true);
        let visit = Visit { seed: 1, step, sheep: "a".to_owned() };
        ledger.vote(&visit, Vote::Up).unwrap();
        ledger
    }

    #[test]
    fn votes_come_back_and_a_write_torn_at_any_byte_leaves_those_before() {
        let folder = tempfile::tempdir().unwrap();
        let (mut store, found) = Store::open(folder.path()).unwrap();
        assert_eq!(found, None);
        for step in 0..2 {
            store.save(&ledger(step)).unwrap();
            assert_eq!(Store::open(folder.path()).unwrap().1, Some(ledger(step)));
        }
        let torn = folder.path().join(Ledger::FILES[0]);
        let whole = ledger(2).to_file(3).unwrap();
        for cut in 0..whole.len() {
            fs::write(&torn, &whole[..cut]).unwrap();
            assert_eq!(Store::open(folder.path()).unwrap().1, Some(ledger(1)), "cut at {cut}");
        }
        fs::write(&torn, &whole).unwrap();
        assert_eq!(Store::open(folder.path()).unwrap().1, Some(ledger(2)));
    }

    #[test]
    fn a_disk_that_gives_nothing_is_told_and_no_ledger_is_begun_in_its_place() {
        let folder = tempfile::tempdir().unwrap();
        for name in Ledger::FILES {
            fs::create_dir(folder.path().join(name)).unwrap();
        }
        let error = Store::open(folder.path()).unwrap_err().to_string();
        assert!(error.starts_with("cannot read the votes in `"), "{error}");
    }
}

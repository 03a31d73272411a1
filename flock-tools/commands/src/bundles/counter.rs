//! The number of a key's last bundle, kept beside the key.
//!
//! Owns the rule that each bundle of a key gets a higher number than the one before: units take only what is newer. A
//! number is saved as used before its bundle is signed, so one may be skipped, but none is used twice. Two machines that share
//! a key should share this file.
//!
//! Start at [`Counter::lock`].

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use bundle::Sequence;
use operations::program::{Exit, Fatal};

/// The ending of the file beside the key.
const ENDING: &str = "sequence";

/// The counter of one key, locked by one command.
#[derive(Debug)]
pub(super) struct Counter {
    path: PathBuf,
    last: u64,
    /// The key's file, locked while it is open: a second command that signs with this key waits.
    _lock: Option<File>,
}

/// Why there is no next number.
#[derive(Debug, thiserror::Error)]
enum CounterError {
    #[error("`{path}`: wanted the number of the key's last bundle, found `{found}`")]
    Malformed { path: PathBuf, found: String },
    #[error("sequence {asked} is not above {last}, the last one of this key")]
    NotAbove { asked: Sequence, last: u64 },
    #[error("this key has used up all numbers")]
    UsedUp,
}

impl Counter {
    /// Locks the counter of the key in the file `key`; waits while another command has it.
    pub(super) fn lock(key: &Path) -> Result<Self, Fatal> {
        // On a file system without locks the artist must not sign twice at once.
        let lock = File::open(key).ok().filter(|key| key.lock().is_ok());
        let path = key.with_extension(ENDING);
        let last = match fs::read_to_string(&path) {
            Ok(text) => text.trim_end().parse().map_err(|_| {
                let found = text.chars().take(40).collect();
                Fatal::new(Exit::Malformed, CounterError::Malformed { path: path.clone(), found })
            })?,
            Err(error) if error.kind() == io::ErrorKind::NotFound => 0,
            Err(source) => return Err(Fatal::read(&path, source)),
        };
        Ok(Self { path, last, _lock: lock })
    }

    /// Takes note of the number of a bundle of this key: the next number is above it.
    pub(super) fn raise_to(&mut self, sequence: Sequence) {
        self.last = self.last.max(sequence.0);
    }

    /// Saves the next number, or the one that is `asked` for, as used, and returns it.
    pub(super) fn advance(&mut self, asked: Option<Sequence>) -> Result<Sequence, Fatal> {
        let next = self.last.checked_add(1).ok_or_else(|| Fatal::new(Exit::No, CounterError::UsedUp))?;
        let sequence = asked.unwrap_or(Sequence(next));
        if sequence.0 < next {
            return Err(Fatal::new(Exit::No, CounterError::NotAbove { asked: sequence, last: self.last }));
        }
        let saved = durable::save(&self.path, format!("{sequence}\n").as_bytes());
        saved.map_err(|source| Fatal::write(&self.path, source))?;
        self.last = sequence.0;
        Ok(sequence)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_go_up_whatever_is_seen_and_asked_for() {
        let folder = tempfile::tempdir().unwrap();
        let key = folder.path().join("artist.key");
        fs::write(&key, "").unwrap();
        let mut counter = Counter::lock(&key).unwrap();
        assert_eq!(counter.advance(None).unwrap(), Sequence(1));
        assert_eq!(counter.advance(Some(Sequence(5))).unwrap(), Sequence(5));
        assert!(counter.advance(Some(Sequence(5))).is_err());
        drop(counter);
        let mut counter = Counter::lock(&key).unwrap();
        counter.raise_to(Sequence(3));
        assert_eq!(counter.advance(None).unwrap(), Sequence(6));
        counter.raise_to(Sequence(9));
        assert_eq!(counter.advance(None).unwrap(), Sequence(10));
        assert_eq!(fs::read_to_string(folder.path().join("artist.sequence")).unwrap(), "10\n");
        counter.raise_to(Sequence(u64::MAX));
        assert!(counter.advance(None).is_err());
        drop(counter);
        fs::write(folder.path().join("artist.sequence"), "ten").unwrap();
        assert!(Counter::lock(&key).is_err());
    }
}

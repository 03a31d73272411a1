//! Two checksummed copies of a store's state on the disk.
//!
//! Owns two files with the same contents. They are replaced one after the other, each by a rename, so that one of them
//! is always complete; if one is damaged later, the other one is used.

use std::io;

use crate::limits;
use crate::names::{ObjectId, parse_plain};
use crate::store::disk::{Disk, replace};
use crate::store::state::State;

/// The two files.
pub(crate) const SLOTS: [&str; 2] = ["state.0", "state.1"];
/// The first word of each.
const HEADING: &str = "dreams-state-1";

/// What the slots hold.
#[derive(Debug, Default)]
pub(crate) struct Slots {
    /// How often the state was written.
    number: u64,
}

/// The result of reading the copies.
pub(crate) enum Read {
    /// Neither file exists: a new store.
    Nothing,
    /// There are files, but no valid copy.
    Damaged,
    /// No valid copy was found, but a file could not be read.
    Unread(io::Error),
    /// The newest valid state; whether both copies are equal.
    State { state: Box<State>, both: bool },
}

impl Slots {
    /// Reads the newest whole state.
    ///
    /// A copy that cannot be read counts as damaged if the other one is valid.
    pub(crate) fn read(disk: &dyn Disk) -> (Self, Read) {
        let mut newest: Option<(u64, State)> = None;
        let (mut missing, mut agreeing, mut unread) = (0, 0, None);
        for slot in SLOTS {
            let bytes = match disk.read(slot, limits::STATE) {
                Ok(bytes) => bytes,
                Err(error) if error.kind() == io::ErrorKind::NotFound => {
                    missing += 1;
                    continue;
                }
                // A file above the size limit counts as damaged.
                Err(error) if error.kind() == io::ErrorKind::FileTooLarge => continue,
                Err(error) => {
                    unread = Some(error);
                    continue;
                }
            };
            let Some((number, state)) = parse(&bytes) else { continue };
            match &newest {
                Some((best, _)) if *best > number => {}
                Some((best, _)) if *best == number => agreeing += 1,
                Some(_) | None => {
                    agreeing = 1;
                    newest = Some((number, state));
                }
            }
        }
        match newest {
            Some((number, state)) => {
                (Self { number }, Read::State { state: Box::new(state), both: agreeing == SLOTS.len() })
            }
            None if missing == SLOTS.len() => (Self::default(), Read::Nothing),
            None => (Self::default(), unread.map_or(Read::Damaged, Read::Unread)),
        }
    }

    /// Saves the state; returns when both copies are synced.
    ///
    /// # Errors
    /// The disk's error. The state is the one before, or this one.
    pub(crate) fn write(&mut self, disk: &dyn Disk, state: &State) -> io::Result<()> {
        // A failed attempt may have left this number in one of the copies.
        self.number += 1;
        let bytes = written(self.number, state)?;
        for slot in SLOTS {
            replace(disk, slot, &bytes)?;
        }
        Ok(())
    }
}

fn written(number: u64, state: &State) -> io::Result<Vec<u8>> {
    let body = serde_json::to_string(state).map_err(io::Error::other)?;
    let text = format!("{HEADING} {number} {}\n{body}\n", ObjectId::of(format!("{number} {body}").as_bytes()));
    if text.len() as u64 > limits::STATE {
        return Err(crate::beneath::too_large(limits::STATE));
    }
    Ok(text.into_bytes())
}

fn parse(bytes: &[u8]) -> Option<(u64, State)> {
    let (head, body) = std::str::from_utf8(bytes).ok()?.split_once('\n')?;
    let body = body.strip_suffix('\n')?;
    let mut words = head.split(' ');
    let (heading, number, checksum) = (words.next()?, words.next()?, words.next()?);
    let fine = heading == HEADING
        && words.next().is_none()
        && ObjectId::parse(checksum) == Ok(ObjectId::of(format!("{number} {body}").as_bytes()));
    if fine { Some((parse_plain(number)?, serde_json::from_str(body).ok()?)) } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::names::Sequence;
    use crate::store::disk::LocalDisk;
    use std::fs;

    fn state(newest: u64) -> State {
        let floors = [(crate::key::KeyId::parse("0123456789ABCDEF").unwrap(), Sequence(newest))].into();
        State { floors, newest, ..State::default() }
    }

    fn read(disk: &LocalDisk) -> (u64, bool) {
        match Slots::read(disk).1 {
            Read::State { state, both } => (state.newest, both),
            Read::Nothing | Read::Damaged | Read::Unread(_) => panic!("no state"),
        }
    }

    #[test]
    fn either_slot_alone_tells_everything() {
        for broken in SLOTS {
            let folder = tempfile::tempdir().unwrap();
            let disk = LocalDisk::open(folder.path()).unwrap();
            assert!(matches!(Slots::read(&disk).1, Read::Nothing));
            let mut slots = Slots::read(&disk).0;
            slots.write(&disk, &state(1)).unwrap();
            slots.write(&disk, &state(2)).unwrap();
            assert_eq!(read(&disk), (2, true));
            fs::write(folder.path().join(broken), "torn").unwrap();
            assert_eq!(read(&disk), (2, false));
            Slots::read(&disk).0.write(&disk, &state(3)).unwrap();
            assert_eq!(read(&disk), (3, true));
            for slot in SLOTS {
                fs::write(folder.path().join(slot), "torn").unwrap();
            }
            assert!(matches!(Slots::read(&disk).1, Read::Damaged));
        }
    }

    #[test]
    fn what_the_disk_does_not_give_is_not_taken_for_damage() {
        let folder = tempfile::tempdir().unwrap();
        let disk = LocalDisk::open(folder.path()).unwrap();
        Slots::default().write(&disk, &state(1)).unwrap();
        for (at, slot) in SLOTS.iter().enumerate() {
            // A folder cannot be read, like a bad sector.
            fs::remove_file(folder.path().join(slot)).unwrap();
            fs::create_dir(folder.path().join(slot)).unwrap();
            let read = Slots::read(&disk).1;
            let is_known = matches!(&read, Read::State { state, both: false } if state.newest == 1);
            assert_eq!((is_known, matches!(read, Read::Unread(_))), (at == 0, at == 1), "{slot}");
        }
    }

    #[test]
    fn a_flipped_bit_anywhere_and_a_cut_anywhere_are_seen() {
        let whole = written(7, &state(9)).unwrap();
        assert_eq!(parse(&whole), Some((7, state(9))));
        for bit in 0..whole.len() * 8 {
            let mut bytes = whole.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(parse(&bytes), None, "bit {bit}");
        }
        for cut in 0..whole.len() {
            assert_eq!(parse(&whole[..cut]), None, "cut at {cut}");
        }
    }
}

//! Two copies of a state, each with a number and a checksum.
//!
//! Owns which copy is the newest whole one and which is written next. Every copy is written atomically, so that at each
//! moment one of them is whole; a copy that is damaged later leaves the other one. Never knows what the state means:
//! [`Checksummed`] has the form of a file.

use std::io;
use std::marker::PhantomData;

use crate::atomic::replace;
use crate::storage::Storage;

/// What is kept in two copies.
pub trait Checksummed: Sized {
    /// The names of the two files.
    const FILES: [&'static str; 2];
    /// What a file may have, in bytes.
    const LIMIT: u64;

    /// The bytes of a file, with `number` and a checksum over both.
    ///
    /// # Errors
    /// The state is too large.
    fn to_file(&self, number: u64) -> io::Result<Vec<u8>>;

    /// The number and the state in the bytes of a file; `None` if they are not whole.
    fn from_file(bytes: &[u8]) -> Option<(u64, Self)>;
}

/// The two copies.
#[derive(Debug)]
pub struct Copies<S> {
    /// The number of the newest copy.
    number: u64,
    /// Which file that is.
    newest: usize,
    state: PhantomData<S>,
}

/// What was found when the copies were read.
#[derive(Debug)]
pub enum Found<S> {
    /// Neither file exists.
    Nothing,
    /// A file exists, and none is whole.
    Damaged,
    /// No whole file was found, and the disk did not give everything: there may be a state.
    Unreadable(io::Error),
    /// The newest whole state, and whether both files hold it.
    State {
        /// The state.
        state: S,
        /// Whether both files hold it.
        both: bool,
    },
}

impl<S: Checksummed> Copies<S> {
    /// Reads the newest whole state. A file that cannot be read counts as damaged where the other one is whole.
    pub fn read(folder: &dyn Storage) -> (Self, Found<S>) {
        let mut copies = Self { number: 0, newest: 1, state: PhantomData };
        let mut newest = None;
        let (mut missing, mut same, mut unreadable) = (0, 0, None);
        for (file, name) in S::FILES.into_iter().enumerate() {
            let bytes = match folder.read(name, S::LIMIT) {
                Ok(bytes) => bytes,
                Err(error) => {
                    if error.kind() == io::ErrorKind::NotFound {
                        missing += 1;
                    } else if error.kind() != io::ErrorKind::FileTooLarge {
                        // A file that is too large is damaged, like one that was torn.
                        unreadable = Some(error);
                    }
                    continue;
                }
            };
            let Some((number, state)) = S::from_file(&bytes) else { continue };
            if newest.is_some() && number == copies.number {
                same += 1;
            } else if newest.is_none() || number > copies.number {
                (copies.number, copies.newest, same, newest) = (number, file, 1, Some(state));
            }
        }
        let found = match (newest, unreadable) {
            (Some(state), _) => Found::State { state, both: same == S::FILES.len() },
            (None, _) if missing == S::FILES.len() => Found::Nothing,
            (None, None) => Found::Damaged,
            (None, Some(error)) => Found::Unreadable(error),
        };
        (copies, found)
    }

    /// Writes the state to both files, one after the other; returns when the disk has both.
    ///
    /// # Errors
    /// What the disk says. The state is the one before, or this one.
    pub fn write_both(&mut self, folder: &dyn Storage, state: &S) -> io::Result<()> {
        // A failed attempt may have left this number in one of the files.
        self.number += 1;
        let bytes = state.to_file(self.number)?;
        S::FILES.iter().try_for_each(|name| replace(folder, name, &bytes))
    }

    /// Writes the state to the older file, for a state that changes often; returns when the disk has it.
    ///
    /// # Errors
    /// What the disk says. The state before stays.
    pub fn write_older(&mut self, folder: &dyn Storage, state: &S) -> io::Result<()> {
        let older = 1 - self.newest;
        let name = S::FILES[older];
        let bytes = state.to_file(self.number + 1)?;
        match replace(folder, name, &bytes) {
            // A folder of this name, which nobody here made, is moved out of the way.
            Err(error) if error.kind() == io::ErrorKind::IsADirectory => {
                folder.rename(name, &format!("{name}.bad"))?;
                replace(folder, name, &bytes)?;
            }
            written => written?,
        }
        (self.number, self.newest) = (self.number + 1, older);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::storage::LocalFolder;
    use std::fs;
    use std::path::Path;

    /// A state of one number, with the sum of its bytes as its checksum.
    #[derive(Clone, Copy, Debug, PartialEq)]
    struct Number(u64);

    impl Checksummed for Number {
        const FILES: [&'static str; 2] = ["a", "b"];
        const LIMIT: u64 = 17;

        fn to_file(&self, number: u64) -> io::Result<Vec<u8>> {
            let mut bytes = [number.to_le_bytes(), self.0.to_le_bytes()].concat();
            bytes.push(bytes.iter().fold(1, |sum: u8, byte| sum.wrapping_add(*byte)));
            Ok(bytes)
        }

        fn from_file(bytes: &[u8]) -> Option<(u64, Self)> {
            let (number, rest) = bytes.split_first_chunk()?;
            let (state, _) = rest.split_first_chunk()?;
            let (number, state) = (u64::from_le_bytes(*number), Self(u64::from_le_bytes(*state)));
            (state.to_file(number).ok()? == bytes).then_some((number, state))
        }
    }

    fn read(folder: &Path) -> (Number, bool) {
        match Copies::read(&LocalFolder::new(folder)).1 {
            Found::State { state, both } => (state, both),
            other @ (Found::Nothing | Found::Damaged | Found::Unreadable(_)) => panic!("{other:?}"),
        }
    }

    #[test]
    fn either_copy_alone_has_the_state() {
        for broken in Number::FILES {
            let dir = tempfile::tempdir().unwrap();
            let folder = LocalFolder::new(dir.path());
            let (mut copies, found) = Copies::read(&folder);
            assert!(matches!(found, Found::Nothing));
            for number in 1..=2 {
                copies.write_both(&folder, &Number(number)).unwrap();
                assert_eq!(read(dir.path()), (Number(number), true));
            }
            fs::write(dir.path().join(broken), "torn").unwrap();
            assert_eq!(read(dir.path()), (Number(2), false), "{broken}");
            fs::write(dir.path().join(broken), [7; 18]).unwrap();
            assert_eq!(read(dir.path()), (Number(2), false), "{broken} is too large");
            fs::remove_file(dir.path().join(broken)).unwrap();
            assert_eq!(read(dir.path()), (Number(2), false), "{broken}");
        }
    }

    #[test]
    fn a_write_that_fails_between_the_copies_leaves_the_newer_state_and_is_made_up_for() {
        let dir = tempfile::tempdir().unwrap();
        let folder = LocalFolder::new(dir.path());
        let mut copies = Copies::read(&folder).0;
        copies.write_both(&folder, &Number(1)).unwrap();
        let in_the_way = dir.path().join("b.new");
        fs::create_dir(&in_the_way).unwrap();
        copies.write_both(&folder, &Number(2)).unwrap_err();
        assert_eq!(read(dir.path()), (Number(2), false));
        fs::remove_dir(&in_the_way).unwrap();
        copies.write_both(&folder, &Number(3)).unwrap();
        assert_eq!(read(dir.path()), (Number(3), true));
    }

    #[test]
    fn the_copies_take_turns_and_a_torn_one_leaves_the_state_before() {
        let dir = tempfile::tempdir().unwrap();
        let folder = LocalFolder::new(dir.path());
        for number in 1..=5 {
            let (mut copies, _) = Copies::read(&folder);
            copies.write_older(&folder, &Number(2 * number)).unwrap();
            copies.write_older(&folder, &Number(2 * number + 1)).unwrap();
            assert_eq!(read(dir.path()), (Number(2 * number + 1), false));
        }
        // Ten writes: the second file holds the newest.
        fs::write(dir.path().join(Number::FILES[1]), "torn").unwrap();
        assert_eq!(read(dir.path()), (Number(10), false));
        Copies::read(&folder).0.write_older(&folder, &Number(12)).unwrap();
        assert_eq!(read(dir.path()), (Number(12), false));
        fs::remove_file(dir.path().join(Number::FILES[1])).unwrap();
        assert_eq!(read(dir.path()), (Number(10), false), "the torn copy was written anew");
    }

    #[test]
    fn a_file_that_cannot_be_read_costs_neither_the_other_one_nor_the_next_states() {
        for broken in Number::FILES {
            let dir = tempfile::tempdir().unwrap();
            let folder = LocalFolder::new(dir.path());
            let mut copies = Copies::read(&folder).0;
            copies.write_older(&folder, &Number(1)).unwrap();
            copies.write_older(&folder, &Number(2)).unwrap();
            fs::remove_file(dir.path().join(broken)).unwrap();
            fs::create_dir(dir.path().join(broken)).unwrap();
            assert_eq!(read(dir.path()).0, Number(if broken == "a" { 2 } else { 1 }));
            let mut copies = Copies::read(&folder).0;
            for number in 3..=4 {
                copies.write_older(&folder, &Number(number)).unwrap();
                assert_eq!(read(dir.path()).0, Number(number));
            }
        }
        let dir = tempfile::tempdir().unwrap();
        for name in Number::FILES {
            fs::create_dir(dir.path().join(name)).unwrap();
        }
        assert!(matches!(Copies::<Number>::read(&LocalFolder::new(dir.path())).1, Found::Unreadable(_)));
        fs::remove_dir(dir.path().join("a")).unwrap();
        fs::write(dir.path().join("a"), "torn").unwrap();
        fs::remove_dir(dir.path().join("b")).unwrap();
        assert!(matches!(Copies::<Number>::read(&LocalFolder::new(dir.path())).1, Found::Damaged));
    }
}

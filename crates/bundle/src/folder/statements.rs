//! Statements about keys in a folder of bundles.
//!
//! Owns their file, to which statements are only added, and the objects with its contents at the time a seal was
//! signed. Permissions of keys are checked in `trust`.
//!
//! Start at [`Folder::add_statements`].
#![allow(clippy::missing_errors_doc, reason = "every operation fails with `FolderError`")]

use std::io::{self, Read};
use std::path::Path;

use crate::folder::{Folder, FolderError};
use crate::limits;
use crate::names::ObjectId;
use crate::source::STATEMENTS;
use durable::too_large;

impl Folder {
    /// Adds these statements about keys to the file, as far as there is space for the old ones.
    pub fn add_statements(&self, statements: &[Vec<u8>]) -> Result<(), FolderError> {
        let there = self.statements()?;
        let all = self.joined(&there, statements)?;
        if there == all { Ok(()) } else { self.replace(STATEMENTS, &all) }
    }

    /// Adds an object with these statements and the existing ones, as [`add_statements`](Self::add_statements) would
    /// write them. Returns the object and its size in bytes; `None` if there are none.
    pub fn put_statements(&self, statements: &[Vec<u8>]) -> Result<Option<(ObjectId, u64)>, FolderError> {
        let all = self.joined(&self.statements()?, statements)?;
        if all.is_empty() {
            return Ok(None);
        }
        let (id, size) = (ObjectId::of(&all), all.len() as u64);
        self.put(&id, size, &mut &all[..], Path::new(STATEMENTS), &mut |_| ())?;
        Ok(Some((id, size)))
    }

    /// The file's contents up to the limit that units read; empty if there is no such file.
    fn statements(&self) -> Result<Vec<u8>, FolderError> {
        let mut bytes = Vec::new();
        match self.root.file(STATEMENTS).and_then(|file| file.take(limits::STATEMENTS).read_to_end(&mut bytes)) {
            Ok(_) => Ok(bytes),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Vec::new()),
            Err(source) => Err(FolderError::Read { path: self.path.join(STATEMENTS), source }),
        }
    }

    /// The statements in `there`, and the missing ones of `statements`. If there is no space for both, the new ones
    /// win: somebody may have filled the file on purpose.
    fn joined(&self, there: &[u8], statements: &[Vec<u8>]) -> Result<Vec<u8>, FolderError> {
        let known = crate::trust::statements(there);
        let mut new: Vec<&[u8]> = Vec::new();
        for statement in statements {
            if !known.contains(&&statement[..]) && !new.contains(&&statement[..]) {
                new.push(statement);
            }
        }
        if new.is_empty() {
            return Ok(there.to_vec());
        }
        let room = usize::try_from(limits::STATEMENTS).unwrap_or(usize::MAX);
        let length = |statements: &[&[u8]]| statements.iter().map(|statement| statement.len()).sum::<usize>();
        if length(&known) + length(&new) <= room {
            return Ok([known, new].concat().concat());
        }
        if length(&new) > room {
            return Err(self.unwritten(STATEMENTS)(too_large(limits::STATEMENTS)));
        }
        let mut all = new.concat();
        for statement in known {
            if all.len() + statement.len() <= room {
                all.extend(statement);
            }
        }
        Ok(all)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::envelope::SignError;
    use crate::refusal::Refusal;
    use crate::seal::tests::letter;
    use crate::seal::{SealBody, UnverifiedSeal};
    use crate::secret::tests::{artist, stranger};
    use crate::trust::{Statement, Trust, statements};
    use std::fs;

    #[test]
    fn statements_are_added_once_and_a_full_file_gives_way_to_what_is_new() {
        let scratch = tempfile::tempdir().unwrap();
        let folder = Folder::create(scratch.path()).unwrap();
        let path = scratch.path().join(STATEMENTS);
        assert_eq!(folder.put_statements(&[]).unwrap(), None);
        let words = [
            Statement::Trust(stranger().public()).sign(artist()).unwrap(),
            Statement::Revoke(artist().public().id()).sign(artist()).unwrap(),
        ];
        let (id, size) = folder.put_statements(&words).unwrap().unwrap();
        assert!(folder.holds(&id, size) && !path.exists(), "a seal may expect what is laid out only then");
        for _ in 0..2 {
            folder.add_statements(&words).unwrap();
            folder.add_statements(&words[..1]).unwrap();
            assert_eq!(fs::read(&path).unwrap(), words.concat());
        }
        assert_eq!(ObjectId::of(&words.concat()), id);
        let others: Vec<u8> = (0..40_000).flat_map(|at| format!("{at}\n\n\n\n\n\n").into_bytes()).collect();
        fs::write(&path, &others).unwrap();
        folder.add_statements(&words).unwrap();
        let bytes = fs::read(&path).unwrap();
        assert!(bytes.len() as u64 <= limits::STATEMENTS);
        let lie = statements(&bytes);
        assert!(lie.starts_with(&[&words[0], &words[1]]) && lie.len() > 10_000, "{}", lie.len());
    }

    #[test]
    fn a_seal_is_read_with_the_statements_that_it_expects_or_refused() {
        let scratch = tempfile::tempdir().unwrap();
        let mut folder = Folder::create(scratch.path()).unwrap();
        let said = Statement::Trust(stranger().public()).sign(artist()).unwrap();
        let statements = folder.put_statements(std::slice::from_ref(&said)).unwrap();
        let (id, size) = statements.unwrap();
        let letter = SealBody { statements, ..letter(8) };
        let trust = Trust::of([artist().public()]);
        let seal = |letter: &SealBody| UnverifiedSeal::new(letter.sign(artist()).unwrap()).verify(&trust).unwrap();
        let bound = seal(&letter);
        assert!(bound.letter() == &letter && bound.bytes().ends_with(format!("statements {size} {id}\n").as_bytes()));
        assert_eq!(bound.expected_statements(&mut folder).unwrap(), said);
        let plain = seal(&SealBody { statements: None, ..letter.clone() });
        assert_eq!(plain.expected_statements(&mut folder).unwrap(), b"");

        let path = scratch.path().join(id.path());
        for other in [&said[..said.len() - 1], b"", &said.repeat(2)[1..]] {
            fs::write(&path, other).unwrap();
            let refused = bound.expected_statements(&mut folder).unwrap_err();
            let other = ObjectId::of(&other[..other.len().min(said.len())]);
            let is_withheld = matches!(refused, Refusal::Withheld { expected, found: Some(found) } if (expected, found) == (id, other));
            assert!(is_withheld, "{refused}");
        }
        fs::remove_file(&path).unwrap();
        let refused = bound.expected_statements(&mut folder).unwrap_err();
        assert_eq!(
            refused.to_string(),
            format!("the statements about keys are missing or outdated: the seal expects {id}, found nothing")
        );
        let large = SealBody { statements: Some((id, limits::STATEMENTS + 1)), ..letter };
        assert!(matches!(large.sign(artist()), Err(SignError::Refused(Refusal::TooLarge { .. }))));
    }
}

//! Whom a unit trusts.
//!
//! Owns the set of keys: those that the owner laid into a folder, and what they said since about others. A *statement*
//! is a signed text of one line: `trust KEY` takes a new key in (rotation), `revoke ID` calls one back. Statements are
//! kept in the order in which they were learned, and that order counts:
//!
//! - A trusted key may take in others. A revoked key says nothing any more, except to revoke.
//! - A key is called back by itself or by the key that took it in; for good. What it took in before stays.
//! - The owner's keys are called back by themselves only: a stolen key cannot lock out the spare one.
//!
//! Never stores anything: the store of a unit does.
//!
//! Start at [`Trust::read`].

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use flock::told;

use crate::key::{KeyError, KeyId, PublicKey};
use crate::limits;
use crate::refused::{Part, Refused};
use crate::secret::SecretKey;
use crate::signed::Signed;

/// The first line of a statement.
const HEADING: &str = "dreams key statement 1";
/// The ending of a public key's file.
const ENDING: &str = ".pub";

/// The keys that are trusted, and those that were called back.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Trust {
    keys: BTreeMap<KeyId, Trusted>,
    revoked: BTreeSet<KeyId>,
}

/// What a statement says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Statement {
    /// This key is to be called back.
    Revoke(KeyId),
    /// This key is to be trusted, too.
    Trust(PublicKey),
}

/// What a statement changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Learned {
    /// Nothing: it was known.
    Nothing,
    /// This key is called back.
    Revoked(KeyId),
    /// This key is trusted from now on.
    Trusted(KeyId),
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct Trusted {
    key: PublicKey,
    /// Who took it in; `None` for the owner's.
    by: Option<KeyId>,
}

impl Trust {
    /// Trusts `keys`, and nobody else. Of two keys with the same id the first counts.
    pub fn of(keys: impl IntoIterator<Item = PublicKey>) -> Self {
        let mut trust = Self::default();
        for key in keys {
            trust.keys.entry(key.id()).or_insert(Trusted { key, by: None });
        }
        trust
    }

    /// Trusts the keys in the files `*.pub` of `folder`, or the key in the file `folder`.
    ///
    /// # Errors
    /// [`KeyError`] if one of them is no key, or two have the same id.
    pub fn read(folder: &Path) -> Result<Self, KeyError> {
        let unread = |source| KeyError::Read { path: folder.to_owned(), source };
        let mut paths = Vec::new();
        if fs::metadata(folder).map_err(unread)?.is_dir() {
            for entry in fs::read_dir(folder).map_err(unread)? {
                let path = entry.map_err(unread)?.path();
                let named = path.file_name().and_then(|name| name.to_str());
                paths.extend(named.is_some_and(|name| name.ends_with(ENDING)).then_some(path));
                if paths.len() > limits::TRUSTED_KEYS {
                    return Err(KeyError::TooMany { path: folder.to_owned(), limit: limits::TRUSTED_KEYS });
                }
            }
        } else {
            paths.push(folder.to_owned());
        }
        paths.sort();
        let mut trust = Self::default();
        for path in paths {
            let key = PublicKey::read(&path)?;
            let id = key.id();
            if trust.keys.insert(id, Trusted { key, by: None }).is_some() {
                return Err(KeyError::SameId { path, id });
            }
        }
        Ok(trust)
    }

    /// The keys that are trusted.
    pub fn keys(&self) -> impl Iterator<Item = &PublicKey> {
        self.keys.iter().filter(|(id, _)| !self.revoked.contains(id)).map(|(_, trusted)| &trusted.key)
    }

    /// The keys that were called back.
    pub fn revoked(&self) -> impl Iterator<Item = KeyId> {
        self.revoked.iter().copied()
    }

    /// Learns what one signed statement says.
    ///
    /// # Errors
    /// [`Refused`] if it is not signed by a key that may say so. Nothing was learned.
    pub fn learn(&mut self, statement: &[u8]) -> Result<Learned, Refused> {
        let part = Part::Statement;
        if statement.len() as u64 > limits::SEAL {
            return Err(Refused::TooLarge { part, limit: limits::SEAL });
        }
        let signed = Signed::open(&part, statement)?;
        let signer = self.known(&part, signed.signer)?;
        match read(signed.text(&part, signer.key.verifier(), HEADING)?)? {
            Statement::Revoke(id) => {
                let unknown = || self.unknown(&part, signed.signer);
                let entitled = id == signed.signer || self.keys.get(&id).is_some_and(|t| t.by == Some(signed.signer));
                if !entitled {
                    return Err(unknown());
                }
                Ok(if self.revoked.insert(id) { Learned::Revoked(id) } else { Learned::Nothing })
            }
            Statement::Trust(key) => {
                self.not_revoked(&part, signed.signer)?;
                let id = key.id();
                if self.keys.contains_key(&id) {
                    return Ok(Learned::Nothing);
                }
                if self.keys.len() >= limits::TRUSTED_KEYS {
                    return Err(Refused::TooMany { part, limit: limits::TRUSTED_KEYS, things: "keys" });
                }
                self.keys.insert(id, Trusted { key, by: Some(signed.signer) });
                Ok(Learned::Trusted(id))
            }
        }
    }

    /// The text of `bytes`, which a trusted key must have signed, and whose that is.
    pub(crate) fn verify<'a>(&self, part: &Part, bytes: &'a [u8], heading: &str) -> Result<(KeyId, &'a str), Refused> {
        let signed = Signed::open(part, bytes)?;
        let signer = self.known(part, signed.signer)?;
        self.not_revoked(part, signed.signer)?;
        Ok((signed.signer, signed.text(part, signer.key.verifier(), heading)?))
    }

    fn known(&self, part: &Part, id: KeyId) -> Result<&Trusted, Refused> {
        self.keys.get(&id).ok_or_else(|| self.unknown(part, id))
    }

    fn not_revoked(&self, part: &Part, signer: KeyId) -> Result<(), Refused> {
        if self.revoked.contains(&signer) { Err(Refused::RevokedKey { part: part.clone(), signer }) } else { Ok(()) }
    }

    fn unknown(&self, part: &Part, signer: KeyId) -> Refused {
        Refused::UnknownKey { part: part.clone(), signer, trusted: self.keys().map(PublicKey::id).collect() }
    }
}

impl Statement {
    /// The statement, signed: the bytes of its file.
    ///
    /// # Errors
    /// [`KeyError::Sign`] if the system gives no randomness.
    pub fn sign(&self, key: &SecretKey) -> Result<Vec<u8>, KeyError> {
        let said = match self {
            Self::Revoke(id) => format!("revoke {id}"),
            Self::Trust(key) => format!("trust {}", key.line()),
        };
        key.sign("a statement about a key", &format!("{HEADING}\n{said}\n"))
    }
}

/// The single statements in the file that a bundle carries, one after the other; what is no statement ends them.
pub fn statements(bytes: &[u8]) -> Vec<&[u8]> {
    /// Lines of a statement: its signature, its heading, what it says.
    const LINES: usize = 6;
    let mut rest = bytes;
    let mut found = Vec::new();
    while found.len() < limits::STATEMENT_COUNT {
        let mut ends = rest.iter().enumerate().filter(|(_, byte)| **byte == b'\n').map(|(at, _)| at + 1);
        let Some(end) = ends.nth(LINES - 1) else { break };
        let (statement, behind) = rest.split_at(end);
        found.push(statement);
        rest = behind;
    }
    found
}

fn read(text: &str) -> Result<Statement, Refused> {
    let said = text.strip_prefix(HEADING).and_then(|rest| rest.strip_prefix('\n')).unwrap_or_default();
    let line = said.strip_suffix('\n').unwrap_or(said);
    let read = match line.split_once(' ') {
        Some(("revoke", id)) => KeyId::parse(id).map(Statement::Revoke),
        Some(("trust", key)) => PublicKey::parse(key).map(Statement::Trust),
        Some(_) | None => None,
    };
    let wanted = "`trust` and a key, or `revoke` and a key's id";
    read.ok_or_else(|| Refused::Line { part: Part::Statement, line: 2, wanted, found: told(said) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::secret::tests::{artist, stranger};

    const PART: Part = Part::Seal;

    fn trusts(trust: &Trust, key: &SecretKey) -> bool {
        let signed = key.sign("a test", "dreams test 1\n").unwrap();
        trust.verify(&PART, &signed, "dreams test 1").is_ok()
    }

    fn says(key: &SecretKey, statement: &Statement) -> Vec<u8> {
        statement.sign(key).unwrap()
    }

    #[test]
    fn a_new_key_is_taken_in_by_a_trusted_one_and_by_no_other() {
        let (new, other) = (stranger(), stranger());
        let mut trust = Trust::of([artist().public()]);
        assert!(trusts(&trust, artist()) && !trusts(&trust, &new));
        let taken_in = Statement::Trust(new.public());
        assert!(matches!(trust.learn(&says(&other, &taken_in)), Err(Refused::UnknownKey { .. })));
        assert!(matches!(trust.learn(&says(&new, &taken_in)), Err(Refused::UnknownKey { .. })));
        let word = says(artist(), &taken_in);
        assert_eq!(trust.learn(&word).unwrap(), Learned::Trusted(new.public().id()));
        assert_eq!(trust.learn(&word).unwrap(), Learned::Nothing);
        assert!(trusts(&trust, &new) && !trusts(&trust, &other));
        // And on: the new key takes in another.
        trust.learn(&says(&new, &Statement::Trust(other.public()))).unwrap();
        assert!(trusts(&trust, &other));
    }

    #[test]
    fn a_key_is_called_back_by_itself_or_by_whom_it_was_taken_in_and_for_good() {
        let (spare, new) = (stranger(), stranger());
        let pinned = Trust::of([artist().public(), spare.public()]);
        for (caller, called, works) in [
            (artist(), artist(), true),
            (artist(), &spare, false),
            (&spare, artist(), false),
            (artist(), &new, true),
            (&spare, &new, false),
            (&new, &new, true),
            (&new, artist(), false),
        ] {
            let mut trust = pinned.clone();
            trust.learn(&says(artist(), &Statement::Trust(new.public()))).unwrap();
            let learned = trust.learn(&says(caller, &Statement::Revoke(called.public().id())));
            assert_eq!(learned.is_ok(), works);
            assert_eq!(trusts(&trust, called), !works);
            if works {
                trust.learn(&says(artist(), &Statement::Trust(called.public()))).ok();
                assert!(!trusts(&trust, called), "a key that was called back does not come again");
            }
        }
    }

    #[test]
    fn a_revoked_key_takes_nobody_in_and_what_it_took_in_stays() {
        let (before, after) = (stranger(), stranger());
        let mut trust = Trust::of([artist().public()]);
        trust.learn(&says(artist(), &Statement::Trust(before.public()))).unwrap();
        trust.learn(&says(artist(), &Statement::Revoke(artist().public().id()))).unwrap();
        let late = trust.learn(&says(artist(), &Statement::Trust(after.public())));
        assert!(matches!(late, Err(Refused::RevokedKey { .. })));
        assert!(trusts(&trust, &before) && !trusts(&trust, &after) && !trusts(&trust, artist()));
        let signed = artist().sign("x", "dreams test 1\n").unwrap();
        let refused = trust.verify(&PART, &signed, "dreams test 1");
        assert!(matches!(refused, Err(Refused::RevokedKey { .. })));
        // Whom it took in by mistake it can still call back.
        trust.learn(&says(artist(), &Statement::Revoke(before.public().id()))).unwrap();
        assert!(!trusts(&trust, &before));
    }

    #[test]
    fn statements_lie_one_after_the_other() {
        let (one, two) = (
            says(artist(), &Statement::Trust(stranger().public())),
            says(artist(), &Statement::Revoke(artist().public().id())),
        );
        let file = [&one[..], &two, b"cut off\n"].concat();
        assert_eq!(statements(&file), [&one[..], &two]);
        assert_eq!(statements(&file[..one.len() + 5]), [&one[..]]);
        let many = one.repeat(limits::STATEMENT_COUNT + 1);
        assert_eq!(statements(&many).len(), limits::STATEMENT_COUNT);
    }

    #[test]
    fn a_folder_of_keys_is_trusted_as_a_whole_and_read_strictly() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("artist.pub"), artist().public().to_text()).unwrap();
        fs::write(folder.path().join("readme.txt"), "not a key").unwrap();
        let trust = Trust::read(folder.path()).unwrap();
        assert!(trusts(&trust, artist()));
        assert_eq!(trust, Trust::read(&folder.path().join("artist.pub")).unwrap());
        fs::write(folder.path().join("twin.pub"), artist().public().to_text()).unwrap();
        assert!(matches!(Trust::read(folder.path()), Err(KeyError::SameId { .. })));
        fs::write(folder.path().join("twin.pub"), "nothing").unwrap();
        assert!(matches!(Trust::read(folder.path()), Err(KeyError::Malformed { .. })));
        assert!(matches!(Trust::read(&folder.path().join("no")), Err(KeyError::Read { .. })));
    }
}

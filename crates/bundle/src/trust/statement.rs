//! Statements of keys about keys.
//!
//! Owns its only spelling, signed and unsigned, and the splitting of a file of statements. [`crate::Trust`] checks
//! permissions.
//!
//! ```text
//! trust KEY             a new key is to be trusted
//! revoke ID             a key is revoked; the keys that it added stay
//! revoke ID keep KEY...   a key is revoked with all keys that it added, except these
//! ```
//!
//! Keys to keep are given in full, because a thief can create a key with any id.
//!
//! Start at [`Statement`].

use std::collections::BTreeSet;

use flock::excerpt;

use crate::key::{KeyError, KeyId, PublicKey};
use crate::limits;
use crate::refusal::{Part, Refusal};
use crate::secret::SecretKey;

/// The first line of a statement.
pub(super) const HEADING: &str = "dreams key statement 1";
/// Lines of a statement: signature, heading, text.
const LINES: usize = 6;
/// The word before the keys to keep.
const KEEP: &str = "keep";

/// A statement about a key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Statement {
    /// Revoke this key, and keep the keys that it added.
    Revoke(KeyId),
    /// Revoke this key and all keys that it added, except these: at most [`limits::KEPT`].
    Stolen(KeyId, BTreeSet<PublicKey>),
    /// This key is to be trusted, too.
    Trust(PublicKey),
}

impl Statement {
    /// Signs the statement; returns the bytes of its file.
    ///
    /// # Errors
    /// [`KeyError::Sign`] if there is no randomness.
    pub fn sign(&self, key: &SecretKey) -> Result<Vec<u8>, KeyError> {
        let said = match self {
            Self::Revoke(id) => format!("revoke {id}"),
            Self::Stolen(id, kept) => {
                kept.iter().fold(format!("revoke {id} {KEEP}"), |said, key| said + " " + key.line())
            }
            Self::Trust(key) => format!("trust {}", key.line()),
        };
        key.sign("a statement about a key", &format!("{HEADING}\n{said}\n"))
    }

    /// Parses the text below the signature.
    pub(super) fn read(text: &str) -> Result<Self, Refusal> {
        let said = text.strip_prefix(HEADING).and_then(|rest| rest.strip_prefix('\n')).unwrap_or_default();
        let line = said.strip_suffix('\n').unwrap_or(said);
        let read = match line.split_once(' ') {
            Some(("revoke", rest)) => Self::revocation(rest)?,
            Some(("trust", key)) => PublicKey::parse(key).map(Self::Trust),
            Some(_) | None => None,
        };
        let wanted = "`trust` and a key, or `revoke`, a key's id, and perhaps `keep` and keys in order";
        read.ok_or_else(|| Refusal::Line { part: Part::Statement, line: 2, wanted, found: excerpt(said) })
    }

    fn revocation(text: &str) -> Result<Option<Self>, Refusal> {
        let mut words = text.split(' ');
        let Some(id) = words.next().and_then(KeyId::parse) else { return Ok(None) };
        match words.next() {
            None => return Ok(Some(Self::Revoke(id))),
            Some(KEEP) => {}
            Some(_) => return Ok(None),
        }
        let mut kept: BTreeSet<PublicKey> = BTreeSet::new();
        for word in words {
            if kept.len() == limits::KEPT {
                return Err(Refusal::TooMany { part: Part::Statement, limit: limits::KEPT, things: "keys to keep" });
            }
            let key = PublicKey::parse(word).filter(|key| kept.last().is_none_or(|last| last < key));
            let Some(key) = key else { return Ok(None) };
            kept.insert(key);
        }
        Ok(Some(Self::Stolen(id, kept)))
    }
}

/// The statements in a bundle's file; the first invalid one ends them.
pub fn statements(bytes: &[u8]) -> Vec<&[u8]> {
    let mut rest = bytes;
    let mut found = Vec::new();
    loop {
        let mut ends = rest.iter().enumerate().filter(|(_, byte)| **byte == b'\n').map(|(at, _)| at + 1);
        let Some(end) = ends.nth(LINES - 1) else { return found };
        let (statement, behind) = rest.split_at(end);
        found.push(statement);
        rest = behind;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::secret::tests::{artist, stranger};

    fn says(key: &SecretKey, statement: &Statement) -> Vec<u8> {
        statement.sign(key).unwrap()
    }

    #[test]
    fn statements_lie_one_after_the_other_however_many() {
        let (one, two) = (
            says(artist(), &Statement::Trust(stranger().public())),
            says(artist(), &Statement::Revoke(artist().public().id())),
        );
        let file = [&one[..], &two, b"cut off\n"].concat();
        assert_eq!(statements(&file), [&one[..], &two]);
        assert_eq!(statements(&file[..one.len() + 5]), [&one[..]]);
        let many = [one.repeat(500), two.clone()].concat();
        assert_eq!(statements(&many).last(), Some(&&two[..]), "no number of others hides the last one");
    }

    #[test]
    fn a_statement_has_one_spelling() {
        let id = artist().public().id();
        let keys: BTreeSet<_> = [stranger().public(), stranger().public()].into();
        for statement in [
            Statement::Revoke(id),
            Statement::Stolen(id, BTreeSet::new()),
            Statement::Stolen(id, keys.clone()),
            Statement::Trust(stranger().public()),
        ] {
            let bytes = String::from_utf8(says(artist(), &statement)).unwrap();
            let text: String = bytes.split_inclusive('\n').skip(4).collect();
            assert_eq!(Statement::read(&text).unwrap(), statement);
        }
        let (one, two) = (keys.first().unwrap().line(), keys.last().unwrap().line());
        for said in [
            format!("revoke {id} "),
            format!("revoke {id} keep "),
            format!("revoke {id} keep  {one}"),
            format!("revoke {id} keep {two} {one}"),
            format!("revoke {id} keep {one} {one}"),
            format!("revoke {id} kept {one}"),
            format!("revoke keep {one}"),
            format!("trust {one}{two}"),
        ] {
            let read = Statement::read(&format!("{HEADING}\n{said}\n"));
            assert!(matches!(read, Err(Refusal::Line { line: 2, .. })), "{said}: {read:?}");
        }
        let many: BTreeSet<_> = (0..=limits::KEPT).map(|_| stranger().public()).collect();
        let many = many.iter().fold(String::new(), |said, key| said + " " + key.line());
        let read = Statement::read(&format!("{HEADING}\nrevoke {id} keep{many}\n"));
        assert!(matches!(read, Err(Refusal::TooMany { limit: limits::KEPT, .. })), "{read:?}");
    }
}

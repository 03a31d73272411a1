//! The keys that a unit trusts.
//!
//! Owns the set of keys: those in the owner's folder, and the learned statements about others. The status of keys is
//! computed in `standing.rs`; permissions are checked here:
//!
//! - A trusted key may add others. Of a revoked key only revocations count, and its statements for keys that a
//!   revocation keeps by name.
//! - The owner's keys are revoked only by themselves: a stolen key cannot lock out the spare one.
//! - Quotas are in `quota.rs`. Statements that no longer count are forgotten.
//!
//! Within the quotas the order of learning makes no difference, with two exceptions: statements of a key are ignored
//! before that key is added, unless both are in one file; and keys added before a plain revocation of their signer
//! stay, those added afterwards do not count.
//!
//! The store of a unit saves the statements.
//!
//! Start at [`Trust::read`].

mod quota;
mod standing;
mod statement;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use crate::key::{KeyError, KeyId, PublicKey};
use crate::limits;
use crate::refusal::{Part, Refusal};
use crate::signed::SignedText;
use standing::{KeptKeys, KeyStatuses};
use statement::HEADING;

pub use statement::{Statement, statements};

/// The ending of a public key's file.
const ENDING: &str = ".pub";
/// How often a file of statements is read again while it brings changes: a key's statements may stand before the one
/// that adds it.
const TURNS: usize = 16;

/// The trusted and the revoked keys.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Trust {
    /// The owner's.
    pinned: BTreeMap<KeyId, PublicKey>,
    /// The statements that count, in the order in which they were learned.
    words: Vec<SignedStatement>,
    standing: KeyStatuses,
}

/// The change by a statement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrustChange {
    /// This key is not trusted any more, because the keys that added it were revoked.
    Fallen(KeyId),
    /// The statement was saved; the status of this key is unchanged.
    Noted(KeyId),
    /// Nothing: it was known.
    Nothing,
    /// This key is revoked.
    Revoked(KeyId),
    /// This key is trusted from now on.
    Trusted(KeyId),
}

/// The changes by a file of statements.
#[derive(Debug, Default)]
pub struct TrustUpdate {
    /// The changes.
    pub news: Vec<TrustChange>,
    /// The statements above quota.
    pub refused: Vec<Refusal>,
}

/// A statement with its signer.
#[derive(Clone, Debug, PartialEq, Eq)]
struct SignedStatement {
    signer: PublicKey,
    said: Statement,
    /// Signature and all.
    text: String,
}

/// Whether quotas hold.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Quotas {
    Hold,
    /// The statements were learned before.
    Rest,
}

impl Trust {
    /// Trusts only `keys`. Of two keys with the same id the first counts.
    pub fn of(keys: impl IntoIterator<Item = PublicKey>) -> Self {
        let mut pinned = BTreeMap::new();
        for key in keys {
            pinned.entry(key.id()).or_insert(key);
        }
        Self::pinning(pinned)
    }

    fn pinning(pinned: BTreeMap<KeyId, PublicKey>) -> Self {
        let standing = KeyStatuses::of(&pinned, &[]);
        Self { pinned, words: Vec::new(), standing }
    }

    /// Trusts the keys in the files `*.pub` of `folder`, or the key in the file `folder`.
    ///
    /// # Errors
    /// [`KeyError`] if one of them is not a key, or two have the same id.
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
        let mut pinned = BTreeMap::new();
        for path in paths {
            let key = PublicKey::read(&path)?;
            let id = key.id();
            if pinned.insert(id, key).is_some() {
                return Err(KeyError::SameId { path, id });
            }
        }
        Ok(Self::pinning(pinned))
    }

    /// The keys that are trusted.
    pub fn keys(&self) -> impl Iterator<Item = &PublicKey> {
        self.standing.all().filter(|(_, stand)| stand.is_trusted).map(|(key, _)| key)
    }

    /// The keys that were called back.
    pub fn revoked(&self) -> impl Iterator<Item = KeyId> {
        self.standing.all().filter(|(_, stand)| !stand.is_trusted).map(|(key, _)| key.id())
    }

    /// The statements that count, in the order in which they were learned.
    pub fn said(&self) -> impl Iterator<Item = &str> {
        self.words.iter().map(|word| &*word.text)
    }

    /// Learns one signed statement.
    ///
    /// # Errors
    /// [`Refusal`] if its signer has no permission, or its quota is exceeded. Nothing was learned.
    pub fn learn(&mut self, statement: &[u8]) -> Result<TrustChange, Refusal> {
        self.apply(statement, Quotas::Hold)
    }

    /// Learns a file of statements in any order. Statements without permission are ignored.
    pub fn learn_all(&mut self, file: &[u8]) -> TrustUpdate {
        self.apply_all(file, Quotas::Hold)
    }

    /// Learns saved statements again.
    pub(crate) fn relearn(&mut self, file: &[u8]) {
        self.apply_all(file, Quotas::Rest);
    }

    /// Verifies that a trusted key signed `bytes`; returns the key and the text.
    pub(crate) fn verify<'a>(&self, part: &Part, bytes: &'a [u8], heading: &str) -> Result<(KeyId, &'a str), Refusal> {
        let (signer, text) = self.signed(part, bytes, heading)?;
        let is_trusted = self.standing.get(signer).is_some_and(|stand| stand.is_trusted);
        if is_trusted { Ok((signer.id(), text)) } else { Err(revoked(part, signer)) }
    }

    fn apply_all(&mut self, file: &[u8], quotas: Quotas) -> TrustUpdate {
        let trusted = |trust: &Self| trust.keys().map(PublicKey::id).collect::<BTreeSet<KeyId>>();
        let before = trusted(self);
        let (mut left, mut lesson) = (statements(file), TrustUpdate::default());
        for _ in 0..TURNS {
            let known = lesson.news.len();
            lesson.refused.clear();
            left.retain(|statement| match self.apply(statement, quotas) {
                Ok(learned) => {
                    lesson.news.extend((learned != TrustChange::Nothing).then_some(learned));
                    true
                }
                Err(refused @ Refusal::Quota { .. }) => {
                    lesson.refused.push(refused);
                    true
                }
                Err(Refusal::UnknownKey { .. } | Refusal::RevokedKey { .. } | Refusal::Forged { .. }) => true,
                Err(_) => false,
            });
            if lesson.news.len() == known {
                break;
            }
        }
        let after = trusted(self);
        let fallen = before.difference(&after).map(|id| TrustChange::Fallen(*id));
        let said: Vec<TrustChange> = lesson.news.clone();
        let is_told = |fallen: &TrustChange| matches!(fallen, TrustChange::Fallen(id) if said.contains(&TrustChange::Revoked(*id)));
        lesson.news.extend(fallen.filter(|fallen| !is_told(fallen)));
        lesson
    }

    fn apply(&mut self, statement: &[u8], quotas: Quotas) -> Result<TrustChange, Refusal> {
        let part = Part::Statement;
        if statement.len() as u64 > limits::SEAL {
            return Err(Refusal::TooLarge { part, limit: limits::SEAL });
        }
        let (signer, text) = self.signed(&part, statement, HEADING)?;
        let (signer, said) = (signer.clone(), Statement::read(text)?);
        let text = String::from_utf8_lossy(statement).into_owned();
        let word = SignedStatement { signer, said, text };
        let is_news = match &word.said {
            Statement::Trust(key) => self.may_take_in(&word.signer, key)?,
            Statement::Revoke(id) | Statement::Stolen(id, _) => self.may_revoke(&word, *id)?,
        };
        if !is_news {
            return Ok(TrustChange::Nothing);
        }
        if quotas == Quotas::Hold {
            quota::has_room(&self.pinned, &self.words, &word)?;
        }
        let subject = word.subject();
        let is_trusted = |trust: &Self| trust.standing.with_id(subject).any(|(_, stand)| stand.is_trusted);
        let before = is_trusted(self);
        self.keep(word);
        Ok(match (before, is_trusted(self)) {
            (false, true) => TrustChange::Trusted(subject),
            (true, false) => TrustChange::Revoked(subject),
            (true, true) | (false, false) => TrustChange::Noted(subject),
        })
    }

    /// Whether `signer` may add `key`, and that is new.
    fn may_take_in(&self, signer: &PublicKey, key: &PublicKey) -> Result<bool, Refusal> {
        let stand = self.standing.get(signer);
        let is_kept = stand.is_some_and(|stand| matches!(&stand.kept, KeptKeys::Only(kept) if kept.contains(key)));
        if !is_kept && !stand.is_some_and(|stand| stand.is_trusted) {
            return Err(revoked(&Part::Statement, signer));
        }
        let is_owners = signer == key || self.pinned.contains_key(&key.id());
        let is_known =
            self.words.iter().any(|word| word.signer == *signer && word.said == Statement::Trust(key.clone()));
        Ok(!is_owners && !is_known)
    }

    /// Whether `word` may revoke the key `id`, and that is new.
    fn may_revoke(&self, word: &SignedStatement, id: KeyId) -> Result<bool, Refusal> {
        if id != word.signer.id() && self.pinned.contains_key(&id) {
            return Err(self.unknown(&Part::Statement, word.signer.id()));
        }
        let Some((_, kept)) = word.said.as_revocation() else { return Ok(false) };
        let there = self.revocation(&word.signer, id);
        Ok(there.is_none_or(|there| there.and(&kept) != there))
    }

    /// The keys added by `id` that the revocation by `signer` keeps; `None` if there is no such revocation.
    fn revocation(&self, signer: &PublicKey, id: KeyId) -> Option<KeptKeys> {
        let revocations =
            self.words.iter().filter(|word| word.signer == *signer).filter_map(|word| word.said.as_revocation());
        revocations.filter(|(called, _)| *called == id).map(|(_, kept)| kept).reduce(|one, two| one.and(&two))
    }

    /// Adds `word`, and removes statements that no longer count.
    fn keep(&mut self, word: SignedStatement) {
        let known = |standing: &KeyStatuses, key: &PublicKey| standing.get(key).is_some();
        let before = std::mem::take(&mut self.standing);
        self.words.retain(|there| !word.implies(there));
        self.words.push(word);
        self.standing = KeyStatuses::of(&self.pinned, &self.words);
        let standing = &self.standing;
        self.words.retain(|word| match (standing.get(&word.signer), &word.said) {
            (Some(stand), Statement::Trust(key)) => stand.kept.includes(key),
            (Some(_), Statement::Revoke(_) | Statement::Stolen(..)) => true,
            // Statements about keys that were unknown before are kept: the owner may remove keys and add them again.
            (None, _) => !known(&before, &word.signer),
        });
    }

    /// The known key that signed `bytes`, and the text.
    fn signed<'a>(&self, part: &Part, bytes: &'a [u8], heading: &str) -> Result<(&PublicKey, &'a str), Refusal> {
        let signed = SignedText::open(part, bytes)?;
        let mut refused = self.unknown(part, signed.signer);
        for (key, _) in self.standing.with_id(signed.signer) {
            match signed.text(part, key.verifier(), heading) {
                Ok(text) => return Ok((key, text)),
                Err(forged) => refused = forged,
            }
        }
        Err(refused)
    }

    fn unknown(&self, part: &Part, signer: KeyId) -> Refusal {
        Refusal::UnknownKey { part: part.clone(), signer, trusted: self.keys().map(PublicKey::id).collect() }
    }
}

impl SignedStatement {
    /// The key that it speaks of.
    fn subject(&self) -> KeyId {
        match &self.said {
            Statement::Revoke(id) | Statement::Stolen(id, _) => *id,
            Statement::Trust(key) => key.id(),
        }
    }

    /// Whether this statement makes `other` redundant. A plain revocation stays beside one with `keep`, for older
    /// programs that know only the plain one.
    fn implies(&self, other: &Self) -> bool {
        match (&self.said, &other.said) {
            (Statement::Stolen(id, kept), Statement::Stolen(other_id, others)) => {
                self.signer == other.signer && id == other_id && kept.is_subset(others)
            }
            _ => false,
        }
    }
}

fn revoked(part: &Part, signer: &PublicKey) -> Refusal {
    Refusal::RevokedKey { part: part.clone(), signer: signer.id() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::secret::SecretKey;
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
        assert!(matches!(trust.learn(&says(&other, &taken_in)), Err(Refusal::UnknownKey { .. })));
        assert!(matches!(trust.learn(&says(&new, &taken_in)), Err(Refusal::UnknownKey { .. })));
        let word = says(artist(), &taken_in);
        assert_eq!(trust.learn(&word).unwrap(), TrustChange::Trusted(new.public().id()));
        assert_eq!(trust.learn(&word).unwrap(), TrustChange::Nothing);
        assert!(trusts(&trust, &new) && !trusts(&trust, &other));
        // The new key adds another.
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
            (&new, &new, true),
            (&new, artist(), false),
        ] {
            let mut trust = pinned.clone();
            trust.learn(&says(artist(), &Statement::Trust(new.public()))).unwrap();
            let learned = trust.learn(&says(caller, &Statement::Revoke(called.public().id())));
            assert_eq!(learned.is_ok(), works);
            assert_eq!(trusts(&trust, called), !works);
            // A key that did not add it cannot revoke it.
            let learned = trust.learn(&says(&spare, &Statement::Revoke(new.public().id()))).unwrap();
            assert_eq!((learned, trusts(&trust, called)), (TrustChange::Noted(new.public().id()), !works));
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
        assert!(matches!(late, Err(Refusal::RevokedKey { .. })));
        assert!(trusts(&trust, &before) && !trusts(&trust, &after) && !trusts(&trust, artist()));
        let signed = artist().sign("x", "dreams test 1\n").unwrap();
        let refused = trust.verify(&PART, &signed, "dreams test 1");
        assert!(matches!(refused, Err(Refusal::RevokedKey { .. })));
        // It can still revoke a key that it added by mistake.
        trust.learn(&says(artist(), &Statement::Revoke(before.public().id()))).unwrap();
        assert!(!trusts(&trust, &before));
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

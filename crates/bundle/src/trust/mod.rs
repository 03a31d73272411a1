//! Whom a unit trusts.
//!
//! Owns the set of keys: those that the owner laid into a folder, and what was said since about others. How keys stand by
//! that is in `standing.rs`; who may say what is here:
//!
//! - A trusted key may take in others. A revoked key says nothing any more, except to revoke, and but for the keys that a
//!   revocation of it keeps by name.
//! - The owner's keys are called back by themselves only: a stolen key cannot lock out the spare one.
//! - How much, says `quota.rs`. What has fallen is forgotten.
//!
//! So the order in which statements are learned makes no difference within the quotas, but for two: what a key says is
//! passed over before anybody vouched for that key, unless both stand in one file; and what a key took in before it was
//! called back by the word that keeps all, which is the older one, stays, and what it takes in afterwards does not count.
//!
//! Never stores anything: the store of a unit does.
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
use crate::refused::{Part, Refused};
use crate::signed::Signed;
use standing::{Kept, Standing};
use statement::HEADING;

pub use statement::{Statement, statements};

/// The ending of a public key's file.
const ENDING: &str = ".pub";
/// So often a file of statements is read again as long as it brings something new: for keys that are vouched for only
/// behind what they say.
const TURNS: usize = 16;

/// The keys that are trusted, and those that were called back.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Trust {
    /// The owner's.
    pinned: BTreeMap<KeyId, PublicKey>,
    /// What was said that counts, in the order in which it was learned.
    words: Vec<Word>,
    standing: Standing,
}

/// What a statement changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Learned {
    /// This key is not trusted any more: whoever vouched for it was called back.
    Fallen(KeyId),
    /// It is remembered; this key stands as before.
    Noted(KeyId),
    /// Nothing: it was known.
    Nothing,
    /// This key is called back.
    Revoked(KeyId),
    /// This key is trusted from now on.
    Trusted(KeyId),
}

/// What a file of statements changed.
#[derive(Debug, Default)]
pub struct Lesson {
    /// What is new.
    pub news: Vec<Learned>,
    /// What was not taken in, by the quotas.
    pub refused: Vec<Refused>,
}

/// What a key said.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Word {
    signer: PublicKey,
    said: Statement,
    /// Signature and all.
    text: String,
}

/// Whether quotas hold.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Quotas {
    Hold,
    /// What is learned was learned before.
    Rest,
}

impl Trust {
    /// Trusts `keys`, and nobody else. Of two keys with the same id the first counts.
    pub fn of(keys: impl IntoIterator<Item = PublicKey>) -> Self {
        let mut pinned = BTreeMap::new();
        for key in keys {
            pinned.entry(key.id()).or_insert(key);
        }
        Self::pinning(pinned)
    }

    fn pinning(pinned: BTreeMap<KeyId, PublicKey>) -> Self {
        let standing = Standing::of(&pinned, &[]);
        Self { pinned, words: Vec::new(), standing }
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

    /// Learns what one signed statement says.
    ///
    /// # Errors
    /// [`Refused`] if it is not signed by a key that may say so, or has said as much as it may. Nothing was learned.
    pub fn learn(&mut self, statement: &[u8]) -> Result<Learned, Refused> {
        self.hear(statement, Quotas::Hold)
    }

    /// Learns from a file of statements. What is said by someone who may not say it is passed over; in which order the
    /// statements stand makes no difference.
    pub fn learn_all(&mut self, file: &[u8]) -> Lesson {
        self.hear_all(file, Quotas::Hold)
    }

    /// Learns again what was learned before.
    pub(crate) fn recall(&mut self, file: &[u8]) {
        self.hear_all(file, Quotas::Rest);
    }

    /// The text of `bytes`, which a trusted key must have signed, and whose that is.
    pub(crate) fn verify<'a>(&self, part: &Part, bytes: &'a [u8], heading: &str) -> Result<(KeyId, &'a str), Refused> {
        let (signer, text) = self.signed(part, bytes, heading)?;
        let is_trusted = self.standing.get(signer).is_some_and(|stand| stand.is_trusted);
        if is_trusted { Ok((signer.id(), text)) } else { Err(revoked(part, signer)) }
    }

    fn hear_all(&mut self, file: &[u8], quotas: Quotas) -> Lesson {
        let trusted = |trust: &Self| trust.keys().map(PublicKey::id).collect::<BTreeSet<KeyId>>();
        let before = trusted(self);
        let (mut left, mut lesson) = (statements(file), Lesson::default());
        for _ in 0..TURNS {
            let known = lesson.news.len();
            lesson.refused.clear();
            left.retain(|statement| match self.hear(statement, quotas) {
                Ok(learned) => {
                    lesson.news.extend((learned != Learned::Nothing).then_some(learned));
                    true
                }
                Err(refused @ Refused::Quota { .. }) => {
                    lesson.refused.push(refused);
                    true
                }
                Err(Refused::UnknownKey { .. } | Refused::RevokedKey { .. } | Refused::Forged { .. }) => true,
                Err(_) => false,
            });
            if lesson.news.len() == known {
                break;
            }
        }
        let after = trusted(self);
        let fallen = before.difference(&after).map(|id| Learned::Fallen(*id));
        let said: Vec<Learned> = lesson.news.clone();
        let is_told = |fallen: &Learned| matches!(fallen, Learned::Fallen(id) if said.contains(&Learned::Revoked(*id)));
        lesson.news.extend(fallen.filter(|fallen| !is_told(fallen)));
        lesson
    }

    fn hear(&mut self, statement: &[u8], quotas: Quotas) -> Result<Learned, Refused> {
        let part = Part::Statement;
        if statement.len() as u64 > limits::SEAL {
            return Err(Refused::TooLarge { part, limit: limits::SEAL });
        }
        let (signer, text) = self.signed(&part, statement, HEADING)?;
        let (signer, said) = (signer.clone(), Statement::read(text)?);
        let text = String::from_utf8_lossy(statement).into_owned();
        let word = Word { signer, said, text };
        let is_news = match &word.said {
            Statement::Trust(key) => self.may_take_in(&word.signer, key)?,
            Statement::Revoke(id) | Statement::Stolen(id, _) => self.may_call_back(&word, *id)?,
        };
        if !is_news {
            return Ok(Learned::Nothing);
        }
        if quotas == Quotas::Hold {
            quota::has_room(&self.pinned, &self.words, &word)?;
        }
        let about = word.about();
        let is_trusted = |trust: &Self| trust.standing.called(about).any(|(_, stand)| stand.is_trusted);
        let before = is_trusted(self);
        self.keep(word);
        Ok(match (before, is_trusted(self)) {
            (false, true) => Learned::Trusted(about),
            (true, false) => Learned::Revoked(about),
            (true, true) | (false, false) => Learned::Noted(about),
        })
    }

    /// Whether it is news that `signer` takes in `key`.
    fn may_take_in(&self, signer: &PublicKey, key: &PublicKey) -> Result<bool, Refused> {
        let stand = self.standing.get(signer);
        let is_kept = stand.is_some_and(|stand| matches!(&stand.kept, Kept::Only(kept) if kept.contains(key)));
        if !is_kept && !stand.is_some_and(|stand| stand.is_trusted) {
            return Err(revoked(&Part::Statement, signer));
        }
        let is_owners = signer == key || self.pinned.contains_key(&key.id());
        let is_known =
            self.words.iter().any(|word| word.signer == *signer && word.said == Statement::Trust(key.clone()));
        Ok(!is_owners && !is_known)
    }

    /// Whether it is news that this `word` calls back the key `id`.
    fn may_call_back(&self, word: &Word, id: KeyId) -> Result<bool, Refused> {
        if id != word.signer.id() && self.pinned.contains_key(&id) {
            return Err(self.unknown(&Part::Statement, word.signer.id()));
        }
        let Some((_, kept)) = word.said.call() else { return Ok(false) };
        let there = self.called(&word.signer, id);
        Ok(there.is_none_or(|there| there.and(&kept) != there))
    }

    /// What `signer` keeps of what the key `id` took in; `None` if it did not call that back.
    fn called(&self, signer: &PublicKey, id: KeyId) -> Option<Kept> {
        let calls = self.words.iter().filter(|word| word.signer == *signer).filter_map(|word| word.said.call());
        calls.filter(|(called, _)| *called == id).map(|(_, kept)| kept).reduce(|one, two| one.and(&two))
    }

    /// Remembers `word`, and forgets what no longer counts by it.
    fn keep(&mut self, word: Word) {
        let known = |standing: &Standing, key: &PublicKey| standing.get(key).is_some();
        let before = std::mem::take(&mut self.standing);
        self.words.retain(|there| !word.implies(there));
        self.words.push(word);
        self.standing = Standing::of(&self.pinned, &self.words);
        let standing = &self.standing;
        self.words.retain(|word| match (standing.get(&word.signer), &word.said) {
            (Some(stand), Statement::Trust(key)) => stand.kept.includes(key),
            (Some(_), Statement::Revoke(_) | Statement::Stolen(..)) => true,
            // Of whom nobody knew before, somebody else may know: the owner takes keys away, and gives them back.
            (None, _) => !known(&before, &word.signer),
        });
    }

    /// Who of those that somebody vouched for signed `bytes`, and their text.
    fn signed<'a>(&self, part: &Part, bytes: &'a [u8], heading: &str) -> Result<(&PublicKey, &'a str), Refused> {
        let signed = Signed::open(part, bytes)?;
        let mut refused = self.unknown(part, signed.signer);
        for (key, _) in self.standing.called(signed.signer) {
            match signed.text(part, key.verifier(), heading) {
                Ok(text) => return Ok((key, text)),
                Err(forged) => refused = forged,
            }
        }
        Err(refused)
    }

    fn unknown(&self, part: &Part, signer: KeyId) -> Refused {
        Refused::UnknownKey { part: part.clone(), signer, trusted: self.keys().map(PublicKey::id).collect() }
    }
}

impl Word {
    /// The key that it speaks of.
    fn about(&self) -> KeyId {
        match &self.said {
            Statement::Revoke(id) | Statement::Stolen(id, _) => *id,
            Statement::Trust(key) => key.id(),
        }
    }

    /// Whether nothing is lost without the `other` one. A plain revocation stays beside one that keeps: programs that do
    /// not know that one obey it.
    fn implies(&self, other: &Self) -> bool {
        match (&self.said, &other.said) {
            (Statement::Stolen(id, kept), Statement::Stolen(other_id, others)) => {
                self.signer == other.signer && id == other_id && kept.is_subset(others)
            }
            _ => false,
        }
    }
}

fn revoked(part: &Part, signer: &PublicKey) -> Refused {
    Refused::RevokedKey { part: part.clone(), signer: signer.id() }
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
            (&new, &new, true),
            (&new, artist(), false),
        ] {
            let mut trust = pinned.clone();
            trust.learn(&says(artist(), &Statement::Trust(new.public()))).unwrap();
            let learned = trust.learn(&says(caller, &Statement::Revoke(called.public().id())));
            assert_eq!(learned.is_ok(), works);
            assert_eq!(trusts(&trust, called), !works);
            // Who took it in nowise can take back nothing, either.
            let learned = trust.learn(&says(&spare, &Statement::Revoke(new.public().id()))).unwrap();
            assert_eq!((learned, trusts(&trust, called)), (Learned::Noted(new.public().id()), !works));
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

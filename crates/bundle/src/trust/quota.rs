//! How much keys may say about others.
//!
//! Owns the quotas. A revocation is always taken in if it is of the key that says so, or of one that it spoke of before;
//! for all else each key has a quota of its own, so that a thief uses up that of the key that he stole, and no other.
//!
//! | says | limit |
//! |---|---|
//! | an owner's key calls back itself | none |
//! | a key calls back one that it spoke of | [`limits::REVISIONS`] that keep different ones; what keeps less than all before takes their place |
//! | a key speaks of another for the first time | [`limits::QUOTA`] for an owner's, [`limits::TAKEN_IN_QUOTA`] for another's, [`limits::SHARED_QUOTA`] for all others' together |
//! | anything but an owner's revocations | [`limits::SAID`] bytes of all that was said |
//!
//! Start at [`has_room`].

use std::collections::{BTreeMap, BTreeSet};

use super::{Statement, Word};
use crate::key::{KeyId, PublicKey};
use crate::limits;
use crate::refused::Refused;

/// Fine if beside `words`, all that was said so far, there is room for `word`.
///
/// # Errors
/// [`Refused::Quota`].
pub(super) fn has_room(pinned: &BTreeMap<KeyId, PublicKey>, words: &[Word], word: &Word) -> Result<(), Refused> {
    let (signer, about) = (word.signer.id(), word.about());
    let is_owners = |word: &Word| pinned.contains_key(&word.signer.id());
    let is_revocation = word.said.call().is_some();
    if is_owners(word) && is_revocation && signer == about {
        return Ok(());
    }
    let refused = |used, limit, things| Err(Refused::Quota { signer, used, limit, things });
    let own: Vec<&Word> = words.iter().filter(|there| there.signer == word.signer).collect();
    let is_spoken_of = signer == about || own.iter().any(|there| there.about() == about);
    if !is_revocation || !is_spoken_of {
        let (used, limit) = (others(&own), if is_owners(word) { limits::QUOTA } else { limits::TAKEN_IN_QUOTA });
        if used >= limit {
            return refused(used, limit, "other keys that it may speak of");
        }
        let all: Vec<&Word> = words.iter().filter(|word| !is_owners(word)).collect();
        let used = others(&all);
        if !is_owners(word) && used >= limits::SHARED_QUOTA {
            let things = "other keys that all keys together that were taken in may speak of";
            return refused(used, limits::SHARED_QUOTA, things);
        }
    }
    let is_revision =
        |there: &&&Word| there.about() == about && matches!(there.said, Statement::Stolen(..)) && !word.implies(there);
    let revisions = own.iter().filter(is_revision).count();
    if is_revocation && signer != about && revisions >= limits::REVISIONS {
        return refused(revisions, limits::REVISIONS, "revocations of one key that keep different ones");
    }
    let used: usize = words.iter().map(|word| word.text.len()).sum();
    if used + word.text.len() > limits::SAID && !(is_owners(word) && is_revocation) {
        return refused(used, limits::SAID, "bytes that all statements together may have");
    }
    Ok(())
}

/// Of how many other keys `words` speak.
fn others(words: &[&Word]) -> usize {
    let pair = |word: &Word| (word.signer.id(), word.about());
    let (calls, trusts): (Vec<&Word>, Vec<&Word>) = words.iter().partition(|word| word.said.call().is_some());
    let taken_in: BTreeSet<_> = trusts.iter().map(|word| pair(word)).collect();
    let called: BTreeSet<_> = calls.iter().map(|word| pair(word)).filter(|(signer, about)| signer != about).collect();
    trusts.len() + called.difference(&taken_in).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::secret::SecretKey;
    use crate::secret::tests::{artist, stranger};
    use crate::trust::{Learned, Lesson, Trust};

    fn say(trust: &mut Trust, key: &SecretKey, said: &Statement) -> Result<Learned, Refused> {
        trust.learn(&said.sign(key).unwrap())
    }

    fn quota(said: Result<Learned, Refused>) -> (KeyId, usize) {
        match said {
            Err(Refused::Quota { signer, limit, .. }) => (signer, limit),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_thief_uses_up_the_quota_of_the_key_that_he_stole_and_hides_no_revocation() {
        let (spare, thief) = (stranger(), stranger());
        let mut trust = Trust::of([artist().public(), spare.public()]);
        let flood: Vec<Vec<u8>> = std::iter::once(&thief)
            .map(|thief| Statement::Trust(thief.public()))
            .chain((0..200).map(|_| Statement::Trust(stranger().public())))
            .map(|said| said.sign(artist()).unwrap())
            .collect();
        let Lesson { news, refused } = trust.learn_all(&flood.concat());
        assert_eq!((news.len(), refused.len()), (limits::QUOTA, 201 - limits::QUOTA));
        let refusal = refused[0].to_string();
        let id = artist().public().id();
        assert_eq!(refusal, format!("key {id} has used up its quota: 64 of 64 other keys that it may speak of"));
        // The shared one, too.
        let thiefs: Vec<SecretKey> = (0..4).map(|_| stranger()).collect();
        let mut crowded = Trust::of([artist().public(), spare.public()]);
        for key in thiefs.iter().chain([&thief]) {
            say(&mut crowded, artist(), &Statement::Trust(key.public())).unwrap();
        }
        for key in &thiefs {
            for _ in 0..limits::TAKEN_IN_QUOTA {
                say(&mut crowded, key, &Statement::Trust(stranger().public())).unwrap();
            }
            let one_more = say(&mut crowded, key, &Statement::Trust(stranger().public()));
            assert_eq!(quota(one_more), (key.public().id(), limits::TAKEN_IN_QUOTA));
        }
        let one_more = say(&mut crowded, &thief, &Statement::Trust(stranger().public()));
        assert_eq!(quota(one_more), (thief.public().id(), limits::SHARED_QUOTA));

        for mut trust in [trust, crowded] {
            let (new, next) = (stranger(), stranger());
            say(&mut trust, &spare, &Statement::Trust(new.public())).unwrap();
            let call = Statement::Stolen(id, BTreeSet::new()).sign(artist()).unwrap();
            // Behind all that the thief says, in one file.
            trust.learn_all(&[flood.concat(), call].concat());
            let trusted: BTreeSet<KeyId> = trust.keys().map(PublicKey::id).collect();
            assert_eq!(trusted, [&spare, &new].map(|key| key.public().id()).into());
            assert!(trust.said().count() == 2, "what fell is forgotten");
            say(&mut trust, &new, &Statement::Trust(next.public())).unwrap();
        }
    }

    #[test]
    fn what_a_key_spoke_of_it_calls_back_whatever_its_quota_and_by_fewer_to_keep_again() {
        let mut trust = Trust::of([artist().public()]);
        let keys: Vec<PublicKey> = (0..limits::QUOTA).map(|_| stranger().public()).collect();
        for key in &keys {
            say(&mut trust, artist(), &Statement::Trust(key.clone())).unwrap();
        }
        let unheard = say(&mut trust, artist(), &Statement::Revoke(stranger().public().id()));
        assert_eq!(quota(unheard), (artist().public().id(), limits::QUOTA));
        let stolen =
            |kept: &[usize]| Statement::Stolen(keys[0].id(), kept.iter().map(|at| keys[*at].clone()).collect());
        for (kept, said) in [(&[1, 2, 3][..], true), (&[1, 2, 4], true), (&[1, 5], false), (&[1], true), (&[], true)] {
            assert_eq!(say(&mut trust, artist(), &stolen(kept)).is_ok(), said, "{kept:?}");
            assert!(trust.keys().all(|key| *key != keys[0]));
        }
        assert_eq!(say(&mut trust, artist(), &stolen(&[6])).unwrap(), Learned::Nothing);
        assert_eq!(trust.keys().count(), limits::QUOTA, "the artist and all but the first");
    }

    #[test]
    fn owners_call_back_when_all_that_was_said_has_no_room_any_more() {
        let spare = stranger();
        let mut trust = Trust::of([artist().public(), spare.public()]);
        let all: Vec<SecretKey> = (0..limits::QUOTA).map(|_| stranger()).collect();
        for key in &all {
            say(&mut trust, artist(), &Statement::Trust(key.public())).unwrap();
        }
        // Keys that call back themselves over and over, each time keeping others.
        let kept: Vec<PublicKey> = (0..=limits::KEPT).map(|_| stranger().public()).collect();
        let mut full = None;
        'full: for key in &all {
            for out in &kept {
                let kept = kept.iter().filter(|key| *key != out).cloned().collect();
                full = say(&mut trust, key, &Statement::Stolen(key.public().id(), kept)).err();
                if full.is_some() {
                    break 'full;
                }
            }
        }
        assert!(matches!(full, Some(Refused::Quota { limit: limits::SAID, .. })), "{full:?}");
        let mut more = (0..4).map(|_| say(&mut trust, &spare, &Statement::Trust(stranger().public())));
        assert_eq!(quota(more.find(Result::is_err).unwrap()), (spare.public().id(), limits::SAID));
        // Of a key that was taken in, and of themselves, and nobody else does.
        let stolen = Statement::Stolen(all[0].public().id(), kept[1..].iter().cloned().collect());
        assert_eq!(quota(say(&mut trust, &all[1], &stolen)), (all[1].public().id(), limits::SAID));
        say(&mut trust, artist(), &stolen).unwrap();
        say(&mut trust, artist(), &Statement::Stolen(artist().public().id(), BTreeSet::new())).unwrap();
        assert!(trust.said().count() < 5, "what fell is forgotten");
        say(&mut trust, &spare, &Statement::Trust(stranger().public())).unwrap();
    }
}

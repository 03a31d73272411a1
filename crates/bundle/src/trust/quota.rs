//! Quotas on statements.
//!
//! Owns the quotas. A revocation of the signer itself, or of a key that it named before, is always accepted; all other
//! statements count against the signer's own quota, so that a thief uses up only that of the stolen key.
//!
//! | statement | limit |
//! |---|---|
//! | an owner's key revokes itself | none |
//! | a key revokes one that it named before | [`limits::REVISIONS`] with different keys to keep; one that keeps fewer than all before replaces them |
//! | a key names another for the first time | [`limits::QUOTA`] for an owner's, [`limits::ADDED_QUOTA`] for another's, [`limits::SHARED_QUOTA`] for all others' together |
//! | anything but an owner's revocations | [`limits::LEARNED_STATEMENTS`] bytes of all statements |
//!
//! Start at [`has_room`].

use std::collections::{BTreeMap, BTreeSet};

use super::{SignedStatement, Statement};
use crate::key::{KeyId, PublicKey};
use crate::limits;
use crate::refusal::Refusal;

/// Checks that the quotas allow `word` in addition to `words`.
/// Errors: [`Refusal::Quota`].
pub(super) fn has_room(
    pinned: &BTreeMap<KeyId, PublicKey>,
    words: &[SignedStatement],
    word: &SignedStatement,
) -> Result<(), Refusal> {
    let (signer, subject) = (word.signer.id(), word.subject());
    let is_owners = |word: &SignedStatement| pinned.contains_key(&word.signer.id());
    let is_revocation = word.said.as_revocation().is_some();
    if is_owners(word) && is_revocation && signer == subject {
        return Ok(());
    }
    let refused = |used, limit, things| Err(Refusal::Quota { signer, used, limit, things });
    let own: Vec<_> = words.iter().filter(|there| there.signer == word.signer).collect();
    let is_named = signer == subject || own.iter().any(|there| there.subject() == subject);
    if !is_revocation || !is_named {
        let (used, limit) = (others(&own), if is_owners(word) { limits::QUOTA } else { limits::ADDED_QUOTA });
        if used >= limit {
            return refused(used, limit, "other keys that its statements may name");
        }
        let all: Vec<_> = words.iter().filter(|word| !is_owners(word)).collect();
        let used = others(&all);
        if !is_owners(word) && used >= limits::SHARED_QUOTA {
            let things = "other keys that statements of all added keys together may name";
            return refused(used, limits::SHARED_QUOTA, things);
        }
    }
    let is_revision = |there: &&&SignedStatement| {
        there.subject() == subject && matches!(there.said, Statement::Stolen(..)) && !word.implies(there)
    };
    let revisions = own.iter().filter(is_revision).count();
    if is_revocation && signer != subject && revisions >= limits::REVISIONS {
        return refused(revisions, limits::REVISIONS, "revocations of one key with different keys to keep");
    }
    let used: usize = words.iter().map(|word| word.text.len()).sum();
    if used + word.text.len() > limits::LEARNED_STATEMENTS && !(is_owners(word) && is_revocation) {
        return refused(used, limits::LEARNED_STATEMENTS, "bytes of all statements together");
    }
    Ok(())
}

/// The number of other keys that `words` name.
fn others(words: &[&SignedStatement]) -> usize {
    let pair = |word: &SignedStatement| (word.signer.id(), word.subject());
    let (revocations, trusts): (Vec<&SignedStatement>, Vec<&SignedStatement>) =
        words.iter().partition(|word| word.said.as_revocation().is_some());
    let taken_in: BTreeSet<_> = trusts.iter().map(|word| pair(word)).collect();
    let called: BTreeSet<_> =
        revocations.iter().map(|word| pair(word)).filter(|(signer, subject)| signer != subject).collect();
    trusts.len() + called.difference(&taken_in).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::secret::SecretKey;
    use crate::secret::tests::{artist, stranger};
    use crate::trust::{Trust, TrustChange, TrustUpdate};

    fn say(trust: &mut Trust, key: &SecretKey, said: &Statement) -> Result<TrustChange, Refusal> {
        trust.learn(&said.sign(key).unwrap())
    }

    fn quota(said: Result<TrustChange, Refusal>) -> (KeyId, usize) {
        match said {
            Err(Refusal::Quota { signer, limit, .. }) => (signer, limit),
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
        let TrustUpdate { news, refused } = trust.learn_all(&flood.concat());
        assert_eq!((news.len(), refused.len()), (limits::QUOTA, 201 - limits::QUOTA));
        let refusal = refused[0].to_string();
        let id = artist().public().id();
        assert_eq!(
            refusal,
            format!("key {id} has used up its quota: 64 of 64 other keys that its statements may name")
        );
        // The shared one, too.
        let thiefs: Vec<SecretKey> = (0..4).map(|_| stranger()).collect();
        let mut crowded = Trust::of([artist().public(), spare.public()]);
        for key in thiefs.iter().chain([&thief]) {
            say(&mut crowded, artist(), &Statement::Trust(key.public())).unwrap();
        }
        for key in &thiefs {
            for _ in 0..limits::ADDED_QUOTA {
                say(&mut crowded, key, &Statement::Trust(stranger().public())).unwrap();
            }
            let one_more = say(&mut crowded, key, &Statement::Trust(stranger().public()));
            assert_eq!(quota(one_more), (key.public().id(), limits::ADDED_QUOTA));
        }
        let one_more = say(&mut crowded, &thief, &Statement::Trust(stranger().public()));
        assert_eq!(quota(one_more), (thief.public().id(), limits::SHARED_QUOTA));

        for mut trust in [trust, crowded] {
            let (new, next) = (stranger(), stranger());
            say(&mut trust, &spare, &Statement::Trust(new.public())).unwrap();
            let revocation = Statement::Stolen(id, BTreeSet::new()).sign(artist()).unwrap();
            // After all statements of the thief, in one file.
            trust.learn_all(&[flood.concat(), revocation].concat());
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
        assert_eq!(say(&mut trust, artist(), &stolen(&[6])).unwrap(), TrustChange::Nothing);
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
        // Keys that revoke themselves repeatedly, keeping other keys each time.
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
        assert!(matches!(full, Some(Refusal::Quota { limit: limits::LEARNED_STATEMENTS, .. })), "{full:?}");
        let mut more = (0..4).map(|_| say(&mut trust, &spare, &Statement::Trust(stranger().public())));
        assert_eq!(quota(more.find(Result::is_err).unwrap()), (spare.public().id(), limits::LEARNED_STATEMENTS));
        // The owners' keys may still revoke an added key, and themselves; others may not.
        let stolen = Statement::Stolen(all[0].public().id(), kept[1..].iter().cloned().collect());
        assert_eq!(quota(say(&mut trust, &all[1], &stolen)), (all[1].public().id(), limits::LEARNED_STATEMENTS));
        say(&mut trust, artist(), &stolen).unwrap();
        say(&mut trust, artist(), &Statement::Stolen(artist().public().id(), BTreeSet::new())).unwrap();
        assert!(trust.said().count() < 5, "what fell is forgotten");
        say(&mut trust, &spare, &Statement::Trust(stranger().public())).unwrap();
    }
}

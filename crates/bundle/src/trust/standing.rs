//! The status of keys by all statements.
//!
//! A pure function of the statements, independent of their order. The known keys are the smallest set with the owner's
//! keys and, for each key in the set, the keys that it added and has not revoked.
//!
//! - A key that revoked itself is not trusted, even if other keys added it.
//! - A revocation of another key withdraws only the signer's own statement: a key stays trusted as long as another
//!   key's statement for it counts. So a thief who adds one of our keys cannot revoke it.
//! - Keys added by a revoked key stay, unless a revocation names those to keep. Several such revocations of the same
//!   key, by the same signer or by that key itself, keep what all of them name.
//! - A key without a valid statement for it is unknown, and so are the keys that only it added.
//!
//! Start at [`KeyStatuses::of`].

use std::collections::{BTreeMap, BTreeSet};

use super::SignedStatement;
use super::statement::Statement;
use crate::key::{KeyId, PublicKey};

/// The keys added by a key that its statements still count for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum KeptKeys {
    All,
    Only(BTreeSet<PublicKey>),
}

/// The status of one key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct KeyStatus {
    /// Else it was called back.
    pub(super) is_trusted: bool,
    /// Which of the keys that it added still count.
    pub(super) kept: KeptKeys,
}

/// The status of all known keys, revoked ones included.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct KeyStatuses(BTreeMap<PublicKey, KeyStatus>);

impl KeptKeys {
    pub(super) fn includes(&self, key: &PublicKey) -> bool {
        match self {
            Self::All => true,
            Self::Only(keys) => keys.contains(key),
        }
    }

    /// The keys in both.
    pub(super) fn and(&self, other: &Self) -> Self {
        match (self, other) {
            (Self::All, kept) | (kept, Self::All) => kept.clone(),
            (Self::Only(one), Self::Only(two)) => Self::Only(one & two),
        }
    }

    /// The keys in either.
    fn or(&self, other: &Self) -> Self {
        match (self, other) {
            (Self::All, _) | (_, Self::All) => Self::All,
            (Self::Only(one), Self::Only(two)) => Self::Only(one | two),
        }
    }
}

impl KeyStatuses {
    /// The status of keys with the owner's keys `pinned` and the statements `words`.
    pub(super) fn of(pinned: &BTreeMap<KeyId, PublicKey>, words: &[SignedStatement]) -> Self {
        let everything = || KeyStatus { is_trusted: true, kept: KeptKeys::All };
        let mut keys: BTreeMap<PublicKey, KeyStatus> = pinned.values().map(|key| (key.clone(), everything())).collect();
        let revocations = revocations(words);
        let kept_by = |signer, id: KeyId| revocations.get(&(signer, id));
        let mut is_settled = false;
        while !is_settled {
            is_settled = true;
            for SignedStatement { signer, said, .. } in words {
                let Statement::Trust(key) = said else { continue };
                let stands = keys.get(signer).is_some_and(|stand| stand.kept.includes(key))
                    && kept_by(signer, signer.id()).is_none_or(|kept| kept.includes(key));
                if !stands || signer == key || pinned.contains_key(&key.id()) {
                    continue;
                }
                let taken = match kept_by(signer, key.id()) {
                    None => everything(),
                    Some(kept) => KeyStatus { is_trusted: false, kept: kept.clone() },
                };
                let joined = match keys.get(key) {
                    None => taken,
                    Some(stand) => {
                        KeyStatus { is_trusted: stand.is_trusted || taken.is_trusted, kept: stand.kept.or(&taken.kept) }
                    }
                };
                is_settled &= keys.insert(key.clone(), joined.clone()).is_some_and(|before| before == joined);
            }
        }
        for (key, stand) in &mut keys {
            if let Some(kept) = kept_by(key, key.id()) {
                *stand = KeyStatus { is_trusted: false, kept: stand.kept.and(kept) };
            }
        }
        Self(keys)
    }

    /// The status of this key; `None` if it is unknown.
    pub(super) fn get(&self, key: &PublicKey) -> Option<&KeyStatus> {
        self.0.get(key)
    }

    /// Every key with this id, and its status.
    pub(super) fn with_id(&self, id: KeyId) -> impl Iterator<Item = (&PublicKey, &KeyStatus)> {
        self.0.iter().filter(move |(key, _)| key.id() == id)
    }

    /// Every key, and its status.
    pub(super) fn all(&self) -> impl Iterator<Item = (&PublicKey, &KeyStatus)> {
        self.0.iter()
    }
}

/// The keys that revocations keep, by signer and revoked key.
fn revocations(words: &[SignedStatement]) -> BTreeMap<(&PublicKey, KeyId), KeptKeys> {
    let mut revocations: BTreeMap<(&PublicKey, KeyId), KeptKeys> = BTreeMap::new();
    for word in words {
        let Some((id, kept)) = word.said.as_revocation() else { continue };
        let there = revocations.entry((&word.signer, id)).or_insert(KeptKeys::All);
        *there = there.and(&kept);
    }
    revocations
}

impl Statement {
    /// The key that it revokes, and which of the keys added by that one are kept.
    pub(super) fn as_revocation(&self) -> Option<(KeyId, KeptKeys)> {
        match self {
            Self::Revoke(id) => Some((*id, KeptKeys::All)),
            Self::Stolen(id, kept) => Some((*id, KeptKeys::Only(kept.clone()))),
            Self::Trust(_) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::refusal::{Part, Refusal};
    use crate::secret::SecretKey;
    use crate::secret::tests::{artist, stranger};
    use crate::trust::{Trust, TrustChange};
    use ct_codecs::{Base64, Decoder, Encoder};
    use proptest::prelude::*;
    use std::sync::OnceLock;

    fn signs(trust: &Trust, key: &SecretKey) -> Result<(), Refusal> {
        let signed = key.sign("a test", "dreams test 1\n").unwrap();
        trust.verify(&Part::Seal, &signed, "dreams test 1").map(drop)
    }

    fn takes_in(key: &SecretKey, other: &SecretKey) -> Vec<u8> {
        Statement::Trust(other.public()).sign(key).unwrap()
    }

    fn revocations(key: &SecretKey, other: &SecretKey, kept: &[&SecretKey]) -> Vec<u8> {
        let kept = kept.iter().map(|key| key.public()).collect();
        Statement::Stolen(other.public().id(), kept).sign(key).unwrap()
    }

    #[test]
    fn what_a_stolen_key_took_in_falls_with_it_but_for_what_is_kept() {
        let (spare, ours, thief, accomplice) = (stranger(), stranger(), stranger(), stranger());
        let mut trust = Trust::of([artist().public(), spare.public()]);
        let thefts = [takes_in(artist(), &ours), takes_in(artist(), &thief), takes_in(&thief, &accomplice)].concat();
        trust.learn_all(&thefts);
        assert!(signs(&trust, &thief).is_ok() && signs(&trust, &accomplice).is_ok());
        let news = trust.learn_all(&revocations(artist(), artist(), &[&ours])).news;
        let fallen = [&thief, &accomplice].map(|key| TrustChange::Fallen(key.public().id()));
        assert!(
            news.contains(&TrustChange::Revoked(artist().public().id())) && fallen.iter().all(|id| news.contains(id))
        );
        assert!(signs(&trust, &spare).is_ok() && signs(&trust, &ours).is_ok());
        assert!(matches!(signs(&trust, artist()), Err(Refusal::RevokedKey { .. })));
        for key in [&thief, &accomplice] {
            assert!(matches!(signs(&trust, key), Err(Refusal::UnknownKey { .. })));
            let said = trust.learn(&takes_in(key, &stranger()));
            assert!(matches!(said, Err(Refusal::UnknownKey { .. })), "what has fallen says nothing: {said:?}");
        }
        trust.learn_all(&thefts);
        assert!(signs(&trust, &thief).is_err(), "nor does it come again");
    }

    #[test]
    fn of_several_revocations_by_one_key_only_what_all_keep_stays_in_whatever_order() {
        let (spare, ours, both, thief) = (stranger(), stranger(), stranger(), stranger());
        let taken: Vec<u8> = [&ours, &both, &thief].iter().flat_map(|key| takes_in(artist(), key)).collect();
        let his = revocations(artist(), artist(), &[&thief, &both]);
        let mine = revocations(artist(), artist(), &[&ours, &both]);
        for (one, two) in [(&his, &mine), (&mine, &his)] {
            let mut trust = Trust::of([artist().public(), spare.public()]);
            for file in [&taken, one, two] {
                trust.learn_all(file);
            }
            assert!(signs(&trust, &both).is_ok() && signs(&trust, &ours).is_err() && signs(&trust, &thief).is_err());
            trust.learn(&takes_in(&spare, &ours)).unwrap();
            assert!(signs(&trust, &ours).is_ok(), "the spare one takes in again what the thief called back");
        }
    }

    #[test]
    fn a_thief_cannot_call_back_a_key_of_ours_by_taking_it_in() {
        let (spare, new) = (stranger(), stranger());
        let words = [
            takes_in(artist(), &new),
            revocations(artist(), &new, &[]),
            Statement::Revoke(new.public().id()).sign(artist()).unwrap(),
            takes_in(&spare, &new),
        ];
        let mut trust = Trust::of([artist().public(), spare.public()]);
        for word in &words {
            trust.learn(word).unwrap();
        }
        assert!(signs(&trust, &new).is_ok());
        assert!(matches!(trust.learn(&revocations(&spare, artist(), &[])), Err(Refusal::UnknownKey { .. })));
        trust.learn(&revocations(&new, &new, &[])).unwrap();
        assert!(matches!(signs(&trust, &new), Err(Refusal::RevokedKey { .. })), "but it can call back itself");
    }

    #[test]
    fn a_key_of_the_same_id_is_another_key() {
        let (spare, new, thief) = (stranger(), stranger(), stranger());
        let mut twin = Base64::decode_to_vec(thief.public().line(), None).unwrap();
        twin[2..10].copy_from_slice(&Base64::decode_to_vec(new.public().line(), None).unwrap()[2..10]);
        let twin = PublicKey::parse(&Base64::encode_to_string(&twin).unwrap()).unwrap();
        assert_eq!(twin.id(), new.public().id());
        let mut trust = Trust::of([artist().public(), spare.public()]);
        trust.learn(&Statement::Trust(twin.clone()).sign(artist()).unwrap()).unwrap();
        assert!(matches!(signs(&trust, &new), Err(Refusal::Forged { .. })));
        trust.learn(&takes_in(&spare, &new)).unwrap();
        assert!(signs(&trust, &new).is_ok(), "it does not keep out the one whose id it bears");
        trust.learn(&revocations(artist(), artist(), &[&new])).unwrap();
        assert!(signs(&trust, &new).is_ok() && trust.keys().all(|key| *key != twin), "nor is it kept in its place");
    }

    #[test]
    fn a_revocation_counts_for_a_key_that_was_not_heard_of_yet() {
        let new = stranger();
        let mut trust = Trust::of([artist().public()]);
        let called = trust.learn(&revocations(artist(), &new, &[])).unwrap();
        assert_eq!(called, TrustChange::Noted(new.public().id()));
        trust.learn(&takes_in(artist(), &new)).unwrap();
        assert!(signs(&trust, &new).is_err());
    }

    fn keys() -> &'static [SecretKey; 5] {
        static KEYS: OnceLock<[SecretKey; 5]> = OnceLock::new();
        KEYS.get_or_init(|| std::array::from_fn(|_| stranger()))
    }

    /// A statement of one key about another: to trust it, or that it was stolen, and which keys to keep.
    fn word() -> impl Strategy<Value = Vec<u8>> {
        (0usize..5, 0usize..5, proptest::option::weighted(0.4, 0u8..32)).prop_map(|(signer, subject, stolen)| {
            let (signer, subject) = (&keys()[signer], &keys()[subject]);
            match stolen {
                None => takes_in(signer, subject),
                Some(kept) => {
                    let kept = keys().iter().enumerate().filter(|(at, _)| kept & (1 << at) != 0);
                    revocations(signer, subject, &kept.map(|(_, key)| key).collect::<Vec<_>>())
                }
            }
        })
    }

    fn standing(words: &[Vec<u8>]) -> (BTreeSet<KeyId>, BTreeSet<KeyId>) {
        let mut trust = Trust::of(keys()[..2].iter().map(SecretKey::public));
        trust.learn_all(&words.concat());
        let mut again = Trust::of(keys()[..2].iter().map(SecretKey::public));
        again.relearn(trust.said().collect::<String>().as_bytes());
        let ids = |trust: &Trust| trust.keys().map(PublicKey::id).collect();
        assert_eq!(ids(&trust), ids(&again), "what is remembered says the same");
        (ids(&trust), trust.revoked().collect())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]

        #[test]
        fn keys_stand_the_same_in_whatever_order_was_spoken(
            (words, shuffled) in proptest::collection::vec(word(), 0..14)
                .prop_flat_map(|words| (Just(words.clone()), Just(words).prop_shuffle())),
        ) {
            prop_assert_eq!(standing(&words), standing(&shuffled));
        }
    }
}

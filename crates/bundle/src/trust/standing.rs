//! How keys stand, by all that was said.
//!
//! Owns the answer, as a pure function of what was said: in which order it was learned makes no difference. It is the
//! least set of keys that holds the owner's and, of each key that it holds, what that one took in and still vouches for.
//!
//! - A key that called back itself is not trusted, whoever else took it in.
//! - A key that calls back another takes back its own word for it, and no one else's: a key stays trusted as long as one
//!   word for it stands. So a thief who takes in a key of ours cannot call it back thereby.
//! - What a called-back key took in stays, unless a revocation says what is to stay. Several that say so about the same
//!   key, by the same one or by that key itself, leave what all of them name.
//! - What nobody vouches for any more has fallen: it is unknown, and so is what only it took in.
//!
//! Start at [`Standing::of`].

use std::collections::{BTreeMap, BTreeSet};

use super::Word;
use super::statement::Statement;
use crate::key::{KeyId, PublicKey};

/// Which of the keys that a key took in its word still counts for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Kept {
    All,
    Only(BTreeSet<PublicKey>),
}

/// How one key stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Stand {
    /// Else it was called back.
    pub(super) is_trusted: bool,
    /// Which of the keys that it took in it still vouches for.
    pub(super) kept: Kept,
}

/// How every key stands that somebody vouches for, or vouched for until it was called back.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Standing(BTreeMap<PublicKey, Stand>);

impl Kept {
    pub(super) fn includes(&self, key: &PublicKey) -> bool {
        match self {
            Self::All => true,
            Self::Only(keys) => keys.contains(key),
        }
    }

    /// What both keep.
    pub(super) fn and(&self, other: &Self) -> Self {
        match (self, other) {
            (Self::All, kept) | (kept, Self::All) => kept.clone(),
            (Self::Only(one), Self::Only(two)) => Self::Only(one & two),
        }
    }

    /// What either keeps.
    fn or(&self, other: &Self) -> Self {
        match (self, other) {
            (Self::All, _) | (_, Self::All) => Self::All,
            (Self::Only(one), Self::Only(two)) => Self::Only(one | two),
        }
    }
}

impl Standing {
    /// How keys stand when `pinned` are the owner's, and `words` is all that was said.
    pub(super) fn of(pinned: &BTreeMap<KeyId, PublicKey>, words: &[Word]) -> Self {
        let everything = || Stand { is_trusted: true, kept: Kept::All };
        let mut keys: BTreeMap<PublicKey, Stand> = pinned.values().map(|key| (key.clone(), everything())).collect();
        let calls = calls(words);
        let call = |signer, id: KeyId| calls.get(&(signer, id));
        let mut is_settled = false;
        while !is_settled {
            is_settled = true;
            for Word { signer, said, .. } in words {
                let Statement::Trust(key) = said else { continue };
                let stands = keys.get(signer).is_some_and(|stand| stand.kept.includes(key))
                    && call(signer, signer.id()).is_none_or(|kept| kept.includes(key));
                if !stands || signer == key || pinned.contains_key(&key.id()) {
                    continue;
                }
                let taken = match call(signer, key.id()) {
                    None => everything(),
                    Some(kept) => Stand { is_trusted: false, kept: kept.clone() },
                };
                let joined = match keys.get(key) {
                    None => taken,
                    Some(stand) => {
                        Stand { is_trusted: stand.is_trusted || taken.is_trusted, kept: stand.kept.or(&taken.kept) }
                    }
                };
                is_settled &= keys.insert(key.clone(), joined.clone()).is_some_and(|before| before == joined);
            }
        }
        for (key, stand) in &mut keys {
            if let Some(kept) = call(key, key.id()) {
                *stand = Stand { is_trusted: false, kept: stand.kept.and(kept) };
            }
        }
        Self(keys)
    }

    /// How this key stands; `None` if nobody ever vouched for it, or nobody does any more.
    pub(super) fn get(&self, key: &PublicKey) -> Option<&Stand> {
        self.0.get(key)
    }

    /// Every key of this id, and how it stands.
    pub(super) fn called(&self, id: KeyId) -> impl Iterator<Item = (&PublicKey, &Stand)> {
        self.0.iter().filter(move |(key, _)| key.id() == id)
    }

    /// Every key, and how it stands.
    pub(super) fn all(&self) -> impl Iterator<Item = (&PublicKey, &Stand)> {
        self.0.iter()
    }
}

/// What stays of whatever each key took in that was called back, by who said so.
fn calls(words: &[Word]) -> BTreeMap<(&PublicKey, KeyId), Kept> {
    let mut calls: BTreeMap<(&PublicKey, KeyId), Kept> = BTreeMap::new();
    for word in words {
        let Some((id, kept)) = word.said.call() else { continue };
        let there = calls.entry((&word.signer, id)).or_insert(Kept::All);
        *there = there.and(&kept);
    }
    calls
}

impl Statement {
    /// The key that it calls back, and what stays of what that one took in.
    pub(super) fn call(&self) -> Option<(KeyId, Kept)> {
        match self {
            Self::Revoke(id) => Some((*id, Kept::All)),
            Self::Stolen(id, kept) => Some((*id, Kept::Only(kept.clone()))),
            Self::Trust(_) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::refused::{Part, Refused};
    use crate::secret::SecretKey;
    use crate::secret::tests::{artist, stranger};
    use crate::trust::{Learned, Trust};
    use ct_codecs::{Base64, Decoder, Encoder};
    use proptest::prelude::*;
    use std::sync::OnceLock;

    fn signs(trust: &Trust, key: &SecretKey) -> Result<(), Refused> {
        let signed = key.sign("a test", "dreams test 1\n").unwrap();
        trust.verify(&Part::Seal, &signed, "dreams test 1").map(drop)
    }

    fn takes_in(key: &SecretKey, other: &SecretKey) -> Vec<u8> {
        Statement::Trust(other.public()).sign(key).unwrap()
    }

    fn calls(key: &SecretKey, other: &SecretKey, kept: &[&SecretKey]) -> Vec<u8> {
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
        let news = trust.learn_all(&calls(artist(), artist(), &[&ours])).news;
        let fallen = [&thief, &accomplice].map(|key| Learned::Fallen(key.public().id()));
        assert!(news.contains(&Learned::Revoked(artist().public().id())) && fallen.iter().all(|id| news.contains(id)));
        assert!(signs(&trust, &spare).is_ok() && signs(&trust, &ours).is_ok());
        assert!(matches!(signs(&trust, artist()), Err(Refused::RevokedKey { .. })));
        for key in [&thief, &accomplice] {
            assert!(matches!(signs(&trust, key), Err(Refused::UnknownKey { .. })));
            let said = trust.learn(&takes_in(key, &stranger()));
            assert!(matches!(said, Err(Refused::UnknownKey { .. })), "what has fallen says nothing: {said:?}");
        }
        trust.learn_all(&thefts);
        assert!(signs(&trust, &thief).is_err(), "nor does it come again");
    }

    #[test]
    fn of_several_revocations_by_one_key_only_what_all_keep_stays_in_whatever_order() {
        let (spare, ours, both, thief) = (stranger(), stranger(), stranger(), stranger());
        let taken: Vec<u8> = [&ours, &both, &thief].iter().flat_map(|key| takes_in(artist(), key)).collect();
        let his = calls(artist(), artist(), &[&thief, &both]);
        let mine = calls(artist(), artist(), &[&ours, &both]);
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
            calls(artist(), &new, &[]),
            Statement::Revoke(new.public().id()).sign(artist()).unwrap(),
            takes_in(&spare, &new),
        ];
        let mut trust = Trust::of([artist().public(), spare.public()]);
        for word in &words {
            trust.learn(word).unwrap();
        }
        assert!(signs(&trust, &new).is_ok());
        assert!(matches!(trust.learn(&calls(&spare, artist(), &[])), Err(Refused::UnknownKey { .. })));
        trust.learn(&calls(&new, &new, &[])).unwrap();
        assert!(matches!(signs(&trust, &new), Err(Refused::RevokedKey { .. })), "but it can call back itself");
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
        assert!(matches!(signs(&trust, &new), Err(Refused::Forged { .. })));
        trust.learn(&takes_in(&spare, &new)).unwrap();
        assert!(signs(&trust, &new).is_ok(), "it does not keep out the one whose id it bears");
        trust.learn(&calls(artist(), artist(), &[&new])).unwrap();
        assert!(signs(&trust, &new).is_ok() && trust.keys().all(|key| *key != twin), "nor is it kept in its place");
    }

    #[test]
    fn a_revocation_counts_for_a_key_that_was_not_heard_of_yet() {
        let new = stranger();
        let mut trust = Trust::of([artist().public()]);
        let called = trust.learn(&calls(artist(), &new, &[])).unwrap();
        assert_eq!(called, Learned::Noted(new.public().id()));
        trust.learn(&takes_in(artist(), &new)).unwrap();
        assert!(signs(&trust, &new).is_err());
    }

    fn keys() -> &'static [SecretKey; 5] {
        static KEYS: OnceLock<[SecretKey; 5]> = OnceLock::new();
        KEYS.get_or_init(|| std::array::from_fn(|_| stranger()))
    }

    /// What one of the keys says of another: that it is to be trusted, or that it was stolen, and which are to stay.
    fn word() -> impl Strategy<Value = Vec<u8>> {
        (0usize..5, 0usize..5, proptest::option::weighted(0.4, 0u8..32)).prop_map(|(signer, about, stolen)| {
            let (signer, about) = (&keys()[signer], &keys()[about]);
            match stolen {
                None => takes_in(signer, about),
                Some(kept) => {
                    let kept = keys().iter().enumerate().filter(|(at, _)| kept & (1 << at) != 0);
                    calls(signer, about, &kept.map(|(_, key)| key).collect::<Vec<_>>())
                }
            }
        })
    }

    fn standing(words: &[Vec<u8>]) -> (BTreeSet<KeyId>, BTreeSet<KeyId>) {
        let mut trust = Trust::of(keys()[..2].iter().map(SecretKey::public));
        trust.learn_all(&words.concat());
        let mut again = Trust::of(keys()[..2].iter().map(SecretKey::public));
        again.recall(trust.said().collect::<String>().as_bytes());
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

//! What a unit knows of its flocks: which one plays, which one is on trial, which sequences it has seen.
//!
//! Owns every decision about generations, as pure functions of the state; whoever calls them writes the state down and
//! makes the disk follow. The *floor* of a key is the highest sequence that has won its trial: nothing of that key that
//! is not higher is let in again, but for the number of the floor itself once the disk has lost what it was: a unit
//! takes back the flock that it had. A lost trial raises no floor, so that the artist may send the same number again,
//! mended.
//!
//! A unit may fall back to an older program at any time: fields are only ever added, and what a program does not know it
//! keeps and writes down again as it found it.
//!
//! | state | event | becomes |
//! |---|---|---|
//! | good `g` | installed `t` | good `g`, trial `t`; what was before `g` goes |
//! | good `g`, trial `t` | installed `u` | good `g`, trial `u`; `t` goes, unjudged |
//! | good `g`, trial `t` | shown, for the [`JOINS`]th time | won |
//! | good `g`, trial `t` | started, for more than the [`STARTS`]th time in vain | lost |
//! | good `g`, trial `t` | won | good `t`, before `g`; the floor of its key rises |
//! | good `g`, trial `t` | lost | good `g`; `t` is marked bad and goes |
//! | trial `t` | lost | nothing: the player falls back to its own |
//!
//! Start at [`State::admit`].

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::key::KeyId;
use crate::names::{ObjectId, Sequence, UnitId};
use crate::refused::Refused;
use crate::seal::Seal;

/// How often a trial may be begun in vain: a unit that died of a flock so often will not live with it.
pub const STARTS: u32 = 3;
/// The joins on the glass that win a trial, over however many starts.
pub const JOINS: u32 = 20;
/// How many bad bundles are remembered.
const BAD: usize = 64;

/// What a newer program has written, by its name.
pub type Unknown = BTreeMap<String, Value>;

/// One installed flock.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Generation {
    /// Counts the installations of this unit; names its folder.
    pub number: u64,
    /// What the artist calls the flock.
    pub flock: String,
    /// Who signed it.
    pub signer: KeyId,
    /// Its number among the bundles of that key.
    pub sequence: Sequence,
    /// The digest of its seal.
    pub seal: ObjectId,
    /// What a newer program knows of it.
    #[serde(flatten)]
    pub unknown: Unknown,
}

/// A generation that has to prove itself.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Trial {
    /// Which.
    pub generation: Generation,
    /// How often the unit has begun to play it since it last got as far as a join.
    pub starts: u32,
    /// The joins of it that were on the glass. A program that does not know them reads a trial without any.
    #[serde(default, skip_serializing_if = "is_none")]
    pub joins: u32,
    /// What a newer program knows of it.
    #[serde(flatten)]
    pub unknown: Unknown,
}

/// What a unit knows of its flocks.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct State {
    /// The highest sequence of each key that has won a trial here.
    pub floors: BTreeMap<KeyId, Sequence>,
    /// The last generation that has won its trial.
    pub good: Option<Generation>,
    /// The one that played before it, kept as a reserve.
    pub before: Option<Generation>,
    /// The one on trial; it plays.
    pub trial: Option<Trial>,
    /// The digests of seals that have lost a trial, oldest first.
    pub bad: Vec<ObjectId>,
    /// What keys said about keys, in the order in which it was learned.
    pub statements: Vec<String>,
    /// The number of the newest generation there ever was.
    pub newest: u64,
    /// What a newer program knows.
    #[serde(flatten)]
    pub unknown: Unknown,
}

/// What the owner allows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Consent {
    /// Newer bundles only.
    Newer,
    /// This bundle, older or marked bad as it may be. To be given on the unit itself, by its owner.
    Any,
}

/// What becomes of a bundle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Admission {
    /// It is kept for when the one on trial is lost. What the store lacks of it may be fetched.
    Kept,
    /// It is to be installed.
    New,
    /// It is on trial already.
    OnTrial,
    /// It plays already.
    Plays,
}

/// How a trial stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It was begun too often and is lost.
    Lost,
    /// It goes on.
    Open,
    /// It was shown often enough and is won.
    Won,
}

impl State {
    /// The generation that plays: the one on trial, else the good one.
    pub fn playing(&self) -> Option<&Generation> {
        self.trial.as_ref().map(|trial| &trial.generation).or(self.good.as_ref())
    }

    /// The generations whose files must stay.
    pub fn kept(&self) -> impl Iterator<Item = &Generation> {
        let trial = self.trial.as_ref().map(|trial| &trial.generation);
        trial.into_iter().chain(&self.good).chain(&self.before)
    }

    /// Whether the bundle behind `seal` may be installed on `unit`.
    ///
    /// # Errors
    /// [`Refused::ForOthers`], [`Refused::MarkedBad`] or [`Refused::Older`].
    pub fn admit(&self, seal: &Seal, unit: &UnitId, consent: Consent) -> Result<Admission, Refused> {
        let (letter, id, signer) = (seal.letter(), seal.id(), seal.signer());
        if !letter.addressees.include(unit) {
            return Err(Refused::ForOthers { addressees: letter.addressees.clone(), unit: unit.clone() });
        }
        let is = |generation: &Generation| generation.seal == id;
        if let Some(trial) = &self.trial {
            if is(&trial.generation) {
                return Ok(Admission::OnTrial);
            }
        } else if self.good.as_ref().is_some_and(is) {
            return Ok(Admission::Plays);
        }
        if consent == Consent::Any {
            return Ok(Admission::New);
        }
        if self.good.as_ref().is_some_and(is) {
            return Ok(Admission::Kept);
        }
        if self.bad.contains(&id) {
            return Err(Refused::MarkedBad { sequence: letter.sequence });
        }
        let on_trial = self.trial.as_ref().filter(|trial| trial.generation.signer == signer);
        let floor = self.floors.get(&signer).copied().max(on_trial.map(|trial| trial.generation.sequence));
        let is_kept = |floor| self.kept().any(|kept| (kept.signer, kept.sequence) == (signer, floor));
        match floor {
            Some(floor) if letter.sequence < floor || letter.sequence == floor && is_kept(floor) => {
                Err(Refused::Older { sequence: letter.sequence, floor, signer })
            }
            Some(_) | None => Ok(Admission::New),
        }
    }

    /// The number that the next generation gets.
    pub fn next_number(&self) -> u64 {
        self.newest + 1
    }

    /// The new generation is installed: it goes on trial.
    #[must_use]
    pub fn installed(mut self, generation: Generation) -> Self {
        self.newest = self.newest.max(generation.number);
        self.before = None;
        self.trial = Some(Trial { generation, starts: 0, joins: 0, unknown: Unknown::new() });
        self
    }

    /// The unit begins to play the one on trial.
    #[must_use]
    pub fn started(mut self) -> (Self, Verdict) {
        match &mut self.trial {
            Some(trial) if trial.starts >= STARTS => (self.lost(), Verdict::Lost),
            Some(trial) => {
                trial.starts += 1;
                (self, Verdict::Open)
            }
            None => (self, Verdict::Open),
        }
    }

    /// The last start is not held against the one on trial: nobody could have seen it, or it ended as it was told to.
    #[must_use]
    pub fn excused(mut self) -> Self {
        if let Some(trial) = &mut self.trial {
            trial.starts = trial.starts.saturating_sub(1);
        }
        self
    }

    /// A clip of the one on trial was on the glass to its end. What ends a machine in the midst of a clip is met there
    /// again by the next start, which then gets no further: so the starts before are not held against it.
    #[must_use]
    pub fn shown(mut self) -> (Self, Verdict) {
        let Some(trial) = &mut self.trial else { return (self, Verdict::Open) };
        trial.starts = 0;
        trial.joins += 1;
        if trial.joins < JOINS { (self, Verdict::Open) } else { (self.won(), Verdict::Won) }
    }

    /// The one on trial has proved itself.
    #[must_use]
    pub fn won(mut self) -> Self {
        if let Some(Trial { generation, .. }) = self.trial.take() {
            let floor = self.floors.entry(generation.signer).or_insert(generation.sequence);
            *floor = generation.sequence.max(*floor);
            self.before = self.good.replace(generation);
        }
        self
    }

    /// The one on trial does not play.
    #[must_use]
    pub fn lost(mut self) -> Self {
        if let Some(Trial { generation, .. }) = self.trial.take() {
            self.bad.retain(|bad| *bad != generation.seal);
            self.bad.push(generation.seal);
            let surplus = self.bad.len().saturating_sub(BAD);
            self.bad.drain(..surplus);
        }
        self
    }

    /// The good one turned out to be beyond repair: the one before it plays.
    #[must_use]
    pub fn good_is_gone(mut self) -> Self {
        self.good = self.before.take();
        self
    }

    /// What plays is gone from the disk, and nobody is to blame.
    #[must_use]
    pub fn vanished(mut self) -> Self {
        if self.trial.take().is_none() { self.good_is_gone() } else { self }
    }

    /// Nothing older than the good one is kept any longer.
    #[must_use]
    pub fn without_reserve(mut self) -> Self {
        self.before = None;
        self
    }
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands it over so")]
fn is_none(count: &u32) -> bool {
    *count == 0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::names::Addressees;
    use crate::seal::{Letter, Unverified};
    use crate::secret::SecretKey;
    use crate::secret::tests::{artist, stranger};
    use crate::trust::Trust;
    use proptest::prelude::*;
    use std::sync::OnceLock;

    #[derive(Clone, Copy, Debug)]
    enum Event {
        Arrives { key: usize, sequence: u64, consent: bool },
        Started,
        Excused,
        Shown,
        Won,
        Lost,
        GoodIsGone,
        Vanished,
        GivesUp,
    }

    fn keys() -> &'static [SecretKey; 2] {
        static KEYS: OnceLock<[SecretKey; 2]> = OnceLock::new();
        KEYS.get_or_init(|| [stranger(), stranger()])
    }

    fn seal(key: &SecretKey, sequence: u64) -> Seal {
        let letter = Letter {
            flock: "aurora".to_owned(),
            addressees: Addressees::Anyone,
            sequence: Sequence(sequence),
            created: "2026-03-01T12:00:00Z".to_owned(),
            contents: ObjectId::of(b"list"),
            contents_size: 4,
        };
        Unverified::new(letter.sign(key).unwrap()).verify(&Trust::of([key.public()])).unwrap()
    }

    fn generation(state: &State, seal: &Seal) -> Generation {
        let (flock, sequence) = (seal.letter().flock.clone(), seal.letter().sequence);
        let (number, signer, seal) = (state.next_number(), seal.signer(), seal.id());
        Generation { number, flock, signer, sequence, seal, unknown: Unknown::new() }
    }

    fn unit() -> UnitId {
        UnitId::new("lobby").unwrap()
    }

    fn happens(state: State, event: Event) -> State {
        match event {
            Event::Arrives { key, sequence, consent } => {
                let seal = seal(&keys()[key], sequence);
                let consent = if consent { Consent::Any } else { Consent::Newer };
                match state.admit(&seal, &unit(), consent) {
                    Ok(Admission::New) => {
                        let new = generation(&state, &seal);
                        state.installed(new)
                    }
                    Ok(Admission::Kept | Admission::OnTrial | Admission::Plays) | Err(_) => state,
                }
            }
            Event::Started => state.started().0,
            Event::Excused => state.excused(),
            Event::Shown => state.shown().0,
            Event::Won => state.won(),
            Event::Lost => state.lost(),
            Event::GoodIsGone => state.good_is_gone(),
            Event::Vanished => state.vanished(),
            Event::GivesUp => state.without_reserve(),
        }
    }

    fn events() -> impl Strategy<Value = Vec<Event>> {
        let arrives = (0usize..2, 1u64..9, proptest::bool::weighted(0.1))
            .prop_map(|(key, sequence, consent)| Event::Arrives { key, sequence, consent });
        let trying = [Event::Started, Event::Excused, Event::Shown];
        let others = [Event::Won, Event::Lost, Event::GoodIsGone, Event::Vanished, Event::GivesUp];
        let others = proptest::sample::select([&trying[..], &others].concat());
        let event = prop_oneof![3 => arrives, 4 => others];
        proptest::collection::vec(event, 0..40)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(300))]

        #[test]
        fn floors_never_fall_and_only_a_won_trial_raises_them(events in events()) {
            let mut state = State::default();
            for event in events {
                let before = state.clone();
                state = happens(state, event);
                for (key, floor) in &before.floors {
                    prop_assert!(state.floors[key] >= *floor);
                }
                prop_assert!(matches!(event, Event::Won) || state.floors == before.floors, "{:?}", event);
            }
        }

        #[test]
        fn a_good_flock_is_left_for_a_newer_one_only(events in events()) {
            let mut state = State::default();
            for event in events {
                let before = state.clone();
                state = happens(state, event);
                match event {
                    Event::Arrives { .. }
                    | Event::Started
                    | Event::Excused
                    | Event::Shown
                    | Event::Lost
                    | Event::GivesUp => {
                        prop_assert_eq!(&state.good, &before.good);
                    }
                    Event::Won => prop_assert!(before.trial.is_none() || state.before == before.good),
                    Event::GoodIsGone => prop_assert_eq!(&state.good, &before.before),
                    Event::Vanished => {
                        let good = if before.trial.is_some() { before.good } else { before.before };
                        prop_assert_eq!(&state.good, &good);
                    }
                }
                prop_assert!(state.kept().all(|kept| kept.number <= state.newest));
                prop_assert!(state.bad.len() <= BAD);
            }
        }
    }

    #[test]
    fn what_plays_already_is_no_news_and_what_was_replaced_unjudged_may_come_again() {
        let (one, two) = (seal(artist(), 1), seal(artist(), 2));
        let state = State::default();
        let first = generation(&state, &one);
        let state = state.installed(first);
        assert_eq!(state.admit(&one, &unit(), Consent::Newer).unwrap(), Admission::OnTrial);
        let state = state.won();
        assert_eq!(state.admit(&one, &unit(), Consent::Any).unwrap(), Admission::Plays);
        let second = generation(&state, &two);
        let state = state.installed(second);
        assert_eq!(state.admit(&one, &unit(), Consent::Newer).unwrap(), Admission::Kept);
        let third = generation(&state, &seal(artist(), 3));
        let state = state.installed(third).lost();
        assert_eq!(state.admit(&two, &unit(), Consent::Newer).unwrap(), Admission::New);
    }

    /// On trial, in an evening in which it was shown for so many joins.
    fn evening(state: State, joins: u32) -> (State, Verdict) {
        let (state, verdict) = state.started();
        (0..joins).fold(
            (state, verdict),
            |(state, verdict), _| if verdict == Verdict::Open { state.shown() } else { (state, verdict) },
        )
    }

    #[test]
    fn a_trial_counts_what_was_shown_over_as_many_short_evenings_as_it_takes() {
        let state = State::default();
        let new = generation(&state, &seal(artist(), 1));
        let mut state = state.installed(new);
        for started in 1..JOINS {
            let (after, verdict) = evening(state, 1);
            assert_eq!((verdict, after.trial.as_ref().map(|trial| trial.joins)), (Verdict::Open, Some(started)));
            state = after;
        }
        let (state, verdict) = evening(state, 1);
        assert_eq!((verdict, state.good.is_some(), state.bad.len()), (Verdict::Won, true, 0));
    }

    #[test]
    fn a_trial_is_lost_by_starts_that_show_nothing_unless_nobody_could_have_seen_them() {
        let state = State::default();
        let new = generation(&state, &seal(artist(), 1));
        let mut state = evening(state.installed(new), 1).0;
        for _ in 0..2 * STARTS {
            let (after, verdict) = state.started();
            assert_eq!(verdict, Verdict::Open);
            state = after.excused();
        }
        for _ in 0..STARTS {
            let (after, verdict) = state.started();
            assert_eq!(verdict, Verdict::Open);
            state = after;
        }
        let (state, verdict) = state.started();
        assert_eq!((verdict, state.bad.len()), (Verdict::Lost, 1));
    }

    #[test]
    fn the_flock_that_set_the_floor_is_let_in_again_when_the_disk_has_lost_it() {
        let (old, new) = (seal(artist(), 1), seal(artist(), 2));
        let mut state = State::default();
        for seal in [&old, &new] {
            let generation = generation(&state, seal);
            state = state.installed(generation).won();
        }
        assert_eq!(state.admit(&new, &unit(), Consent::Newer).unwrap(), Admission::Plays);
        assert!(state.admit(&old, &unit(), Consent::Newer).is_err());
        // The one before it plays, or none.
        for lost in [state.clone().vanished(), state.vanished().vanished()] {
            assert_eq!(lost.admit(&new, &unit(), Consent::Newer).unwrap(), Admission::New);
            assert!(lost.admit(&old, &unit(), Consent::Newer).is_err() || lost.good.is_some());
        }
    }
}

//! Claims about generations: what becomes of them, whatever happens in whichever order.
//!
//! Owns the events that may happen, and seals for them. Never touches a disk: the store's own claims do.

use super::{
    Addressees, Admission, BAD, Consent, Generation, JOINS, Refusal, STARTS, Seal, State, UnitId, Unknown, Verdict,
};
use crate::seal::tests::letter;
use crate::seal::{SealBody, UnverifiedSeal};
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
    seal_for(Addressees::Anyone, key, sequence)
}

fn seal_for(addressees: Addressees, key: &SecretKey, sequence: u64) -> Seal {
    let letter = SealBody { addressees, ..letter(sequence) };
    UnverifiedSeal::new(letter.sign(key).unwrap()).verify(&Trust::of([key.public()])).unwrap()
}

fn generation(state: &State, seal: &Seal) -> Generation {
    let (flock, sequence) = (seal.letter().flock.clone(), seal.letter().sequence);
    let addressees = Some(seal.letter().addressees.clone());
    let (number, signer, seal) = (state.next_number(), seal.signer(), seal.id());
    Generation { number, flock, signer, sequence, seal, addressees, unknown: Unknown::new() }
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
                    state.install_trial(new)
                }
                Ok(Admission::Kept | Admission::OnTrial | Admission::Plays) | Err(_) => state,
            }
        }
        Event::Started => state.record_start().0,
        Event::Excused => state.excuse_start(),
        Event::Shown => state.record_clip().0,
        Event::Won => state.accept(),
        Event::Lost => state.reject(),
        Event::GoodIsGone => state.drop_good(),
        Event::Vanished => state.drop_playing(),
        Event::GivesUp => state.drop_before(),
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
    let state = state.install_trial(first);
    assert_eq!(state.admit(&one, &unit(), Consent::Newer).unwrap(), Admission::OnTrial);
    let state = state.accept();
    assert_eq!(state.admit(&one, &unit(), Consent::Any).unwrap(), Admission::Plays);
    let second = generation(&state, &two);
    let state = state.install_trial(second);
    assert_eq!(state.admit(&one, &unit(), Consent::Newer).unwrap(), Admission::Kept);
    let third = generation(&state, &seal(artist(), 3));
    let state = state.install_trial(third).reject();
    assert_eq!(state.admit(&two, &unit(), Consent::Newer).unwrap(), Admission::New);
}

/// On trial, in an evening in which it was shown for so many joins.
fn evening(state: State, joins: u32) -> (State, Verdict) {
    let (state, verdict) = state.record_start();
    (0..joins).fold(
        (state, verdict),
        |(state, verdict), _| if verdict == Verdict::Open { state.record_clip() } else { (state, verdict) },
    )
}

#[test]
fn a_trial_counts_what_was_shown_over_as_many_short_evenings_as_it_takes() {
    let state = State::default();
    let new = generation(&state, &seal(artist(), 1));
    let mut state = state.install_trial(new);
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
    let mut state = evening(state.install_trial(new), 1).0;
    for _ in 0..2 * STARTS {
        let (after, verdict) = state.record_start();
        assert_eq!(verdict, Verdict::Open);
        state = after.excuse_start();
    }
    for _ in 0..STARTS {
        let (after, verdict) = state.record_start();
        assert_eq!(verdict, Verdict::Open);
        state = after;
    }
    let (state, verdict) = state.record_start();
    assert_eq!((verdict, state.bad.len()), (Verdict::Lost, 1));
}

#[test]
fn the_flock_that_set_the_floor_is_let_in_again_when_the_disk_has_lost_it() {
    let (old, new) = (seal(artist(), 1), seal(artist(), 2));
    let mut state = State::default();
    for seal in [&old, &new] {
        let generation = generation(&state, seal);
        state = state.install_trial(generation).accept();
    }
    assert_eq!(state.admit(&new, &unit(), Consent::Newer).unwrap(), Admission::Plays);
    assert!(state.admit(&old, &unit(), Consent::Newer).is_err());
    // The one before it plays, or none.
    for lost in [state.clone().drop_playing(), state.drop_playing().drop_playing()] {
        assert_eq!(lost.admit(&new, &unit(), Consent::Newer).unwrap(), Admission::New);
        assert!(lost.admit(&old, &unit(), Consent::Newer).is_err() || lost.good.is_some());
    }
}

/// Admits what is newer, and has it win its trial.
fn takes(state: State, seal: &Seal, consent: Consent) -> Result<State, Refusal> {
    assert_eq!(state.admit(seal, &unit(), consent)?, Admission::New);
    let new = generation(&state, seal);
    Ok(state.install_trial(new).accept())
}

#[test]
fn who_has_its_own_takes_nothing_for_everybody_unless_somebody_on_site_says_so() {
    let own = |sequence| seal_for(Addressees::of([unit()]), artist(), sequence);
    let for_all = |sequence| seal(artist(), sequence);
    let is_refused = |state: &State, sequence| {
        matches!(state.admit(&for_all(sequence), &unit(), Consent::Newer), Err(Refusal::ForEverybody { .. }))
    };
    let state = takes(State::default(), &for_all(1), Consent::Newer).unwrap();
    let state = takes(state, &for_all(2), Consent::Newer).unwrap();
    let new = generation(&state, &own(3));
    let on_trial = state.install_trial(new);
    assert!(is_refused(&on_trial, 4), "also while its own is on trial");
    assert!(!is_refused(&on_trial.clone().reject(), 4), "what did not play says nothing");
    let state = on_trial.accept();
    assert!(
        is_refused(&state, 4) && is_refused(&state.clone().drop_playing().drop_playing(), 4),
        "a disk that forgets is no word"
    );
    let other = UnitId::new("stairs").unwrap();
    assert_eq!(state.admit(&for_all(4), &other, Consent::Newer).unwrap(), Admission::New, "it has another name now");
    let state = takes(state, &own(5), Consent::Newer).unwrap();
    let state = takes(state, &for_all(6), Consent::Any).unwrap();
    takes(takes(state, &for_all(7), Consent::Newer).unwrap(), &own(8), Consent::Newer).unwrap();
}

#[test]
fn what_an_older_program_did_not_write_is_learned_from_the_seals() {
    let own = Addressees::of([unit()]);
    let forget = |generation: &mut Generation| generation.addressees = None;
    let mut state = takes(State::default(), &seal_for(own.clone(), artist(), 1), Consent::Newer).unwrap();
    state = takes(state, &seal_for(own.clone(), artist(), 2), Consent::Newer).unwrap();
    let known = state.clone();
    state.good.iter_mut().chain(&mut state.before).for_each(forget);
    // An older program keeps what it does not know, also where it has put another flock in its place.
    state.addressees = Some(Addressees::Anyone);
    assert_eq!(state.clone().addressed(|_| Some(own.clone())), known);
    assert_eq!(state.clone().addressed(|_| None), state, "a seal that cannot be read says nothing");
    assert_eq!(known.clone().addressed(|_| Some(Addressees::Anyone)), known, "what is known is not asked for");
    let text = serde_json::to_string(&known).unwrap();
    assert_eq!(serde_json::from_str::<State>(&text).unwrap(), known);
}

//! What a unit shows without a player or without a flock of its own.
//!
//! Owns the claim on the flock that stands in. The still picture is in `slow/display/still.rs`.

use claims::editions::{await_joins, edition, played};
use claims::flocks::{Flock, SMALL};
use claims::player_run::PlayerRun;
use claims::trace::Trace;
use claims::unit::Unit;
use rustix::process::Signal;
use std::fs;

/// Lines of a trace that are more than a trial needs.
const LINES: usize = 3_000;

/// A player of the unit's own flock, with a spare one.
fn with_spare(unit: &Unit, flock: &Flock) -> PlayerRun {
    for (name, bytes) in edition(flock, "spare") {
        let path = unit.path("spare").join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }
    let (own, spare) = (unit.path("store/current"), unit.path("spare"));
    let free = ["--screen", "virtual", "--clock", "free", "--hash", "--status", "off", "--seed", "5", "--spare"];
    PlayerRun::of(&own).with(&free).with(&[spare.to_str().unwrap()])
}

#[test]
fn another_flock_stands_in_until_the_units_own_can_be_read() {
    let flock = SMALL.flock();
    let unit = Unit::new();
    let playing = with_spare(&unit, &flock);
    let mut running = playing.start();
    await_joins(&mut running, 10);
    unit.maker.bundle(&unit.stick(), &edition(&flock, "own"), &[], 1);
    unit.updated(&[]);
    running.await_line_with("own/");
    await_joins(&mut running, 10);
    running.signal(Signal::TERM);
    let (code, trace) = running.end_within(10);
    assert_eq!((code, trace.faults.len()), (Some(0), 0));
    let editions: Vec<_> = played(&flock, &trace).into_iter().map(|(edition, _)| edition).collect();
    let own = editions.iter().position(|edition| *edition == "own").expect("the path went over");
    assert!(own >= 10 && editions[own..].iter().all(|edition| *edition == "own"), "{editions:?}");

    fs::remove_file(unit.path("store/current")).unwrap();
    fs::create_dir(unit.path("store/current")).unwrap();
    fs::write(unit.path("store/current/flock.toml"), "rubbish").unwrap();
    let mut running = playing.start();
    await_joins(&mut running, 10);
    running.signal(Signal::TERM);
    let (code, trace) = running.end_within(10);
    assert_eq!(code, Some(0));
    assert!(played(&flock, &trace).iter().all(|(edition, _)| *edition == "spare"), "what is rubbish is not played");
}

#[test]
fn a_first_flock_that_fails_its_trial_gives_way_to_the_one_that_stands_in() {
    let flock = SMALL.flock();
    let unit = Unit::new();
    let playing = with_spare(&unit, &flock);
    let mut running = playing.start();
    await_joins(&mut running, 10);
    let mut files = edition(&flock, "own");
    for (name, bytes) in &mut files {
        if name.contains('=') {
            bytes.truncate(bytes.len() / 2);
        }
    }
    unit.maker.bundle(&unit.stick(), &files, &[], 1);
    unit.updated(&[]);
    // It may be lost before a frame of it is shown.
    let is_lost = || !unit.path("store/current").exists();
    assert!((0..LINES).any(|_| is_lost() || running.next_line().end.is_some()), "the trial is not over");
    let is_spare = |line: &Trace| line.flips.iter().all(|flip| flip.clip.starts_with("spare/"));
    let other = (0..LINES).filter(|_| !is_spare(&running.next_line())).count();
    assert!(other < LINES / 3, "{other} of {LINES} lines are not of the spare flock");
    running.signal(Signal::TERM);
    let (code, _) = running.end_within(10);
    assert_eq!(code, Some(0), "the same run");
    assert!(!unit.path("store/current").exists(), "the store has no flock");
}

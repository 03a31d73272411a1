//! The player changes to another flock: at a join, with every frame, with the same walk; and back, if the new one does
//! not play.
//!
//! Owns the claims on player and updater together, on a virtual screen that flips as fast as frames come. What an
//! update installs is in `updates/sticks.rs`.

use claims::editions::{FREE, JOINS, await_joins, edition, named, played, state, unit_with};
use claims::flocks::{Plan, SMALL};
use claims::player_run::PlayerRun;
use claims::programs::{self, output};
use claims::trace::Trace;
use rustix::process::Signal;
use serde_json::{Value, json};
use std::fs;

/// Options of one in real time: it can be ended during its first clip.
const TIMED: [&str; 7] = ["--screen", "virtual", "--hash", "--status", "off", "--seed", "5"];
#[test]
fn an_edited_folder_is_gone_over_to_at_a_join_and_an_edit_that_cannot_be_played_is_not() {
    let (flock, folder) = (SMALL.flock(), tempfile::tempdir_in(programs::claims_folder()).unwrap());
    let [one, two] = ["one", "two"].map(|name| edition(&flock, name));
    for (name, bytes) in one.iter().chain(&two) {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }
    let edit = |text: &[u8]| {
        fs::write(folder.path().join("new"), text).unwrap();
        fs::rename(folder.path().join("new"), folder.path().join("flock.toml")).unwrap();
    };
    edit(&one["flock.toml"]);
    let mut running = PlayerRun::of(folder.path()).with(&FREE).start();
    await_joins(&mut running, 3);
    edit(b"format = 1\nname = ");
    await_joins(&mut running, 9);
    let text = String::from_utf8(two["flock.toml"].clone()).unwrap();
    edit(text.replacen("size = [", "size = [1", 1).as_bytes());
    await_joins(&mut running, 9);
    edit(&two["flock.toml"]);
    running.await_line_with("\"to\":\"two/");
    await_joins(&mut running, 9);
    running.signal(Signal::TERM);
    let (code, trace) = running.end_within(10);
    assert_eq!((code, trace.faults.len()), (Some(0), 0), "{:?}", trace.faults);
    let clips = played(&flock, &trace);
    let went_over = clips.iter().position(|(edition, _)| *edition == "two").unwrap();
    assert!(went_over > 20 && clips[went_over..].iter().all(|(edition, _)| *edition == "two"), "{clips:?}");
}

#[test]
fn the_player_goes_over_to_a_new_flock_at_a_join_with_every_frame_and_on_the_same_path() {
    let flock = SMALL.flock();
    let (unit, playing) = unit_with(&flock);
    let mut running = playing.start();
    running.await_line_with("\"join\"");
    unit.maker.bundle(&unit.stick(), &edition(&flock, "two"), &[], 2);
    assert_eq!(unit.updated(&[])["outcome"], "installed");
    running.await_line_with("\"to\":\"two/");
    await_joins(&mut running, JOINS);
    running.signal(Signal::TERM);
    let (code, trace) = running.end_within(10);
    assert_eq!((code, trace.faults.len()), (Some(0), 0), "{:?}", trace.faults);
    let clips = played(&flock, &trace);
    let went_over = clips.iter().position(|(edition, _)| *edition == "two").unwrap();
    assert!(went_over > 0 && clips[went_over..].iter().all(|(edition, _)| *edition == "two"));
    let walk = flock.walk("5", 400);
    let path: Vec<&str> = clips.iter().map(|(_, clip)| *clip).collect();
    let found = walk.windows(path.len()).any(|walked| walked == path);
    assert!(found, "the path goes on as the walk has it: {path:?}");
    let known = state(&unit);
    assert_eq!((&known["good"]["number"], &known["trial"]), (&2.into(), &Value::Null), "it has proved itself");
}

#[test]
fn a_new_flock_that_does_not_play_gives_way_to_the_one_before_and_is_marked_bad() {
    let flock = SMALL.flock();
    let (unit, playing) = unit_with(&flock);
    let mut bad = edition(&flock, "two");
    for loops in ["two/s0.mp4", "two/s2.mp4"] {
        bad.insert(loops.to_owned(), b"no clip".to_vec());
    }
    let mut running = playing.start();
    running.await_line_with("\"join\"");
    unit.maker.bundle(&unit.stick(), &bad, &[], 2);
    unit.updated(&[]);
    running.await_line_with("\"fault\"");
    await_joins(&mut running, JOINS);
    running.signal(Signal::TERM);
    let (code, trace) = running.end_within(10);
    assert_eq!(code, Some(0));
    assert_eq!(trace.end.as_ref().map(|end| (end.late, end.repeated, end.skipped)), Some((0, 0, 0)));
    assert_eq!(played(&flock, &trace).last().unwrap().0, "one");
    assert_eq!(state(&unit)["bad"].as_array().unwrap().len(), 1);
    let said = unit.update(&[]);
    assert_eq!(said.status.code(), Some(1));
    assert_eq!(unit.notice().as_deref(), Some("This flock was tried here before, and did not play."));
}

#[test]
fn a_new_flock_that_ends_the_player_again_and_again_gives_way_to_the_one_before() {
    let flock = SMALL.flock();
    let (unit, _) = unit_with(&flock);
    unit.maker.bundle(&unit.stick(), &edition(&flock, "two"), &[], 2);
    unit.updated(&[]);
    let playing = PlayerRun::of(&unit.path("store/current")).with(&TIMED);
    for start in 1..=4 {
        let mut running = playing.start();
        running.await_line_with("\"flip\"");
        running.signal(Signal::KILL);
        let (_, trace) = running.end_within(10);
        let expected = if start <= 3 { "two" } else { "one" };
        assert_eq!(named(&trace.flips[0]).0, expected, "at start {start}");
    }
    assert_eq!(state(&unit)["good"]["number"], 1);
}

#[test]
fn a_trial_goes_on_over_short_evenings_and_through_starts_that_nobody_could_see() {
    let flock = SMALL.flock();
    let (unit, playing) = unit_with(&flock);
    unit.maker.bundle(&unit.stick(), &edition(&flock, "two"), &[], 2);
    unit.updated(&[]);
    let play = |options: &[&str]| PlayerRun::of(&unit.path("store/current")).with(options);
    // Starts without a display, and with an early end by a signal.
    for _ in 0..4 {
        let said = output(&mut play(&["--screen", "kms:/dev/null"]).command());
        assert_eq!(said.status.code(), Some(3), "{}", String::from_utf8_lossy(&said.stderr));
    }
    let timed = play(&TIMED);
    for _ in 0..4 {
        let mut running = timed.start();
        running.await_line_with("\"flip\"");
        running.signal(Signal::TERM);
        assert_eq!(running.end_within(10).0, Some(0));
    }
    assert_eq!(state(&unit)["trial"]["starts"], 0, "nothing of that is held against it");
    // The power is cut every evening, after some joins.
    let (mut evenings, mut joins) = (0, 0);
    while state(&unit)["trial"]["joins"].as_u64().is_none_or(|joins| joins < 17) {
        let mut running = playing.start();
        await_joins(&mut running, 3);
        running.signal(Signal::KILL);
        let (_, trace) = running.end_within(10);
        assert_eq!(named(&trace.flips[0]).0, "two", "evening {evenings}");
        let trial = state(&unit)["trial"].clone();
        if trial.is_null() {
            break;
        }
        let counted = trial["joins"].as_u64().unwrap();
        assert!(trial["starts"] == 0 && counted > joins, "{trial} after {joins} joins");
        (evenings, joins) = (evenings + 1, counted);
    }
    assert!(evenings > 3, "{evenings} evenings");
    let mut running = playing.start();
    await_joins(&mut running, JOINS);
    running.signal(Signal::TERM);
    running.end_within(10);
    let known = state(&unit);
    assert_eq!((&known["good"]["number"], &known["bad"]), (&2.into(), &json!([])), "it has proved itself");
}

#[test]
fn a_flock_of_another_size_or_rate_takes_over_in_the_same_run_with_every_frame_and_on_the_same_path() {
    let small = SMALL.flock();
    let larger = Plan { name: "larger", size: (480, 360), fps: (20, 1), ..SMALL }.flock();
    let (unit, playing) = unit_with(&small);
    let mut running = playing.start();
    running.await_line_with("\"join\"");
    unit.maker.bundle(&unit.stick(), &edition(&larger, "two"), &[], 2);
    unit.updated(&[]);
    running.await_line_with("\"to\":\"two/");
    await_joins(&mut running, JOINS);
    unit.maker.bundle(&unit.stick(), &edition(&small, "three"), &[], 3);
    unit.updated(&[]);
    running.await_line_with("\"to\":\"three/");
    running.signal(Signal::TERM);
    let (code, trace) = running.end_within(10);
    assert_eq!((code, trace.faults.len()), (Some(0), 0), "{:?}", trace.faults);
    let modes: Vec<&str> = trace.starts.iter().map(|start| &*start.mode).collect();
    assert_eq!(modes, ["320x240@60", "480x360@60", "320x240@60"]);
    let mut editions: Vec<Trace> = Vec::new();
    for flip in trace.flips {
        if editions.last().is_none_or(|trace| named(&trace.flips[0]).0 != named(&flip).0) {
            editions.push(Trace::default());
        }
        editions.last_mut().unwrap().flips.push(flip);
    }
    let [one, two, three] = &editions[..] else { panic!("{} editions were played", editions.len()) };
    let clips = [(&small, one), (&larger, two), (&small, three)].map(|(flock, trace)| played(flock, trace));
    let path: Vec<&str> = clips.iter().flatten().map(|(_, clip)| *clip).collect();
    let walk = small.walk("5", 800);
    assert!(walk.windows(path.len()).any(|walked| walked == path), "the path goes on as the walk has it: {path:?}");
    assert_eq!(state(&unit)["good"]["number"], 2, "it has proved itself");
}

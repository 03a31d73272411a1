//! The player changes to another flock: at a join, with every frame, with the same walk; and back, if the new one does
//! not play.
//!
//! Owns the claims on player and updater together, on a virtual screen that flips as fast as frames come. What an
//! update installs is in `updates/sticks.rs`.

use crate::display::hot_plug::{CARD, HANDS};
use crate::flocks::{Flock, Plan, SMALL};
use crate::guest::{script, shell_words, succeed_in_virtual_time};
use crate::player_run::{PlayerRun, RunningPlayer};
use crate::programs::{self, output};
use crate::trace::{Flip, Trace};
use crate::updates::sticks::Unit;
use claims::bundle_maker::Files;
use rustix::process::Signal;
use serde_json::{Value, json};
use std::fs;

/// Options of a player that plays as fast as possible.
const FREE: [&str; 9] = ["--screen", "virtual", "--clock", "free", "--hash", "--status", "off", "--seed", "5"];
/// Options of one in real time: it can be ended during its first clip.
const TIMED: [&str; 7] = ["--screen", "virtual", "--hash", "--status", "off", "--seed", "5"];
/// More joins than win a trial: the player counts a clip some clips later.
const JOINS: usize = 60;

/// The flock with its clips in the folder `edition`, so that a trace distinguishes editions.
pub(crate) fn edition(flock: &Flock, edition: &str) -> Files {
    let toml = fs::read_to_string(flock.folder.join("flock.toml")).unwrap();
    let toml = toml.replace("clip = \"", &format!("clip = \"{edition}/"));
    let clip = |name: &String| (format!("{edition}/{name}"), fs::read(flock.folder.join(name)).unwrap());
    let mut files: Files = flock.shows.keys().map(clip).collect();
    files.insert("flock.toml".to_owned(), toml.into_bytes());
    files
}

/// A unit that plays the edition `one`, which has won its trial.
fn unit_with(flock: &Flock) -> (Unit, PlayerRun) {
    let unit = Unit::new();
    unit.maker.bundle(&unit.stick(), &edition(flock, "one"), &[], 1);
    unit.updated(&[]);
    let playing = PlayerRun::of(&unit.path("store/current")).with(&FREE);
    let mut running = playing.start();
    await_joins(&mut running, JOINS);
    running.signal(Signal::TERM);
    running.end_within(10);
    assert_eq!(state(&unit)["good"]["number"], 1, "the first flock has proved itself");
    (unit, playing)
}

/// Waits for so many joins.
pub(crate) fn await_joins(running: &mut RunningPlayer, count: usize) {
    for _ in 0..count {
        running.await_line_with("\"join\"");
        running.await_lines(1);
    }
}

/// The state of the unit's store.
fn state(unit: &Unit) -> Value {
    let text = fs::read_to_string(unit.path("store/state.0")).unwrap();
    serde_json::from_str(text.split_once('\n').unwrap().1).unwrap()
}

/// Edition and clip of a flip.
fn named(flip: &Flip) -> (&str, &str) {
    flip.clip.split_once('/').expect("every clip lies in the folder of its edition")
}

/// The clips of a trace, in order, the last one perhaps incomplete. Checks that every frame of each is there, once and
/// in order.
pub(crate) fn played<'t>(flock: &Flock, trace: &'t Trace) -> Vec<(&'t str, &'t str)> {
    let mut clips = Vec::new();
    let mut rest = &trace.flips[..];
    while let Some(first) = rest.first() {
        let (edition, clip) = named(first);
        let shows = &flock.shows[clip];
        let count = shows.len().min(rest.len());
        for (frame, flip) in rest[..count].iter().enumerate() {
            let found = (named(flip), flip.frame, flip.hash.as_deref());
            assert_eq!(found, ((edition, clip), frame as u64, Some(&*shows[frame])), "after {clips:?}");
        }
        clips.push((edition, clip));
        rest = &rest[count..];
    }
    clips
}

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
fn a_trial_counts_nothing_that_was_decoded_for_a_display_that_is_not_plugged_in() {
    let flock = SMALL.flock();
    let (unit, _) = unit_with(&flock);
    unit.maker.bundle(&unit.stick(), &edition(&flock, "two"), &[], 2);
    unit.updated(&[]);
    let playing = PlayerRun::of(&unit.path("store/current")).with(&["--screen", "kms:/dev/dri/$card"]);
    let play = shell_words(&playing.command());
    let start = format!("{play} &\nplayer=$!\nsleep 30; kill -KILL $player; wait $player || true\n");
    let text = format!("{CARD}{HANDS}pull\n{}", start.repeat(4));
    succeed_in_virtual_time(120, &script(&text));
    let trial = &state(&unit)["trial"];
    assert_eq!(
        (&trial["generation"]["number"], &trial["starts"], &trial["joins"]),
        (&2.into(), &0.into(), &Value::Null)
    );
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

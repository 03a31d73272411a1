//! Editions of a flock on a unit, so that a trace shows which one was played.
//!
//! Owns how an edition is made, and a unit whose first one has won its trial. What is claimed of them is in
//! `it/player/flock_switch.rs`.
//!
//! Start at [`edition`] and [`unit_with`].

use crate::bundle_maker::Files;
use crate::flocks::Flock;
use crate::player_run::{PlayerRun, RunningPlayer};
use crate::trace::{Flip, Trace};
use crate::unit::Unit;
use rustix::process::Signal;
use serde_json::Value;
use std::fs;

/// Options of a player that plays as fast as possible.
pub const FREE: [&str; 9] = ["--screen", "virtual", "--clock", "free", "--hash", "--status", "off", "--seed", "5"];
/// More joins than win a trial: the player counts a clip some clips later.
pub const JOINS: usize = 60;

/// The flock with its clips in the folder `edition`, so that a trace distinguishes editions.
pub fn edition(flock: &Flock, edition: &str) -> Files {
    let toml = fs::read_to_string(flock.folder.join("flock.toml")).unwrap();
    let toml = toml.replace("clip = \"", &format!("clip = \"{edition}/"));
    let clip = |name: &String| (format!("{edition}/{name}"), fs::read(flock.folder.join(name)).unwrap());
    let mut files: Files = flock.shows.keys().map(clip).collect();
    files.insert("flock.toml".to_owned(), toml.into_bytes());
    files
}

/// A unit that plays the edition `one`, which has won its trial.
pub fn unit_with(flock: &Flock) -> (Unit, PlayerRun) {
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
pub fn await_joins(running: &mut RunningPlayer, count: usize) {
    for _ in 0..count {
        running.await_line_with("\"join\"");
        running.await_lines(1);
    }
}

/// The state of the unit's store.
pub fn state(unit: &Unit) -> Value {
    let text = fs::read_to_string(unit.path("store/state.0")).unwrap();
    serde_json::from_str(text.split_once('\n').unwrap().1).unwrap()
}

/// Edition and clip of a flip.
pub fn named(flip: &Flip) -> (&str, &str) {
    flip.clip.split_once('/').expect("every clip lies in the folder of its edition")
}

/// The clips of a trace, in order, the last one perhaps incomplete. Checks that every frame of each is there, once and
/// in order.
pub fn played<'t>(flock: &Flock, trace: &'t Trace) -> Vec<(&'t str, &'t str)> {
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

//! Votes before the wall: `dreams-votes` with a pipe for its input device, beside a player on the virtual screen.
//!
//! Owns the claims on a press, from the key to the mark on the picture and to the totals. Time is measured in the player's
//! own flips. What a press counts for is tried in virtual time by `crates/votes`.
//!
//! Start at [`Voting::begin`].

use claims::flocks::Plan;
use claims::programs::{dreams, output, succeed};
use claims::status_page::{ask, pixels};
use claims::trace::Flip;
use claims::voting::{AT_ONCE, DOWN, SEEN_NS, UNSURE_NS, UP, Voting, showings, totals};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs::{self};
use std::path::Path;
use std::process::Command;

/// Clips of some two seconds: a showing takes four.
const QUICK: Plan = Plan { name: "votes", size: (640, 480), fps: (30, 1), sheep: 4, frames: 60 };
/// Clips of some six seconds.
const SLOW: Plan = Plan { name: "votes-slow", size: (320, 240), fps: (10, 1), sheep: 3, frames: 60 };

/// The showing that was seen before the last of `flips`, if it is the same a moment earlier and later.
fn seen(flips: &[Flip], showings: &[(usize, String)]) -> Option<usize> {
    let newest_ns = flips.last()?.t_ns;
    let at = |ns: u64| flips.iter().rposition(|flip| flip.t_ns + ns <= newest_ns).map(|place| showings[place].0);
    let around = [SEEN_NS - UNSURE_NS, SEEN_NS, SEEN_NS + UNSURE_NS].map(at);
    around[1].filter(|showing| around == [Some(*showing); 3])
}

/// The totals up and down of each sheep, by votes for showings of which the last one of each showing counts.
fn expected(votes: impl Iterator<Item = (usize, bool)>, numbered: &[(usize, String)]) -> [BTreeMap<String, u64>; 2] {
    let mut totals = [BTreeMap::new(), BTreeMap::new()];
    let last_votes: BTreeMap<usize, bool> = votes.collect();
    for (showing, is_down) in last_votes {
        let (_, sheep) = numbered.iter().find(|(number, _)| *number == showing).unwrap();
        *totals[usize::from(is_down)].entry(sheep.clone()).or_default() += 1;
    }
    totals
}

#[test]
fn a_press_counts_for_what_was_seen_and_is_answered_at_once() {
    let mut voting = Voting::begin(QUICK);
    // The showing of each press, and after how many flips its mark was lit. Only every other showing is voted for: what counted
    // for the wrong one would be seen.
    let (mut voted, mut waited) = (Vec::new(), Vec::new());
    while waited.len() < 100 {
        voting.watch(1);
        let seen = seen(&voting.flips, &showings(&voting.flock, &voting.flips));
        if let Some(showing) = seen.filter(|showing| showing % 2 == 1) {
            // A vote that changes is stored, too.
            voting.press(if waited.len() % 3 == 0 { DOWN } else { UP });
            voted.push((showing, waited.len() % 3 == 0));
            waited.push(voting.await_mark(waited.len() as u64 + 1));
        }
    }
    // Until the last showing that was voted for is over.
    voting.watch(400);
    let told = voting.shown();
    let numbered = showings(&voting.flock, &voting.flips);
    let late: Vec<usize> = (0..waited.len()).filter(|press| waited[*press] > AT_ONCE).collect();
    assert!(late.len() <= 5, "{} of 100 marks came later than {AT_ONCE} flips after the press: {waited:?}", late.len());
    // On a busy machine a press may be late, too: what was seen is the next showing then.
    let possible = (0..1_u32 << late.len()).map(|moved| {
        let is_moved =
            |press: usize| late.iter().position(|late| *late == press).is_some_and(|at| moved >> at & 1 == 1);
        let votes = voted.iter().enumerate();
        expected(votes.map(|(press, (showing, is_down))| (showing + usize::from(is_moved(press)), *is_down)), &numbered)
    });
    let found = [totals(&told, "up"), totals(&told, "down")];
    let possible: Vec<_> = possible.collect();
    assert!(possible.contains(&found), "{possible:?}, not {found:?}");
    let end = voting.end();
    assert_eq!((end.skipped, end.repeated), (0, 0), "the picture went on");
}

#[test]
fn a_vote_that_was_acknowledged_survives_a_kill_and_a_key_that_is_stuck_gives_none() {
    let mut voting = Voting::begin(SLOW);
    let voted = voting.await_next();
    voting.press(DOWN);
    voting.press_after_bounce(UP);
    voting.await_mark(2);
    voting.kill();
    // Nothing is lost with the device, either.
    voting.unplug();
    let stuck = voting.await_next();
    voting.plug_in();
    voting.key(UP, 1);
    voting.await_mark(3);
    for _ in 0..60 {
        voting.key(UP, 2);
        voting.watch(1);
    }
    voting.key(UP, 0);
    voting.await_next();
    voting.watch(90);
    let told = voting.shown();
    assert_eq!(totals(&told, "up"), BTreeMap::from([(voted, 1)]), "{told:#}");
    assert_eq!((totals(&told, "down").len(), told["sheep"][&stuck]["shown"].as_u64()), (0, Some(1)), "{told:#}");
    voting.end();
}

/// Votes for that the pool `pool` takes in from what `dreams-votes` told.
fn taken_in(pool: &Path, told: &Value) -> u64 {
    let file = pool.with_extension("json");
    fs::write(&file, told.to_string()).unwrap();
    let mut take = Command::new(dreams());
    let said = output(take.arg("votes").args([pool, &file]).args(["--unit", "lobby", "--json"]));
    assert_eq!(said.status.code(), Some(0), "{said:?}");
    let answer: Value = serde_json::from_slice(&said.stdout).unwrap();
    answer["units"]["lobby"]["up"].as_u64().unwrap()
}

#[test]
fn seconds_of_somebody_near_count_for_what_is_seen_and_become_a_vote_of_the_pool() {
    let mut voting = Voting::reading("presence", SLOW.flock());
    let pool = voting.run.path("pool");
    succeed(Command::new(dreams()).args(["pool", "new"]).arg(&pool));
    let before = voting.shown();
    assert_eq!(taken_in(&pool, &before), 0, "less than what counts as a vote: {before:#}");
    // In one showing somebody stands there for most of it, in the next one nobody; in a third the sensor is pulled out.
    let mut seconds: BTreeMap<String, f64> = BTreeMap::new();
    for (is_near, flips) in [(true, 80), (false, 80), (true, 20)] {
        let sheep = voting.await_next();
        let begun_ns = voting.flips.last().unwrap().t_ns;
        voting.key(UP, i32::from(is_near));
        voting.watch(flips);
        let lasted_s = (voting.flips.last().unwrap().t_ns - begun_ns) as f64 / 1e9;
        *seconds.entry(sheep).or_default() += if is_near { lasted_s } else { 0.0 };
        if flips == 80 { voting.key(UP, 0) } else { voting.unplug() }
    }
    voting.await_next();
    voting.watch(90);
    let told = voting.shown();
    let near_s = totals(&told, "near_s");
    for (sheep, before_s) in totals(&before, "near_s") {
        // A look is every half second, and a showing counts whole seconds.
        let (counted_s, was_s) = ((near_s[&sheep] - before_s) as f64, seconds.get(&sheep).copied().unwrap_or_default());
        let is_right = if was_s > 0.0 { counted_s < was_s + 1.0 && counted_s > was_s - 3.0 } else { counted_s == 0.0 };
        assert!(is_right, "`{sheep}`: {counted_s} s were counted, somebody was near for {was_s} s: {told:#}");
    }
    assert!(totals(&told, "up").is_empty(), "nobody has pressed anything: {told:#}");
    let reached = near_s.values().filter(|seconds| **seconds >= 300).count();
    assert_eq!((taken_in(&pool, &told), reached > 0), (reached as u64, true), "{told:#}");
    voting.end();
}

#[test]
fn the_mark_is_a_dot_in_the_corner_of_the_picture() {
    let mut voting = Voting::begin(QUICK);
    let page = voting.run.path("page");
    let light = |rgb: &[u8]| {
        rgb.chunks(3).map(|pixel| pixel.iter().all(|sample| (195..235).contains(sample))).collect::<Vec<_>>()
    };
    voting.press(UP);
    voting.await_mark(1);
    let lit = light(&pixels(&ask(&page, "GET /screen.jpg").body, "jpg"));
    let corner = |at: &usize| at % 640 > 600 - 20 && at / 640 > 440 - 20;
    let dots = (0..lit.len()).filter(corner).filter(|at| lit[*at]).count();
    assert!((40..768).contains(&dots), "{dots} light pixels in the corner");
    voting.end();
}

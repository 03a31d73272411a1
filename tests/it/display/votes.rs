//! Votes on a real display driver, in virtual time.
//!
//! Owns the claim on two hundred presses, at and between joins: what each counts for, how soon it is answered, and that the
//! picture does not notice. `player/votes.rs` has the other claims on votes.

use crate::flocks::{Flock, Plan};
use crate::guest::{script, shell_words, succeed_in_virtual_time, word};
use crate::player::votes::{UP, showings};
use crate::player_run::{PlayerRun, VKMS};
use crate::programs::votes;
use crate::trace::Trace;
use std::collections::BTreeMap;
use std::fs;
use std::process::Command;

/// Clips of two seconds: a showing takes four.
const QUICK: Plan = Plan { name: "votes-on-display", size: (640, 480), fps: (30, 1), sheep: 4, frames: 60 };
/// Presses, and the hundredths of a second between two: no part of a clip is left out.
const PRESSES: usize = 200;
const BETWEEN: &str = "1.63";
/// What a press counts for was lit so long before it.
const SEEN_NS: u64 = 700_000_000;
/// Presses are told in hundredths of a second, frames in thirtieths: so much nearer a change is either side.
const UNSURE_NS: u64 = 50_000_000;
/// A mark is lit so long after its press, and a press may be told so much too early.
const ANSWER_NS: u64 = 150_000_000;

/// Plays, presses, and writes when: in seconds since the guest was started.
fn pressed(playing: &PlayerRun, player: &Command) -> Vec<u64> {
    let [device, presses, config, told] =
        ["device", "presses", "votes.toml", "told"].map(|name| word(&playing.path(name)));
    let event = |value: u8| format!("'{}\\1\\0\\{UP:o}\\0\\{value}\\0\\0\\0'", "\\0".repeat(16));
    let (down, up) = (event(1), event(0));
    let votes = shell_words(&Command::new(votes()));
    let player = shell_words(player);
    let text = format!(
        "mkfifo {device}; exec 9<> {device}
        {player} & player=$!
        sleep 2; {votes} --config {config} & votes=$!
        sleep 3
        for press in $(seq {PRESSES}); do
            sleep {BETWEEN}; cut -d ' ' -f 1 /proc/uptime >> {presses}; printf {down}{up} >&9
        done
        sleep 30; {votes} --config {config} --show > {told}
        kill $votes; kill $player; wait $player"
    );
    succeed_in_virtual_time(400, &script(&text));
    let presses = fs::read_to_string(playing.path("presses")).unwrap();
    presses.lines().map(|line| (line.parse::<f64>().unwrap() * 1e9).round() as u64).collect()
}

/// For each press the showings that it may count for: two if one ended just then.
fn seen(trace: &Trace, flock: &Flock, presses: &[u64]) -> Vec<[(usize, String); 2]> {
    let showings = showings(flock, &trace.flips);
    let at = |ns: u64| {
        let place = trace.flips.partition_point(|flip| flip.t_ns <= ns).saturating_sub(1);
        showings[place].clone()
    };
    let around = |press: &u64| [press - SEEN_NS - UNSURE_NS, press - SEEN_NS + UNSURE_NS].map(at);
    presses.iter().map(around).collect()
}

#[test]
fn two_hundred_presses_around_joins_all_count_and_are_answered_and_no_frame_is_late() {
    let flock = QUICK.flock();
    let playing = PlayerRun::of(&flock.folder).with(&["--screen", VKMS, "--seed", "3"]);
    let [page, mark] = ["page", "mark"].map(|name| playing.path(name));
    let status = format!("unix:{}", page.display());
    let playing = playing.with(&["--acknowledge", mark.to_str().unwrap()]);
    fs::create_dir(playing.path("store")).unwrap();
    let paths = ["device", "store"].map(|name| playing.path(name).display().to_string());
    let config = format!(
        "device = '{}'\nup = {UP}\nstore = '{}'\nstatus = '{status}'\nacknowledge = '{}'\n",
        paths[0],
        paths[1],
        mark.display()
    );
    fs::write(playing.path("votes.toml"), config).unwrap();
    let presses = pressed(&playing, &playing.command_with_page(&status));
    let trace = playing.trace();
    assert_eq!(presses.len(), PRESSES);

    let lit = |number: u64| trace.flips.iter().find(|flip| flip.mark == Some(number)).map(|flip| flip.t_ns);
    let answers: Vec<Option<u64>> =
        (1..).zip(&presses).map(|(number, press)| Some(lit(number)?.saturating_sub(*press))).collect();
    let slow = answers.iter().filter(|answer| answer.is_none_or(|answer| answer > ANSWER_NS)).count();
    assert!(slow <= PRESSES / 100, "{slow} marks came later than {ANSWER_NS} ns after their presses: {answers:?}");

    // One vote a showing, whatever the number of presses.
    let mut votes: BTreeMap<usize, [String; 2]> = BTreeMap::new();
    for [(number, first), (_, second)] in seen(&trace, &flock, &presses) {
        votes.insert(number, [first, second]);
    }
    let (mut least, mut most) = (BTreeMap::<&str, u64>::new(), BTreeMap::<&str, u64>::new());
    for [first, second] in votes.values() {
        *most.entry(first).or_default() += 1;
        if first == second {
            *least.entry(first).or_default() += 1;
        } else {
            *most.entry(second).or_default() += 1;
        }
    }
    let told: serde_json::Value = serde_json::from_str(&fs::read_to_string(playing.path("told")).unwrap()).unwrap();
    for (sheep, most) in most {
        let up = told["sheep"][sheep]["up"].as_u64().unwrap_or_default();
        let least = least.get(sheep).copied().unwrap_or_default();
        assert!((least..=most).contains(&up), "{sheep} has {up} votes, expected {least} to {most}: {told:#}");
    }
    let end = trace.end.unwrap();
    assert_eq!((end.late, end.skipped, end.repeated, end.faults), (0, 0, 0, 0), "the picture went on");
}

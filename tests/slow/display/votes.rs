//! Votes on a real display driver, in virtual time.
//!
//! Owns the claim on two hundred presses, at and between joins: what each counts for, how soon it is answered, and that the
//! picture does not notice. `player/votes.rs` has the other claims on votes.

use crate::guest::{script, shell_words, succeed_in_virtual_time, word};
use claims::flocks::{Flock, Plan};
use claims::player_run::{PlayerRun, VKMS};
use claims::programs::votes;
use claims::trace::Trace;
use claims::voting::{DOWN, UP, showings, totals};
use std::collections::BTreeMap;
use std::fs;
use std::process::Command;

/// Clips of 1.6 seconds and longer: a showing begins in the middle of a transition, and takes at least 3.2.
const QUICK: Plan = Plan { name: "votes-on-display", size: (640, 480), fps: (30, 1), sheep: 4, frames: 48 };
/// Showings whose begin is between two presses.
const ROUNDS: usize = 100;
/// What a press counts for was lit so long before it.
const SEEN_NS: u64 = 700_000_000;
/// Presses are told in hundredths of a second, frames in thirtieths: no press may be so much nearer a change.
const UNSURE_NS: u64 = 40_000_000;
/// A mark is lit so long after its press, and a press may be told so much too early.
const ANSWER_NS: u64 = 150_000_000;

/// A press: when, since the guest was started, and whether it is one against.
struct Pressed {
    at_ns: u64,
    is_down: bool,
}

/// The hundredths of a second after the begin of a showing at which the one before is voted for last, and it first: less
/// than 0.7 s after it, and more.
fn moments(round: usize) -> [usize; 2] {
    [6 + round * 7 % 55, 79 + round * 11 % 46]
}

/// Plays, presses, and writes when and which.
///
/// The showings are voted for and against in turn, and each has another vote before, so that every press is seen in the
/// totals: whatever counts for a showing too early or too late changes its vote.
fn pressed(flock: &Flock, playing: &PlayerRun, player: &Command) -> Vec<Pressed> {
    let [device, presses, config, told, trace] =
        ["device", "presses", "votes.toml", "told", "trace"].map(|name| word(&playing.path(name)));
    let event = |key: u16, value: u8| format!("'{}\\1\\0\\{key:o}\\0\\{value}\\0\\0\\0'", "\\0".repeat(16));
    let [up, down] = [UP, DOWN].map(|key| event(key, 1) + &event(key, 0));
    let votes = shell_words(&Command::new(votes()));
    let player = shell_words(player);
    let rounds: Vec<String> = (0..ROUNDS).map(|round| moments(round).map(|at| at.to_string()).join(" ")).collect();
    let rounds = rounds.join("\n");
    // When each transition shows the first frame of its second half, in hundredths of a second of 29.97 frames each.
    let middle = |(clip, shows): (&String, &Vec<String>)| {
        let frames = shows.len().div_ceil(2) as f64;
        format!("[{clip}]={:.0}", frames * 100.0 / 29.97)
    };
    let middles: Vec<String> = flock.shows.iter().filter(|(clip, _)| clip.contains('=')).map(middle).collect();
    let middles = middles.join(" ");
    let text = format!(
        r#"declare -A middles=({middles})
        mkfifo {device}; exec 9<> {device}
        now() {{ read -r now _ < /proc/uptime; now_cs=$((10#${{now/./}})); }}
        press() {{
            now; left=$(($2 - now_cs)); [ $left -gt 0 ]
            sleep $(printf %d.%02d $((left / 100)) $((left % 100)))
            now; echo $now $1 >> {presses}
            if [ $1 = up ]; then printf {up} >&9; else printf {down} >&9; fi
        }}
        latest() {{ tail -n 300 {trace} | grep '"frame":0,' | grep = | tail -n 1; }}
        {player} & player=$!
        sleep 2; {votes} --config {config} & votes=$!
        sleep 3
        before=$(latest) key=up
        while read -r first second; do
            until begin=$(latest); [ "$begin" != "$before" ]; do sleep 0.1; done
            before=$begin at=${{begin#*\"t_ns\":}} clip=${{begin#*\"clip\":\"}}
            middle=$((${{at%%[!0-9]*}} / 10000000 + ${{middles[${{clip%%\"*}}]}}))
            press $key $((middle + first)); press $key $((middle + second)); sleep 0.6
            if [ $key = up ]; then key=down; else key=up; fi
        done <<< '{rounds}'
        sleep 30; {votes} --config {config} --show > {told}
        kill $votes; kill $player; wait $player"#
    );
    succeed_in_virtual_time(500, &script(&text));
    let presses = fs::read_to_string(playing.path("presses")).unwrap();
    let press = |line: &str| {
        let (at, key) = line.split_once(' ').unwrap();
        Pressed { at_ns: (at.parse::<f64>().unwrap() * 1e9).round() as u64, is_down: key == "down" }
    };
    presses.lines().map(press).collect()
}

/// The votes for and against each sheep, if presses count for what was lit `ago_ns` before: one a showing, the last.
fn votes_of(trace: &Trace, flock: &Flock, presses: &[Pressed], ago_ns: u64) -> [BTreeMap<String, u64>; 2] {
    let showings = showings(flock, &trace.flips);
    let at = |ns: u64| {
        let place = trace.flips.partition_point(|flip| flip.t_ns <= ns).saturating_sub(1);
        showings[place].clone()
    };
    let mut votes: BTreeMap<(usize, String), bool> = BTreeMap::new();
    for Pressed { at_ns, is_down } in presses {
        let [earlier, later] = [at_ns - ago_ns - UNSURE_NS, at_ns - ago_ns + UNSURE_NS].map(at);
        assert!(earlier == later || ago_ns != SEEN_NS, "a press at {at_ns} ns may count for {earlier:?} or {later:?}");
        votes.insert(at(at_ns - ago_ns), *is_down);
    }
    [false, true].map(|wanted| {
        let mut sums = BTreeMap::new();
        for ((_, sheep), _) in votes.iter().filter(|(_, is_down)| **is_down == wanted) {
            *sums.entry(sheep.clone()).or_default() += 1;
        }
        sums
    })
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
        "device = '{}'\nup = {UP}\ndown = {DOWN}\nstore = '{}'\nstatus = '{status}'\nacknowledge = '{}'\n",
        paths[0],
        paths[1],
        mark.display()
    );
    fs::write(playing.path("votes.toml"), config).unwrap();
    let presses = pressed(&flock, &playing, &playing.command_with_page(&status));
    let trace = playing.trace();
    assert_eq!(presses.len(), 2 * ROUNDS);

    let lit = |number: u64| trace.flips.iter().find(|flip| flip.mark == Some(number)).map(|flip| flip.t_ns);
    let answers: Vec<Option<u64>> =
        (1..).zip(&presses).map(|(number, press)| Some(lit(number)?.saturating_sub(press.at_ns))).collect();
    let slow = answers.iter().filter(|answer| answer.is_none_or(|answer| answer > ANSWER_NS)).count();
    assert!(
        slow <= presses.len() / 100,
        "{slow} marks came later than {ANSWER_NS} ns after their presses: {answers:?}"
    );

    let told: serde_json::Value = serde_json::from_str(&fs::read_to_string(playing.path("told")).unwrap()).unwrap();
    let expected = votes_of(&trace, &flock, &presses, SEEN_NS);
    assert_eq!(["up", "down"].map(|kind| totals(&told, kind)), expected, "{told:#}");
    let votes: u64 = expected.iter().flat_map(BTreeMap::values).sum();
    assert_eq!(votes, ROUNDS as u64 + 1, "one vote a showing: {expected:?}");
    // Any other time from seeing to pressing would have given other totals.
    for ago_ns in [0, 2 * SEEN_NS] {
        assert_ne!(votes_of(&trace, &flock, &presses, ago_ns), expected, "{ago_ns} ns before");
    }
    let end = trace.end.unwrap();
    assert_eq!((end.late, end.skipped, end.repeated, end.faults), (0, 0, 0, 0), "the picture went on");
}

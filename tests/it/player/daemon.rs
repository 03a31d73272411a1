//! The player as a service of a unit.
//!
//! Owns the claims on its trace, its exit codes, its config and its end.

use claims::flocks::SMALL;
use claims::player_run::PlayerRun;
use claims::programs::{self, claims_folder, output};
use claims::trace::End;
use rustix::process::Signal;
use std::fs;
use std::process::Command;

#[test]
fn a_signal_ends_the_player_within_a_second_and_the_place_is_kept() {
    let flock = SMALL.flock();
    let playing = PlayerRun::of(&flock.folder).with(&["--screen", "virtual", "--status", "off", "--seed", "8"]);
    let walk = flock.walk("8", 200);
    let mut place = 0;
    for signal in [Signal::TERM, Signal::INT, Signal::TERM] {
        let mut running = playing.start();
        running.await_lines(12);
        running.signal(signal);
        let (code, trace) = running.end_within(1);
        assert_eq!(code, Some(0), "{signal:?}");
        let end = trace.end.as_ref().expect("a run that ends tells its counts");
        assert_eq!((end.flips, end.joins), (trace.flips.len() as u64, trace.joins.len() as u64));
        let clips = trace.clips();
        let due = &walk[place..place + clips.len()];
        assert_eq!(clips, due, "{signal:?}: the path goes on in the clip that was being played");
        place += clips.len() - 1;
    }
}

#[test]
fn the_trace_tells_what_is_lit_and_closes_with_its_counts() {
    let flock = SMALL.flock();
    let options =
        ["--screen", "virtual:320x240@50", "--clock", "free", "--status", "off", "--clips", "20", "--seed", "1"];
    let (code, trace) = PlayerRun::of(&flock.folder).with(&options).start().end_within(30);
    assert_eq!(code, Some(0));
    let [start] = &trace.starts[..] else { panic!("one start, found {:?}", trace.starts) };
    assert_eq!((start.screen.as_str(), start.mode.as_str()), ("virtual", "320x240@50"));
    assert!(!start.format.is_empty());
    assert!(trace.flips.iter().all(|flip| flip.hash.is_none()), "hashes cost time: only under --hash");
    let frames = flock.frames(&flock.walk("1", 20)).len() as u64;
    let counts = End { flips: frames, late: 0, repeated: 0, skipped: 0, joins: 19, faults: 0 };
    assert_eq!(trace.end, Some(counts));
}

#[test]
fn every_refusal_has_its_exit_code_and_names_what_it_refuses() {
    let scratch = tempfile::tempdir_in(claims_folder()).unwrap();
    let config = scratch.path().join("player.toml");
    fs::write(&config, "hash = true\ncolour = 3\n").unwrap();
    let config = config.to_str().unwrap();
    let small = SMALL.flock().folder;
    let small = small.to_str().unwrap();
    let malformed = programs::repository().join("tests/fixtures/unknown-key");
    let malformed = malformed.to_str().unwrap();
    let cases: [(&[&str], i32, &[&str]); 7] = [
        (&["--no-such-option"], 2, &["--no-such-option"]),
        (&["--config", config], 2, &["player.toml", "line 2", "`colour`"]),
        (&["--config", "no/such.toml"], 3, &["no/such.toml"]),
        (&["--flock", malformed, "--screen", "virtual"], 2, &["unknown-key/flock.toml", "line 8", "`colour`"]),
        (&["--flock", "no/such/flock", "--screen", "virtual"], 3, &["no/such/flock"]),
        (&["--flock", small, "--screen", "kms:/dev/no-such-card"], 3, &["/dev/no-such-card"]),
        (&["--flock", small, "--screen", "virtual", "--status", "0.0.0.0:7180"], 2, &["0.0.0.0:7180"]),
    ];
    for (options, code, named) in cases {
        let mut player = Command::new(programs::player());
        player.args(options).arg("--state").arg(scratch.path().join("state"));
        let said = output(&mut player);
        let error = String::from_utf8_lossy(&said.stderr);
        assert_eq!(said.status.code(), Some(code), "{options:?}: {error}");
        assert!(said.stdout.is_empty(), "{options:?}: complaints go to standard error");
        for value in named {
            assert!(error.contains(value), "{options:?} names {value}: {error}");
        }
    }
}

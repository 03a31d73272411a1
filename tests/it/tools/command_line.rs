//! The artist's command line, as scripts use it.
//!
//! Owns the claims on `dreams check`, `share`, `walk` and `simulate`: their JSON, exit codes, streams and errors. The
//! defective manifests are in `tests/fixtures`, each named for its defect.

use claims::programs::{self, json, output};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn fixture(defect: &str) -> PathBuf {
    programs::repository().join("tests/fixtures").join(defect)
}

/// `dreams COMMAND FIXTURE OPTIONS...`.
fn dreams(command: &str, defect: &str, options: &[&str]) -> Output {
    output(Command::new(programs::dreams()).arg(command).arg(fixture(defect)).args(options))
}

/// The options that `command` requires.
fn steps_of(command: &str) -> &'static [&'static str] {
    if ["walk", "simulate"].contains(&command) { &["--seed", "1", "--steps", "3"] } else { &[] }
}

#[test]
fn every_fault_of_a_graph_is_found_and_named() {
    let cases = [
        ("duplicate-sheep", "duplicate-sheep", "a"),
        ("duplicate-transition", "duplicate-transition", "a"),
        ("unknown-sheep", "unknown-sheep", "ghost"),
        ("dead-end", "dead-end", "c"),
        ("orphan-sheep", "unreachable", "c"),
        ("two-islands", "split", "c"),
    ];
    for (defect, kind, named) in cases {
        let said = dreams("check", defect, &["--json"]);
        assert_eq!(said.status.code(), Some(1), "{defect}");
        let answer = json(&said);
        assert_eq!(answer["ok"], false, "{defect}");
        let faults = answer["faults"].as_array().unwrap();
        let of_graph: Vec<_> = faults.iter().filter(|fault| fault["kind"] != "missing-clip").collect();
        let found = of_graph.iter().find(|fault| fault["kind"] == kind);
        let found = found.unwrap_or_else(|| panic!("{defect} has a fault `{kind}`, found {of_graph:?}"));
        assert!(found["message"].as_str().unwrap().contains(&format!("`{named}`")), "{found}");
        assert!(faults.iter().all(|fault| fault["message"].is_string() && fault["kind"].is_string()));
    }
}

#[test]
fn a_clip_that_is_not_there_is_a_fault_of_its_own() {
    let said = dreams("check", "seven", &["--json"]);
    assert_eq!(said.status.code(), Some(1));
    let answer = json(&said);
    let faults = answer["faults"].as_array().unwrap();
    assert!(faults.iter().all(|fault| fault["kind"] == "missing-clip"), "{faults:?}");
    let clips: BTreeSet<_> = faults.iter().map(|fault| fault["clip"].as_str().unwrap()).collect();
    assert_eq!(clips.len(), 19, "seven loops and twelve transitions");
}

#[test]
fn a_malformed_manifest_is_refused_with_file_line_key_and_both_values() {
    let cases: [(&str, &[&str]); 9] = [
        ("unknown-key", &["line 8", "`colour`"]),
        ("wrong-format", &["line 1", "`format`", "1", "`2`"]),
        ("path-outside", &["line 9", "`clip`", "`../a.mp4`"]),
        ("weight-of-nothing", &["line 17", "`weight`", "above 0", "`0`"]),
        ("odd-size", &["line 3", "`size`", "even", "641"]),
        ("no-such-rate", &["line 4", "`fps`", "30, 0"]),
        ("bad-id", &["line 7", "`id`", "`a b`", "A-Z a-z 0-9 . _ -"]),
        ("not-toml", &["line 6"]),
        ("loop-without-frames", &["line 6", "`frames`"]),
    ];
    for (defect, named) in cases {
        for command in ["check", "share", "walk", "simulate"] {
            let said = dreams(command, defect, steps_of(command));
            let error = String::from_utf8_lossy(&said.stderr);
            assert_eq!(said.status.code(), Some(2), "{command} {defect}: {error}");
            assert!(said.stdout.is_empty(), "{command} {defect} writes no data");
            assert!(error.contains(&format!("{defect}/flock.toml")), "{command} {defect}: {error}");
            for value in named {
                assert!(error.contains(value), "{command} {defect} names {value}: {error}");
            }
        }
    }
}

#[test]
fn what_cannot_be_read_and_what_cannot_be_meant_have_their_own_exit_codes() {
    for command in ["check", "share", "walk", "simulate"] {
        let said = dreams(command, "no-such-flock", steps_of(command));
        let error = String::from_utf8_lossy(&said.stderr);
        assert_eq!(said.status.code(), Some(3), "{command}: {error}");
        assert!(error.contains("no-such-flock"), "{command}: {error}");
        let said = dreams(command, "seven", &["--no-such-option"]);
        assert_eq!(said.status.code(), Some(2), "{command}");
        assert!(said.stdout.is_empty(), "{command} writes complaints to standard error");
    }
    let said = dreams("simulate", "seven", &["--seed", "1", "--steps", "4000000000"]);
    assert_eq!(said.status.code(), Some(2), "a simulation that no memory holds");
}

#[test]
fn a_walk_is_the_same_for_the_same_seed_in_both_forms() {
    let options = ["--seed", "9", "--steps", "200"];
    let lines = dreams("walk", "seven", &options);
    let document = dreams("walk", "seven", &[&options[..], &["--json"]].concat());
    assert_eq!((lines.status.code(), document.status.code()), (Some(0), Some(0)));
    assert!(lines.stderr.is_empty(), "nothing to complain of");
    let lines = String::from_utf8(lines.stdout).unwrap();
    let document = json(&document);
    let clips: Vec<_> = document["clips"].as_array().unwrap().iter().map(|clip| clip.as_str().unwrap()).collect();
    assert_eq!(lines.lines().collect::<Vec<_>>(), clips);
    assert_eq!(lines.as_bytes(), dreams("walk", "seven", &options).stdout);
    assert_ne!(lines.as_bytes(), dreams("walk", "seven", &["--seed", "10", "--steps", "200"]).stdout);
}

#[test]
fn a_walk_meets_end_to_end() {
    let said = dreams("walk", "seven", &["--seed", "4", "--steps", "500"]);
    let text = String::from_utf8(said.stdout).unwrap();
    let ends = |clip: &str| {
        let name = clip.trim_end_matches(".mp4");
        name.split_once('=').map_or((name.to_owned(), name.to_owned()), |(a, b)| (a.to_owned(), b.to_owned()))
    };
    let clips: Vec<_> = text.lines().map(ends).collect();
    assert!(clips.windows(2).all(|pair| pair[0].1 == pair[1].0), "every clip begins where the one before ends");
}

#[test]
fn a_simulation_comes_to_what_the_shares_predict() {
    let simulated = json(&dreams("simulate", "seven", &["--seed", "1", "--steps", "20000", "--json"]));
    let shares = json(&dreams("share", "seven", &["--json"]));
    assert_eq!(of_sheep(&simulated, "predicted"), of_sheep(&shares, "visits"));
    assert_eq!(simulated["outside"], 0);
    for (id, bound) in of_sheep(&simulated, "bound") {
        // For 20,000 steps: a purely random walk could be off by ten times as much.
        assert!(bound.is_some_and(|bound| (0.0..0.002).contains(&bound)), "{id}: {bound:?}");
    }
}

#[test]
fn a_simulation_tells_visits_returns_and_repeats() {
    let said = dreams("simulate", "seven", &["--seed", "1", "--steps", "20000", "--json"]);
    assert_eq!(said.status.code(), Some(0));
    let answer = json(&said);
    let visits = answer["sheep"].as_array().unwrap();
    assert_eq!(visits.len(), 7);
    let sum: f64 = visits.iter().map(|sheep| sheep["visits"].as_f64().unwrap()).sum();
    assert!((sum - 1.0).abs() < 1e-9, "visits are shares, their sum is {sum}");
    for field in ["worst_ratio", "min_return_minutes", "p05_return_minutes", "longest_repeat"] {
        assert!(answer[field].is_number(), "`{field}` in {answer}");
    }
    for field in ["k2", "k3", "k4"] {
        assert!(answer["first_repeat"].get(field).is_some(), "`{field}` in {answer}");
    }
    assert!(answer["worst_ratio"].as_f64().unwrap() >= 1.0);
}

/// The field of each sheep of `answer`, by id.
fn of_sheep<'a>(answer: &'a Value, field: &str) -> BTreeMap<&'a str, Option<f64>> {
    let sheep = answer["sheep"].as_array().unwrap().iter();
    sheep.map(|sheep| (sheep["id"].as_str().unwrap(), sheep[field].as_f64())).collect()
}

#[test]
fn the_shares_of_a_flock_are_exact_and_sum_to_one() {
    let said = dreams("share", "seven", &["--json"]);
    assert_eq!(said.status.code(), Some(0));
    let answer = json(&said);
    let visits = of_sheep(&answer, "visits");
    // Found by hand, from the way into `a` on around the ring.
    for (id, of_25) in [("a", 2.0), ("b", 3.0), ("c", 4.0), ("d", 4.0), ("e", 4.0), ("f", 4.0), ("g", 4.0)] {
        let visits = visits[id].unwrap();
        assert!((visits - of_25 / 25.0).abs() < 1e-15, "{id}: {visits}");
    }
    for field in ["visits", "time", "want"] {
        let sum: f64 = of_sheep(&answer, field).values().flatten().sum();
        assert!((sum - 1.0).abs() < 1e-12, "the {field} of all sheep sum to {sum}");
    }
    let transitions = answer["transitions"].as_array().unwrap();
    let sum: f64 = transitions.iter().map(|transition| transition["visits"].as_f64().unwrap()).sum();
    assert!((sum - 1.0).abs() < 1e-12 && transitions.iter().all(|t| t["from"].is_string() && t["to"].is_string()));
    assert!((answer["worst_ratio"].as_f64().unwrap() - 25.0 / 14.0).abs() < 1e-12);
    assert!((0.0..=7f64.log2()).contains(&answer["entropy_bits"].as_f64().unwrap()));
    assert!(of_sheep(&answer, "return_minutes").values().all(|minutes| minutes.unwrap() > 0.0));
}

#[test]
fn shares_of_a_faulty_flock_are_those_of_what_is_played() {
    for (defect, unplayed) in [("dead-end", &["c"][..]), ("orphan-sheep", &["c"]), ("two-islands", &["c", "d"])] {
        let said = dreams("share", defect, &["--json"]);
        assert_eq!(said.status.code(), Some(1), "{defect}");
        let answer = json(&said);
        for (id, visits) in of_sheep(&answer, "visits") {
            assert_eq!(visits, Some(if unplayed.contains(&id) { 0.0 } else { 0.5 }), "{defect}, sheep `{id}`");
        }
        let faults = answer["faults"].as_array().unwrap();
        assert!(faults.iter().any(|fault| fault["sheep"] == unplayed[0]), "{defect}: {faults:?}");
        let told = String::from_utf8(said.stderr).unwrap();
        assert!(told.contains(&format!("`{}`", unplayed[0])), "{defect}: {told}");
    }
}

#[test]
fn what_cannot_be_written_ends_with_3_and_what_nobody_reads_is_fine() {
    let full = || std::fs::File::create("/dev/full").unwrap();
    for words in [&["--help"][..], &["walk", "--help"], &["--version"], &["completions", "bash"]] {
        let said = programs::output_to(full(), Command::new(programs::dreams()).args(words));
        assert_eq!(said.status.code(), Some(3), "{words:?} to a full disk");
        assert!(String::from_utf8_lossy(&said.stderr).contains("cannot write the answer"), "{words:?}");
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let said = programs::output_to(writer, Command::new(programs::dreams()).args(words));
        assert_eq!(said.status.code(), Some(0), "{words:?} to nobody");
    }
}

#[test]
fn every_command_says_what_its_exit_codes_mean() {
    for command in ["check", "share", "walk", "simulate"] {
        let said = output(Command::new(programs::dreams()).args([command, "--help"]));
        let help = String::from_utf8(said.stdout).unwrap();
        assert!(help.contains("Exit status:"), "{command}: {help}");
        for code in ["  0  ", "  1  ", "  2  ", "  3  "] {
            assert!(help.contains(code), "{command} explains {code}: {help}");
        }
    }
}

#[test]
fn what_opens_no_clip_loads_no_ffmpeg_and_what_does_is_handed_over() {
    let dreams = programs::dreams();
    let loads_ffmpeg = |program: &Path| {
        let said = programs::succeed(Command::new(program).env("LD_TRACE_LOADED_OBJECTS", "1"));
        String::from_utf8(said).unwrap().contains("libavcodec.so")
    };
    assert!(!loads_ffmpeg(&dreams), "`dreams` is linked with ffmpeg");
    assert!(loads_ffmpeg(&dreams.with_file_name("dreams-video")), "`dreams-video` is not");
    // By itself it does what it can, and names what it lacks before it has said or written anything.
    let alone = tempfile::tempdir().unwrap();
    let program = alone.path().join("dreams");
    programs::copy_program(&dreams, &program);
    let small = programs::repository().join("flock-tools/demo/small");
    let page = alone.path().join("page.html");
    let run = |words: &[&str]| output(Command::new(&program).args(words).arg(&small));
    for words in [&["share"][..], &["report", "--no-pictures", "--out", page.to_str().unwrap()]] {
        assert_eq!(run(words).status.code(), Some(0), "{words:?}");
    }
    fs::remove_file(&page).unwrap();
    for words in [&["check"][..], &["report", "--out", page.to_str().unwrap()], &["render", "--dry-run"]] {
        let said = run(words);
        let error = String::from_utf8_lossy(&said.stderr);
        assert_eq!((said.status.code(), said.stdout.len(), page.exists()), (Some(3), 0, false), "{words:?}");
        assert!(error.starts_with("error: cannot start") && error.contains("it belongs beside `dreams`"), "{error}");
    }
}

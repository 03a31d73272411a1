//! What commands answer when they refuse.
//!
//! Owns the claims that a wrong word is answered with what was meant and what to do next, that errors are JSON where JSON
//! is asked for, and that nothing which a name contains has an effect on a terminal. Which mistakes are refused is
//! claimed where each command is.

use claims::programs::{self, json, output};
use serde_json::{Value, json};
use std::fs;
use std::process::{Command, Output};

const HEAD: &str = "format = 1\nname = \"aurora\"\nsize = [64, 64]\nfps = [30, 1]\n";

/// A folder with a flock `aurora` of two sheep and a way there and back.
struct Bench {
    scratch: tempfile::TempDir,
}

impl Bench {
    fn new() -> Self {
        let bench = Self { scratch: tempfile::tempdir().unwrap() };
        let sheep = |id: &str| format!("[[sheep]]\nid = \"{id}\"\nframes = 30\nclip = \"{id}.mp4\"\n");
        let transition = |from: &str, to: &str| {
            format!("[[transition]]\nfrom = \"{from}\"\nto = \"{to}\"\nframes = 30\nclip = \"{from}={to}.mp4\"\n")
        };
        let parts =
            [sheep("191.21054"), sheep("orchid"), transition("191.21054", "orchid"), transition("orchid", "191.21054")];
        bench.writes(&format!("{HEAD}{}", parts.concat()));
        bench
    }

    fn writes(&self, manifest: &str) {
        fs::create_dir_all(self.scratch.path().join("aurora")).unwrap();
        fs::write(self.scratch.path().join("aurora/flock.toml"), manifest).unwrap();
    }

    fn dreams(&self, words: &[&str]) -> Output {
        output(Command::new(programs::dreams()).args(words).current_dir(self.scratch.path()))
    }

    /// What a command that must end with `code` says on standard error.
    fn says(&self, code: i32, words: &[&str]) -> String {
        let said = self.dreams(words);
        let error = String::from_utf8(said.stderr).unwrap();
        assert_eq!(said.status.code(), Some(code), "{words:?}: {error}");
        error
    }

    /// The JSON answer of a command that must end with `code`.
    fn answers(&self, code: i32, words: &[&str]) -> Value {
        let said = self.dreams(&[words, &["--json"]].concat());
        assert_eq!(said.status.code(), Some(code), "{words:?}");
        json(&said)
    }
}

#[test]
fn what_is_mistyped_is_answered_with_what_was_meant() {
    let bench = Bench::new();
    for (words, meant) in [
        (&["chekc", "aurora"][..], "a similar subcommand exists: 'check'"),
        (&["walk", "aurora", "--steps", "3", "--sed", "1"], "a similar argument exists: '--seed'"),
        (&["want", "aurora", "orchids", "2"], "hint: did you mean `orchid`?"),
        (&["drop", "aurora", "191.21045"], "hint: did you mean `191.21054`?"),
        (&["rename", "aurora", "Orchid", "rose"], "hint: did you mean `orchid`?"),
        (&["link", "aurora", "orchid", "rose"], "hint: it has `191.21054`, `orchid`"),
        (&["unlink", "aurora", "orchd", "191.21054"], "hint: did you mean `orchid`?"),
        (&["unlink", "aurora", "orchid", "orchid"], "hint: `orchid` leads to `191.21054`"),
        (&["render", "aurora", "orchit"], "hint: did you mean `orchid`?"),
    ] {
        let said = bench.says(2, words);
        assert!(said.contains(meant), "{words:?}: {said}");
    }
    bench.writes(&format!("{HEAD}[[sheep]]\nid = \"a\"\nframs = 3\nclip = \"a.mp4\"\n"));
    let said = bench.says(2, &["check", "aurora"]);
    assert!(said.contains("hint: there is `frams`: did you mean `frames`?"), "{said}");
    bench.writes(&format!("{HEAD}[[sheep]]\nid = \"a\"\nwnat = 3\n"));
    let said = bench.says(2, &["check", "aurora"]);
    assert!(said.contains("unknown key `wnat`") && said.contains("hint: did you mean `want`?"), "{said}");
}

#[test]
fn what_stands_in_the_way_is_told_with_the_next_step() {
    let bench = Bench::new();
    let said = bench.says(2, &["link", "aurora", "orchid", "191.21054", "--weight", "3"]);
    assert!(said.contains("hint: `dreams weight DIR orchid 191.21054 WEIGHT` sets how readily it is taken"), "{said}");
    let said = bench.says(2, &["add", "aurora", "orchid", "--no-loop"]);
    assert!(said.contains("hint: `dreams want DIR orchid WANT` sets how often it is wished"), "{said}");
    bench.writes(HEAD);
    let said = bench.says(2, &["want", "aurora", "orchid", "2"]);
    assert!(said.contains("hint: it has no sheep yet; `dreams add` puts them in"), "{said}");
}

#[test]
fn with_json_an_error_is_one_document_and_a_refusal_keeps_its_own() {
    let bench = Bench::new();
    let error = |code: i32, words: &[&str]| {
        let answer = bench.answers(code, words);
        let fields: Vec<_> = answer["error"].as_object().unwrap().keys().map(String::as_str).collect();
        assert_eq!(fields, ["causes", "exit", "hint", "message"], "{words:?}: {answer}");
        assert_eq!(answer["error"]["exit"], code, "{words:?}: {answer}");
        assert_eq!(answer.as_object().unwrap().len(), 1, "{words:?}: {answer}");
        answer["error"].clone()
    };
    let missing = error(3, &["check", "nowhere"]);
    assert_eq!(missing["message"], "cannot read `nowhere/flock.toml`");
    assert_eq!(missing["causes"], json!(["No such file or directory (os error 2)"]));
    assert_eq!(missing["hint"], "a flock is a folder with a file `flock.toml`");
    let unknown = error(2, &["want", "aurora", "orchids", "2"]);
    assert_eq!((&unknown["causes"], &unknown["hint"]), (&json!([]), &json!("did you mean `orchid`?")));
    let usage = error(2, &["want", "aurora", "orchid", "2", "--jsno"]);
    assert_eq!(usage["message"], "unexpected argument '--jsno' found");
    assert_eq!(error(2, &["want", "aurora"])["causes"], json!([]));
    assert_eq!(error(2, &["chekc"])["hint"], "a similar subcommand exists: 'check'");
    assert_eq!(error(1, &["new", "aurora"])["hint"], Value::Null);
    // Through `dreams-video`, too.
    assert_eq!(error(2, &["render", "aurora", "orchit"])["hint"], "did you mean `orchid`?");
    // These have an answer of their own, which says what keeps them.
    assert_eq!(bench.answers(1, &["check", "aurora"])["ok"], false);
    let refused = bench.answers(1, &["unlink", "aurora", "orchid", "191.21054"]);
    assert_eq!((&refused["changed"], refused.get("error")), (&json!(false), None), "{refused}");
    // For people the error is on standard error, and standard output is for the document alone.
    let said = bench.dreams(&["check", "nowhere", "--json"]);
    assert!(
        String::from_utf8(said.stderr).unwrap().starts_with("error: cannot read `nowhere/flock.toml`: No such file")
    );
    let said = bench.dreams(&["check", "nowhere"]);
    assert!(said.stdout.is_empty());
}

#[test]
fn nothing_that_a_name_contains_has_an_effect_on_a_terminal() {
    const ODD: &str = "a\u{1b}[2J\u{9b}1m\u{202e}\rb\nc";
    const TOLD: &str = "a\\u{1b}[2J\\u{9b}1m\\u{202e}\\u{d}b\\u{a}c";
    let bench = Bench::new();
    let quoted = serde_json::to_string(ODD).unwrap();
    bench.writes(&format!("format = 1\nname = {quoted}\nsize = [64, 64]\nfps = [30, 1]\n[[sheep]]\nid = \"a\"\n"));
    let key = format!("{HEAD}[[sheep]]\nid = \"a\"\n\"\\u001b[2J\" = 1\n");
    let harmless = |said: &Output, why: &str| {
        let said = String::from_utf8([&said.stdout[..], &said.stderr].concat()).unwrap();
        assert!(said.chars().all(|c| c == '\n' || !c.is_control() && c != '\u{202e}'), "{why}: {said:?}");
        said
    };
    for words in [
        &["walk", "aurora", "--steps", "3"][..],
        &["check", ODD],
        &["want", "aurora", ODD, "2"],
        &["want", "aurora", "a", ODD],
        &[ODD],
        &["render", "aurora", "--out", ODD],
        &["import", "aurora", ODD],
        &["new", "aurora", "--name", ODD],
    ] {
        let said = harmless(&bench.dreams(words), &format!("{words:?}"));
        assert!(said.contains("error: "), "{words:?}: {said}");
    }
    assert!(harmless(&bench.dreams(&["walk", "aurora", "--steps", "3"]), "walk").contains(TOLD));
    // An answer is as it is in a file, and visible on a terminal.
    let named = &["new", "odd", "--name", ODD][..];
    let folder = bench.scratch.path();
    let line = format!("cd '{}' && '{}' new odd --name \"$ODD\"", folder.display(), programs::dreams().display());
    let on_terminal = output(Command::new("script").args(["-qec", &line, "/dev/null"]).env("ODD", ODD));
    let told = String::from_utf8(on_terminal.stdout).unwrap();
    assert!(told.contains(&format!("flock `{TOLD}` is there")) && !told.contains('\u{1b}'), "{told:?}");
    fs::remove_dir_all(folder.join("odd")).unwrap();
    let on_terminal =
        output(Command::new("script").args(["-qec", &format!("{line} --json"), "/dev/null"]).env("ODD", ODD));
    let told = String::from_utf8(on_terminal.stdout).unwrap();
    assert_eq!(serde_json::from_str::<Value>(&told).unwrap()["name"], ODD);
    assert!(told.chars().all(|c| "\r\n".contains(c) || !c.is_control() && c != '\u{202e}'), "{told:?}");
    fs::remove_dir_all(folder.join("odd")).unwrap();
    assert!(String::from_utf8(bench.dreams(named).stdout).unwrap().contains(ODD));
    bench.writes(&key);
    assert!(harmless(&bench.dreams(&["check", "aurora"]), "a key").contains("unknown key `\\u{1b}[2J`"));
}

#[test]
fn a_walk_without_a_seed_is_another_one_each_time_and_tells_which() {
    let seven = programs::repository().join("tests/fixtures/seven");
    let seven = seven.to_str().unwrap();
    let bench = Bench::new();
    for command in ["walk", "simulate"] {
        let fresh = || bench.dreams(&[command, seven, "--steps", "40"]);
        let told = fresh();
        let note = String::from_utf8(told.stderr).unwrap();
        let seed = note.strip_prefix("note: a fresh walk; --seed ").unwrap().strip_suffix(" gives it again\n").unwrap();
        let again = bench.dreams(&[command, seven, "--steps", "40", "--seed", seed]);
        assert_eq!((&again.stdout, &again.stderr[..]), (&told.stdout, &b""[..]), "{command} --seed {seed}");
        // Two walks of forty steps are the same once in a million million.
        assert_ne!(fresh().stdout, told.stdout, "{command}");
        let answer = bench.answers(0, &[command, seven, "--steps", "40"]);
        let seed = answer["seed"].as_u64().unwrap().to_string();
        let again = bench.answers(0, &[command, seven, "--steps", "40", "--seed", &seed]);
        assert_eq!(again, answer, "{command} --seed {seed}");
    }
}

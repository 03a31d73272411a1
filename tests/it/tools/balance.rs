//! Balanced weights in the manifest.
//!
//! Owns the claims on `dreams balance --write` and `--suggest`: what they change, what they leave as it is, that they
//! reach what they promise. The flock crate tests how weights are found.

use claims::flocks::SMALL;
use claims::programs::{self, json, output};
use serde_json::Value;
use std::fmt::Write as _;
use std::fs;
use std::process::{Command, Output};

const HEAD: &str = "# Aurora\nformat = 1 # the first\nname='aurora'\nsize = [ 64,\n  64 ]\nfps = [30, 1]\n\n";
/// Four sheep with different wants; every weight is written in another way, or missing.
const SHEEP: &str =
    "sheep = [ {id = \"a\"}, {id='b',want=2}, # weight = 3\n\t{ id = \"c\" , want = 1.5e0 },{id=\"d\"}]\n";
const TRANSITIONS: &str = "
[[transition]] # weight = 1
from = \"a\"
to = \"b\"
frames = 384
clip = \"weight = 2\" # weight = 2
weight = 2_0

[[ transition ]]
  weight   =   0.2_5e1# none before this
  \"from\" = 'a'
  to = \"c\"
  frames = 0x10
  clip = \"a=c.mp4\"

[[\"transition\"]]
from=\"b\"
to=\"a\"
frames=384
clip=\"b=a.mp4\"
# weight=7
[[transition]]
from = \"b\"
to = \"d\"
clip = \"\"\"b=d.mp4\"\"\"
'weight' = +4
frames = 12
[[transition]]
from = \"c\"
to = \"a\"
frames = 384
clip = \"c=a.mp4\"   
[[transition]]
from = \"c\"
to = \"d\"
frames = 384
clip = \"c=d.mp4\"
weight = 1e-3
[[transition]]
from = \"d\"
to = \"c\"
frames = 384
clip = \"d=c.mp4\"
[[transition]]
from = \"d\"
to = \"b\"
frames = 384
clip = \"d=b.mp4\"
# the end";

/// A flock with the manifest `text` only.
struct FlockFolder {
    scratch: tempfile::TempDir,
}

impl FlockFolder {
    fn of(text: &str) -> Self {
        let flock_folder = Self { scratch: tempfile::tempdir().unwrap() };
        fs::write(flock_folder.scratch.path().join("flock.toml"), text).unwrap();
        flock_folder
    }

    fn manifest(&self) -> String {
        fs::read_to_string(self.scratch.path().join("flock.toml")).unwrap()
    }

    fn dreams(&self, command: &str, words: &[&str]) -> Output {
        output(Command::new(programs::dreams()).arg(command).arg(self.scratch.path()).args(words))
    }

    fn answers(&self, command: &str, words: &[&str]) -> Value {
        json(&self.dreams(command, &[words, &["--json"]].concat()))
    }
}

/// The manifest's lines without the values of weights, and without lines that are only a weight; and the weights.
fn apart(text: &str) -> (Vec<String>, Vec<String>) {
    let (mut rest, mut weights) = (Vec::new(), Vec::new());
    for line in text.split('\n') {
        let bare = line.trim_start().trim_start_matches(['\'', '"']);
        match bare.strip_prefix("weight").and_then(|_| line.split_once('=')) {
            Some((key, value)) => {
                let value = value.trim_start();
                let end =
                    value.find(|c: char| !(c.is_ascii_alphanumeric() || "+-_.".contains(c))).unwrap_or(value.len());
                weights.push(value[..end].to_owned());
                if key.trim() != "weight" || !value[end..].trim().is_empty() {
                    rest.push(format!("{key}={}", &value[end..]));
                }
            }
            None => rest.push(line.to_owned()),
        }
    }
    (rest, weights)
}

#[test]
fn balanced_weights_are_written_and_nothing_else() {
    let plain = format!("{HEAD}{SHEEP}{TRANSITIONS}");
    for text in [plain.clone(), format!("{plain}\n"), plain.replace('\n', "\r\n"), format!("\u{feff}{plain}")] {
        let flock_folder = FlockFolder::of(&text);
        let before = flock_folder.answers("balance", &[]);
        let answer = flock_folder.answers("balance", &["--write"]);
        assert_eq!(answer["changed"], true);
        assert_eq!(before["weights"], answer["weights"], "written are the weights that were shown");
        let after = flock_folder.manifest();
        let line = |line: &String| line.trim_end_matches('\r').to_owned();
        let lines = |text: &str| apart(text).0.iter().map(line).collect::<Vec<_>>();
        assert_eq!(lines(&after), lines(&text), "{after}");
        assert_eq!(after.matches('\r').count() > 0, text.contains('\r'));
        assert_eq!(after.ends_with('\n'), text.ends_with('\n'));
        let (_, weights) = apart(&after);
        assert_eq!(weights.len(), 8, "{after}");
        assert!(weights.iter().all(|weight| weight.len() <= 9), "readable: {weights:?}");
    }
}

#[test]
fn entries_in_arrays_get_their_weights_inside_their_braces() {
    let arrays = "transition = [ # all\n  {from='a',to=\"b\",frames=1,clip=\"x\",weight=3}, # weight = 3\n  { from = \"b\", \
                  to = \"a\", frames = 1, clip = \"y\" }, {from='b', to='b', weight = 0.5, clip='z', frames=2}\n]\n";
    let sheep = "sheep = [{id = \"a\"}, {id = \"b\", want = 3}]\n";
    let flock_folder = FlockFolder::of(&format!("{HEAD}{sheep}{arrays}"));
    let answer = flock_folder.answers("balance", &["--write", "--fairness", "inf", "--floor", "0"]);
    let weight = |at: usize| format!("{:?}", answer["weights"][at]["weight"].as_f64().unwrap());
    let expected = arrays.replace("weight=3}", &format!("weight={}}}", weight(0)));
    let expected = expected.replace("clip = \"y\" }", &format!("clip = \"y\", weight = {} }}", weight(1)));
    let expected = expected.replace("weight = 0.5", &format!("weight = {}", weight(2)));
    let said = flock_folder.manifest();
    assert_eq!(said, format!("{HEAD}{sheep}{expected}"));
}

#[test]
fn what_is_balanced_keeps_its_promise_and_stays() {
    for terms in [&["--afresh"][..], &["--fairness", "inf", "--floor", "0"], &["--fairness", "30", "--afresh"]] {
        let flock_folder = FlockFolder::of(&format!("{HEAD}{SHEEP}{TRANSITIONS}"));
        let write = [&["--write"], terms].concat();
        let promised = flock_folder.answers("balance", &write);
        let shares = flock_folder.answers("share", &[]);
        for (promised, got) in promised["sheep"].as_array().unwrap().iter().zip(shares["sheep"].as_array().unwrap()) {
            let (promised, got) = (promised["visits"].as_f64().unwrap(), got["visits"].as_f64().unwrap());
            assert!((promised - got).abs() < 1e-12, "{promised} {got}");
        }
        let file = || fs::metadata(flock_folder.scratch.path().join("flock.toml")).unwrap().modified().unwrap();
        let (written, at) = (flock_folder.manifest(), file());
        let again = flock_folder.answers("balance", &write);
        assert_eq!((&again["changed"], &again["weights"]), (&Value::Bool(false), &promised["weights"]));
        assert_eq!((flock_folder.manifest(), file()), (written, at), "the file is not even touched");
    }
}

#[test]
fn a_flock_that_never_had_weights_is_balanced_once() {
    let mut text = format!("{HEAD}{SHEEP}");
    for (from, to) in [("a", "b"), ("b", "a"), ("a", "c"), ("c", "d"), ("d", "c"), ("c", "a"), ("d", "b"), ("b", "d")] {
        write!(text, "[[transition]]\nfrom = \"{from}\"\nto = \"{to}\"\nframes = 2000\nclip = \"{from}{to}\"\n")
            .unwrap();
    }
    let flock_folder = FlockFolder::of(&text);
    let said = flock_folder.dreams("balance", &["--write"]);
    let note = String::from_utf8(said.stderr).unwrap();
    assert!(note.starts_with("note: wrote 4 of 8 weights; the worst ratio of visits and want was 1.455"), "{note}");
    let written = flock_folder.manifest();
    assert_ne!(written, text);
    let again = flock_folder.dreams("balance", &["--write"]);
    assert_eq!(String::from_utf8(again.stderr).unwrap(), "note: nothing to write, all 8 weights stand already\n");
    assert_eq!((flock_folder.manifest(), again.stdout), (written, said.stdout));
}

#[test]
fn weights_that_would_leave_the_worst_ratio_worse_are_not_written() {
    let link = |from: &str, to: &str, weight: f64| {
        format!("[[transition]]\nfrom='{from}'\nto='{to}'\nframes=384\nclip='{from}{to}'\nweight={weight:?}\n")
    };
    let round = [link("a", "b", 1.0), link("b", "a", 1.0), link("b", "c", 8.0), link("c", "a", 1.0)].concat();
    let sheep = "sheep = [{id='a', want=4}, {id='b'}, {id='c'}]\n";
    let flock_folder = FlockFolder::of(&format!("{HEAD}{sheep}{round}"));
    let before = flock_folder.manifest();
    let worst = || flock_folder.answers("share", &[])["worst_ratio"].as_f64().unwrap();
    let stands = worst();
    let answer = flock_folder.answers("balance", &["--write"]);
    assert!(answer["worst_ratio"].as_f64().unwrap() > stands, "{answer}");
    assert_eq!((&answer["kept"], &answer["changed"]), (&Value::Bool(true), &Value::Bool(false)), "{answer}");
    let said = flock_folder.dreams("balance", &["--write"]);
    let note = String::from_utf8(said.stderr).unwrap();
    let told =
        format!("note: nothing written, the weights stay: their worst ratio of visits and want is {stands:.3}, that");
    assert!(note.starts_with(&told), "{note}");
    assert_eq!((flock_folder.manifest(), worst()), (before, stands));
    // As the note says, a transition may help.
    let suggested = flock_folder.answers("balance", &["--suggest", "1"]);
    assert!(suggested["add"][0]["worst_ratio"].as_f64().unwrap() < stands, "{suggested}");
}

#[test]
fn where_no_weights_reach_the_wants_the_nearest_are_written_and_the_answer_is_no() {
    let link =
        |from: &str, to: &str| format!("[[transition]]\nfrom='{from}'\nto='{to}'\nframes=3\nclip='{from}{to}'\n");
    let star = [link("a", "b"), link("b", "a"), link("a", "c"), link("c", "a")].concat();
    let flock_folder = FlockFolder::of(&format!("{HEAD}sheep = [{{id='a'}}, {{id='b'}}, {{id='c', want=2}}]\n{star}"));
    let said = flock_folder.dreams("balance", &["--write", "--json"]);
    assert_eq!(said.status.code(), Some(1));
    let answer = json(&said);
    assert_eq!((&answer["reachable"], &answer["changed"]), (&Value::Bool(false), &Value::Bool(true)));
    assert_eq!(flock_folder.manifest().matches("weight=").count(), 2, "{}", flock_folder.manifest());
}

#[test]
fn a_manifest_that_cannot_be_saved_is_as_it_was() {
    let text = format!("{HEAD}{SHEEP}{TRANSITIONS}");
    let flock_folder = FlockFolder::of(&text);
    // No file may grow: to a program that is the same as a full disk.
    let mut shell = Command::new("bash");
    shell.args(["-c", "trap '' XFSZ; ulimit -f 0; exec \"$@\"", "bash"]).arg(programs::dreams()).arg("balance");
    let said = output(shell.arg(flock_folder.scratch.path()).arg("--write"));
    let error = String::from_utf8(said.stderr).unwrap();
    assert_eq!((said.status.code(), error.contains("cannot save `")), (Some(3), true), "{error}");
    assert_eq!(flock_folder.manifest(), text);
    assert!(said.stdout.is_empty(), "nothing is promised");
}

#[test]
fn what_is_suggested_comes_true_by_command() {
    let flock_folder = FlockFolder::of(&format!("{HEAD}{SHEEP}{TRANSITIONS}"));
    let answer = flock_folder.answers("balance", &["--suggest", "2"]);
    let word = |value: &Value| value.as_str().unwrap().to_owned();
    let number = |value: &Value| value.as_f64().unwrap();
    let (add, remove) = (answer["add"].as_array().unwrap(), answer["remove"].as_array().unwrap());
    assert_eq!(add.len(), 2, "{answer}");
    assert!(number(&add[1]["worst_ratio"]) < number(&answer["worst_ratio"]), "{answer}");
    for (suggestions, command) in [(remove, "unlink"), (add, "link")] {
        let flock_folder = FlockFolder::of(&flock_folder.manifest());
        for one in suggestions {
            let (from, to) = (word(&one["from"]), word(&one["to"]));
            let (weight, frames) = (one["weight"].to_string(), one["frames"].to_string());
            let how: &[&str] = if command == "link" { &["--weight", &weight, "--frames", &frames] } else { &[] };
            let done = flock_folder.dreams(command, &[&[from.as_str(), &to], how].concat());
            assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
            let now = flock_folder.answers("balance", &[]);
            assert_eq!(now["worst_ratio"], one["worst_ratio"], "{command} {from} {to}");
        }
    }
    assert!(add.iter().chain(remove).all(|one| number(&one["seconds"]) > 0.0), "{answer}");
    assert!(add[0]["cpu_hours"].is_null() && add[0]["bytes"].is_null(), "no genome, no clip: {answer}");
}

#[test]
fn a_suggestion_tells_what_its_clip_will_take() {
    // The small flock, but its first sheep is wished more often.
    let scratch = tempfile::tempdir().unwrap();
    for file in fs::read_dir(&SMALL.flock().folder).unwrap().map(Result::unwrap) {
        fs::copy(file.path(), scratch.path().join(file.file_name())).unwrap();
    }
    let manifest = scratch.path().join("flock.toml");
    let text = fs::read_to_string(&manifest).unwrap().replacen("id = \"s0\"", "id = \"s0\"\nwant = 3.0", 1);
    fs::write(&manifest, text).unwrap();
    let suggest = |words: &[&str]| {
        let mut balance = Command::new(programs::dreams());
        output(balance.arg("balance").arg(scratch.path()).args(["--suggest", "1"]).args(words))
    };
    let said = suggest(&["--json"]);
    let answer = json(&said);
    let new = answer["add"].as_array().unwrap().iter().chain(answer["remove"].as_array().unwrap()).next();
    let bytes = new.expect("five sheep have something to improve")["bytes"].as_f64().unwrap();
    assert!(bytes > 100.0, "{answer}");
    assert!(String::from_utf8(suggest(&[]).stdout).unwrap().contains("Each is the best one after those above it"));
}

#[test]
fn what_is_not_played_is_told_apart_from_what_is_stuck() {
    let sheep = |id: &str| format!("[[sheep]]\nid = \"{id}\"\nframes = 30\nclip = \"{id}.mp4\"\n");
    let transition = |ends: &str| {
        let (from, to) = ends.split_at(1);
        format!("[[transition]]\nfrom = \"{from}\"\nto = \"{to}\"\nframes = 30\nclip = \"{ends}.mp4\"\n")
    };
    // `a` and `b` both lead to `c` alone; nothing leads to `d`.
    let parts = ["a", "b", "c", "d"].map(sheep).into_iter().chain(["ac", "bc", "ca", "cb", "da"].map(transition));
    let head = "format = 1\nname = \"odd\"\nsize = [64, 64]\nfps = [30, 1]\n".to_owned();
    let flock_folder = FlockFolder::of(&parts.fold(head, |text, part| text + &part));
    let said = flock_folder.dreams("balance", &[]);
    let told = String::from_utf8(said.stdout).unwrap();
    assert_eq!(said.status.code(), Some(1));
    assert!(told.contains("\nNot played: 1 sheep are wanted 25.000% and get nothing.\nthese  d\n"), "{told}");
    let stuck = "\nBottleneck: 2 sheep are wanted 50.000%, all 1 sheep that they lead to only 25.000%.\nthese  a b\nlead to  c\n";
    assert!(told.contains(stuck), "{told}");
    let answer = flock_folder.answers("balance", &[]);
    assert_eq!(answer["bottleneck"], serde_json::json!(["a", "b", "d"]));
    assert!((answer["deficiency"].as_f64().unwrap() - 0.5).abs() < 1e-9, "{}", answer["deficiency"]);
}

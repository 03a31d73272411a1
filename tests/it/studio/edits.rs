//! Edits of the studio and of commands, on one manifest.
//!
//! Owns the claims that none is lost, that the manifest's bytes are those that commands alone would leave, and that
//! every edit of the studio can be taken back, also after it was killed.
//!
//! Start at [`EditsByChance`].

use super::running::Studio;
use super::sheep::ring;
use crate::programs::{self, succeed};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;

/// How many edits are made: `EDITS` for `make soak`.
pub(super) fn edits() -> usize {
    std::env::var("EDITS").map_or(120, |edits| edits.parse().expect("EDITS is a number"))
}

/// An edit as the studio's page asks for it, and as a command.
pub(super) struct Edit {
    pub(super) request: Value,
    pub(super) words: Vec<String>,
}

/// Edits by chance, each of which fits the flock after all those before it.
pub(super) struct EditsByChance {
    chance: ChaCha8Rng,
    sheep: Vec<String>,
    transitions: BTreeSet<(String, String)>,
    names: u32,
}

impl EditsByChance {
    /// For the flock in `folder`.
    pub(super) fn of(folder: &Path, seed: u64) -> Self {
        let listed = succeed(Command::new(programs::dreams()).args(["list", "--json"]).arg(folder));
        let listed: Value = serde_json::from_slice(&listed).unwrap();
        let text = |value: &Value| value.as_str().expect("an id is a text").to_owned();
        let sheep = listed["sheep"].as_array().unwrap().iter().map(|sheep| text(&sheep["id"])).collect();
        let manifest: toml::Table = fs::read_to_string(folder.join("flock.toml")).unwrap().parse().unwrap();
        let end = |transition: &toml::Value, key: &str| transition[key].as_str().unwrap().to_owned();
        let transitions = manifest["transition"].as_array().unwrap().iter();
        let transitions = transitions.map(|one| (end(one, "from"), end(one, "to"))).collect();
        Self { chance: ChaCha8Rng::seed_from_u64(seed), sheep, transitions, names: 0 }
    }

    fn below(&mut self, limit: usize) -> usize {
        self.chance.next_u32() as usize % limit
    }

    fn one_sheep(&mut self) -> String {
        let at = self.below(self.sheep.len());
        self.sheep[at].clone()
    }

    fn one_transition(&mut self) -> (String, String) {
        let at = self.below(self.transitions.len());
        self.transitions.iter().nth(at).expect("it is below their number").clone()
    }

    /// The next edit. The flock stays large enough for all kinds.
    pub(super) fn next(&mut self) -> Edit {
        let edit =
            |request: Value, words: &[&str]| Edit { request, words: words.iter().map(ToString::to_string).collect() };
        let quarters = 1 + self.below(31);
        let value = quarters as f64 / 4.0;
        let (one, (from, to)) = (self.one_sheep(), self.one_transition());
        match self.below(12) {
            0..3 => edit(json!({ "do": "want", "sheep": one, "value": value }), &["want", &one, &value.to_string()]),
            3..6 => {
                let words = ["weight", &*from, &to, &value.to_string()];
                edit(json!({ "do": "weight", "from": from, "to": to, "value": value }), &words)
            }
            6 => edit(
                json!({ "do": "repeat", "sheep": one, "value": quarters }),
                &["repeat", &one, &quarters.to_string()],
            ),
            7 | 8 => {
                let other = self.one_sheep();
                if !self.transitions.insert((one.clone(), other.clone())) {
                    return self.next();
                }
                let words = ["link", &*one, &other, "--frames", &quarters.to_string()];
                edit(json!({ "do": "link", "from": one, "to": other, "frames": quarters }), &words)
            }
            9 if self.transitions.len() > 30 => {
                self.transitions.remove(&(from.clone(), to.clone()));
                edit(json!({ "do": "unlink", "from": from, "to": to }), &["unlink", &from, &to, "--force"])
            }
            10 if self.sheep.len() > 20 => {
                self.sheep.retain(|sheep| *sheep != one);
                self.transitions.retain(|(from, to)| *from != one && *to != one);
                edit(json!({ "do": "drop", "sheep": one }), &["drop", &one, "--force"])
            }
            _ => {
                self.names += 1;
                let new = format!("ram{}", self.names);
                let renamed = |id: &String| if *id == one { new.clone() } else { id.clone() };
                self.sheep = self.sheep.iter().map(renamed).collect();
                self.transitions = self.transitions.iter().map(|(from, to)| (renamed(from), renamed(to))).collect();
                edit(json!({ "do": "rename", "sheep": one, "to": new }), &["rename", &one, &new])
            }
        }
    }
}

/// Makes `edit` in `folder` by its command. A flock that is left with faults is fine here.
fn command(folder: &Path, edit: &Edit) {
    let (name, words) = edit.words.split_first().expect("a command has a name");
    let said = programs::output(Command::new(programs::dreams()).arg(name).arg(folder).args(words));
    let is_made = said.status.code().is_some_and(|code| code < 2);
    assert!(is_made, "{:?}: {}", edit.words, String::from_utf8_lossy(&said.stderr));
}

fn manifest(folder: &Path) -> String {
    fs::read_to_string(folder.join("flock.toml")).unwrap()
}

#[test]
fn an_edit_made_meanwhile_by_a_command_is_kept() {
    let [mixed, alone] = [(); 2].map(|()| ring("meadow", 40, 2));
    let studio = Studio::of(mixed.path());
    let mut edits_by_chance = EditsByChance::of(mixed.path(), 21);
    let mut known = studio.get("/api/state")["revision"].clone();
    for at in 0..edits() {
        let edit = edits_by_chance.next();
        if edits_by_chance.below(2) == 0 {
            command(mixed.path(), &edit);
        } else {
            // What the page knows may be older: it heard of no edit by a command yet.
            let done = studio.edit(&known, &json!([edit.request]));
            known = done["revision"].clone();
        }
        command(alone.path(), &edit);
        assert_eq!(manifest(mixed.path()), manifest(alone.path()), "edit {at}: {:?}", edit.words);
    }
    assert_eq!(studio.get("/api/state")["sheep"].as_array().map(Vec::len), Some(edits_by_chance.sheep.len()));
}

#[test]
fn edits_of_the_studio_and_of_commands_at_the_same_time_are_all_made() {
    let flock = ring("meadow", 20, 1);
    let studio = Studio::of(flock.path());
    let revision = studio.get("/api/state")["revision"].clone();
    let rounds = edits().min(300) / 20;
    std::thread::scope(|scope| {
        scope.spawn(|| {
            for round in 1..=rounds {
                for at in (0..20).step_by(2) {
                    let words = vec!["want".to_owned(), format!("s{at}"), format!("{round}.25")];
                    command(flock.path(), &Edit { request: Value::Null, words });
                }
            }
        });
        for round in 1..=rounds {
            for at in (1..20).step_by(2) {
                let want = json!({ "do": "want", "sheep": format!("s{at}"), "value": round as f64 + 0.5 });
                studio.edit(&revision, &json!([want]));
            }
        }
    });
    let text = manifest(flock.path());
    for (at, part) in text.split("\n[[sheep]]").skip(1).enumerate() {
        let want = if at % 2 == 0 { format!("want = {rounds}.25\n") } else { format!("want = {rounds}.5\n") };
        assert!(part.contains(&want), "sheep {at} is to have `{want}`: {part}");
    }
}

#[test]
fn every_edit_is_undone_step_by_step_and_made_again_also_after_the_program_was_killed() {
    let flock = ring("meadow", 40, 2);
    let mut studio = Studio::of(flock.path());
    let mut edits_by_chance = EditsByChance::of(flock.path(), 7);
    let mut revision = studio.get("/api/state")["revision"].clone();
    let mut texts = vec![manifest(flock.path())];
    let count = 200;
    for at in 1..=count {
        let edit = edits_by_chance.next();
        revision = studio.edit(&revision, &json!([edit.request]))["revision"].clone();
        if texts.last() != Some(&manifest(flock.path())) {
            texts.push(manifest(flock.path()));
        }
        if at % 70 == 0 {
            studio.kill_and_restart();
        }
    }
    for (left, before) in texts.iter().enumerate().rev().skip(1) {
        let undone = studio.post("/api/undo", &json!({}));
        assert!(undone["said"].as_str().is_some_and(|said| !said.is_empty()), "{undone}");
        assert_eq!(&manifest(flock.path()), before, "{left} steps are left");
    }
    assert_eq!(studio.get("/api/state")["undo"], Value::Null);
    studio.kill_and_restart();
    for after in &texts[1..] {
        studio.post("/api/redo", &json!({}));
        assert_eq!(&manifest(flock.path()), after);
    }
}

#[test]
fn a_gesture_is_one_step_and_a_step_is_not_taken_back_over_somebody_elses_edit() {
    let flock = ring("meadow", 8, 1);
    let studio = Studio::of(flock.path());
    let first = studio.manifest();
    let mut revision = studio.get("/api/state")["revision"].clone();
    for value in [2.0, 3.0, 4.0] {
        let edits = json!([{ "do": "want", "sheep": "s3", "value": value }]);
        let body = json!({ "revision": revision, "gesture": "hand-1", "edits": edits });
        revision = studio.post("/api/edits", &body)["revision"].clone();
    }
    assert!(studio.manifest().contains("want = 4.0"), "{}", studio.manifest());
    studio.post("/api/undo", &json!({}));
    assert_eq!(studio.manifest(), first, "the three are one");
    studio.post("/api/redo", &json!({}));
    command(flock.path(), &Edit { request: Value::Null, words: ["want", "s5", "9"].map(str::to_owned).to_vec() });
    let refused = studio.ask("POST", "/api/undo", Some(&json!({})));
    assert_eq!(refused.status, 409, "{refused:?}");
    let text = studio.manifest();
    assert!(text.contains("want = 4.0") && text.contains("want = 9.0"), "{text}");
}

#[test]
fn an_edit_that_takes_sheep_off_the_wall_is_made_only_if_that_is_meant() {
    let flock = ring("meadow", 6, 0);
    let studio = Studio::of(flock.path());
    let first = studio.manifest();
    let revision = studio.get("/api/state")["revision"].clone();
    let unlink = json!([{ "do": "unlink", "from": "s2", "to": "s3" }]);
    let supposed = studio.post("/api/whatif", &json!({ "edits": unlink }));
    let lost = supposed["no_longer_shown"].as_array().expect("a list").len();
    assert!(lost > 0, "{supposed}");
    let mut body = json!({ "revision": revision, "gesture": null, "edits": unlink });
    let refused = studio.ask("POST", "/api/edits", Some(&body));
    assert_eq!(refused.status, 428, "{refused:?}");
    assert_eq!(refused.json()["no_longer_shown"].as_array().map(Vec::len), Some(lost), "both say the same");
    assert_eq!(studio.manifest(), first, "asking changes nothing");
    body["force"] = true.into();
    studio.post("/api/edits", &body);
    assert!(!studio.manifest().contains("from = \"s2\""), "{}", studio.manifest());
    for (wrong, edits) in [
        ("no such sheep", json!([{ "do": "want", "sheep": "ghost", "value": 1.0 }])),
        ("no weight", json!([{ "do": "weight", "from": "s0", "to": "s1", "value": -1.0 }])),
        ("a name that is taken", json!([{ "do": "rename", "sheep": "s0", "to": "s1" }])),
        (
            "the second of two",
            json!([{ "do": "want", "sheep": "s0", "value": 3.0 }, { "do": "drop", "sheep": "ghost" }]),
        ),
    ] {
        let before = studio.manifest();
        let answer = studio.ask("POST", "/api/edits", Some(&json!({ "revision": studio.get("/api/state")["revision"], "gesture": null, "edits": edits, "force": true })));
        assert!([400, 404, 422].contains(&answer.status), "{wrong}: {answer:?}");
        assert_eq!(studio.manifest(), before, "{wrong}");
    }
}

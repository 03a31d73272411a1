//! Edits of the studio and of commands, on one manifest.
//!
//! Owns the claims that none is lost, that the manifest's bytes are those that commands alone would leave, and that
//! every edit of the studio can be taken back, also after it was killed.
//!
//! Start at [`EditsByChance`].

use claims::programs::{self};
use claims::studio::edits_by_chance::{Edit, EditsByChance, edits};
use claims::studio::running::Studio;
use claims::studio::sheep::ring;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use std::process::Command;

/// Makes `edit` in `folder` by its command. A flock that is left with faults is fine here.
fn command(folder: &Path, edit: &Edit) {
    let (name, words) = edit.words.split_first().expect("a command has a name");
    let said = programs::output(Command::new(programs::dreams()).arg(name).arg(folder).args(words));
    let is_made = said.status.code().is_some_and(|code| code < 2);
    assert!(is_made, "{:?}: {}", edit.words, String::from_utf8_lossy(&said.stderr));
}

/// Kills `studio`, and starts one of the flock in `folder` on a port that is free: the old one may be taken meanwhile.
fn killed_and_restarted(studio: Studio, folder: &Path) -> Studio {
    drop(studio);
    Studio::of(folder)
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
        let edit = edits_by_chance.choose();
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
        let edit = edits_by_chance.choose();
        revision = studio.edit(&revision, &json!([edit.request]))["revision"].clone();
        if texts.last() != Some(&manifest(flock.path())) {
            texts.push(manifest(flock.path()));
        }
        if at % 70 == 0 {
            studio = killed_and_restarted(studio, flock.path());
        }
    }
    for (left, before) in texts.iter().enumerate().rev().skip(1) {
        let undone = studio.post("/api/undo", &json!({}));
        assert!(undone["said"].as_str().is_some_and(|said| !said.is_empty()), "{undone}");
        assert_eq!(&manifest(flock.path()), before, "{left} steps are left");
    }
    assert_eq!(studio.get("/api/state")["undo"], Value::Null);
    let studio = killed_and_restarted(studio, flock.path());
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

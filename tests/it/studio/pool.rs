//! Marks of sheep in a pool.
//!
//! Owns the claim that the studio marks them in the pool's own ledger, as the command does, and takes a mark back there.

use claims::programs::{self, succeed};
use claims::studio::running::Studio;
use claims::studio::sheep::{quick, ring};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use std::process::Command;

fn pool(folder: &Path, words: &[&str]) -> Value {
    let said = succeed(Command::new(programs::dreams()).arg("pool").args(words).arg("--json").current_dir(folder));
    serde_json::from_slice(&said).unwrap()
}

/// The bytes of the ledger of the pool `name`.
fn ledger(folder: &Path, name: &str) -> String {
    fs::read_to_string(folder.join(name).join("ledger.jsonl")).unwrap()
}

#[test]
fn a_mark_of_a_sheep_of_the_pool_stands_in_its_ledger_as_the_command_writes_it_and_is_undone_there() {
    let desk = tempfile::tempdir().unwrap();
    let at = desk.path();
    pool(at, &["new", "pool", "--seed", "3", "--species", "expr"]);
    for kind in 0..2 {
        fs::write(at.join(format!("g{kind}.expr")), quick(kind)).unwrap();
    }
    pool(at, &["add", "pool", "g0.expr", "g1.expr"]);
    succeed(Command::new("cp").args(["--recursive", "pool", "other"]).current_dir(at));
    let flock = ring("meadow", 4, 0);
    let studio = Studio::with(flock.path(), &["--pool", at.join("pool").to_str().unwrap()]);
    let marked = || -> Vec<(String, String)> {
        let state = studio.get("/api/state");
        let all = state["candidates"].as_array().expect("a list").iter();
        let text = |value: &Value| value.as_str().expect("a text").to_owned();
        all.map(|one| (text(&one["id"]), text(&one["mark"]))).collect()
    };
    let [(one, _), (two, _)] = <[_; 2]>::try_from(marked()).expect("two sheep are in the pool");
    let is = |marks: [&str; 2]| {
        let expected = [(one.clone(), marks[0].to_owned()), (two.clone(), marks[1].to_owned())];
        assert_eq!(marked(), expected);
        assert_eq!(ledger(at, "pool"), ledger(at, "other"));
    };
    let mark = |marks: Value| studio.post("/api/marks", &json!({ "marks": marks }));
    mark(json!([{ "sheep": one, "mark": "rejected" }, { "sheep": "s0", "mark": "kept" }]));
    pool(at, &["mark", "other", "reject", &one]);
    is(["rejected", "none"]);
    mark(json!([{ "sheep": two, "mark": "kept", "rating": 4 }]));
    pool(at, &["mark", "other", "keep", &two]);
    is(["rejected", "kept"]);
    // Undone they are what they were: who was rejected lives again.
    for (undone, marks) in [(&two, ["rejected", "none"]), (&one, ["none", "none"])] {
        studio.post("/api/undo", &json!({}));
        pool(at, &["mark", "other", "none", undone]);
        is(marks);
    }
    studio.post("/api/redo", &json!({}));
    pool(at, &["mark", "other", "reject", &one]);
    is(["rejected", "none"]);
    // What the command marks is seen, and is not taken back.
    for name in ["pool", "other"] {
        pool(at, &["mark", name, "keep", &one]);
    }
    studio.post("/api/undo", &json!({}));
    is(["kept", "none"]);
}

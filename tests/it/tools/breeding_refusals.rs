//! What no pool takes that is to be as a brood asks: made failures of all species.
//!
//! Owns the claim on the genomes in `tests/fixtures/failures`, each named for what is wrong with it.

use crate::tools::breeding::{answer, dreams};
use claims::programs::json;
use claims::programs::repository;
use serde_json::json;
use std::fs;
use std::path::PathBuf;

/// Sheep of the demo that some of the failures are too like.
const KNOWN: [&str; 4] = ["corona.flam3", "lagoon.expr", "lilac.plant", "petal.agents"];

#[test]
fn fifty_made_failures_are_all_refused_by_name_and_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    answer(folder, &["pool", "new", "pool", "--seed", "3"]);
    let demo = repository().join("flock-tools/demo/genomes");
    let known = KNOWN.map(|name| demo.join(name).to_str().unwrap().to_owned());
    let strict = |files: &[String]| {
        let words: Vec<&str> = ["pool", "add", "pool", "--strict", "--refused", "refused.png"]
            .into_iter()
            .chain(files.iter().map(String::as_str))
            .collect();
        dreams(folder, &words)
    };
    assert_eq!(json(&strict(&known))["faults"], json!([]), "what nothing is wrong with is taken");

    let failures = fs::read_dir(repository().join("tests/fixtures/failures")).unwrap();
    let mut failures: Vec<PathBuf> = failures.map(|entry| entry.unwrap().path()).collect();
    failures.sort();
    assert_eq!(failures.len(), 50);
    let files: Vec<String> = failures.iter().map(|path| path.to_str().unwrap().to_owned()).collect();
    let said = strict(&files);
    let told = json(&said);
    assert_eq!((said.status.code(), &told["sheep"]), (Some(1), &json!([])), "{told:#}");
    for (path, file) in failures.iter().zip(&files) {
        let name = path.file_name().unwrap().to_str().unwrap();
        let fault = format!("`{file}` is {}", name.split('-').next().unwrap());
        assert!(told["faults"].as_array().unwrap().contains(&json!(fault)), "{fault}: {told:#}");
    }
    assert_eq!(answer(folder, &["pool", "show", "pool"])["living"], 4);
    let png = fs::read(folder.join("refused.png")).unwrap();
    // Ten rows of five pictures, each with a line below it, and the edge.
    assert_eq!(u32::from_be_bytes(png[20..24].try_into().unwrap()), 10 * (135 + 12 + 8) + 8);
}

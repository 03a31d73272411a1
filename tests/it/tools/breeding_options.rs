//! The options of `dreams pool`, `breed`, `votes` and `elect`, one by one.
//!
//! Owns the claims on what each of them changes; `breeding.rs` has those on whole runs.

use crate::tools::breeding::{answer, dreams, files, ids, pool, report};
use claims::programs::{self, json};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;

/// What `dreams pool show` tells of the pool.
fn shown(folder: &Path) -> Value {
    answer(folder, &["pool", "show", "pool"])
}

/// The genes of a plant.
fn genes(genome: &Path) -> Vec<f64> {
    let text = fs::read_to_string(genome).unwrap();
    let gene = |line: &str| line.split_once(" = ")?.1.parse::<f64>().ok().filter(|gene| (0.0..1.0).contains(gene));
    text.lines().filter_map(gene).collect()
}

/// A number of an answer.
fn number(value: &Value) -> u64 {
    value.as_u64().unwrap()
}

#[test]
fn who_would_die_is_told_with_the_births_that_are_planned() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    answer(folder, &["pool", "new", "pool", "--seed", "3", "--species", "plant", "--limit", "4"]);
    answer(folder, &["breed", "pool", "--brood", "4"]);
    let old = ids(&shown(folder)["sheep"]);
    answer(folder, &["breed", "pool", "--brood", "2"]);
    // All but one are liked less than the others: nothing saves the four of the first brood.
    let mut sheep = ids(&shown(folder)["sheep"]);
    sheep.sort_by_key(|id| old.contains(id));
    fs::write(folder.join("report.json"), report("lobby", &sheep, 100, &[30, 0, 0, 0, 0, 0])).unwrap();
    answer(folder, &["votes", "pool", "--unit", "lobby", "report.json"]);
    let planned = answer(folder, &["breed", "pool", "--brood", "2", "--dry-run"]);
    let bred = answer(folder, &["breed", "pool", "--brood", "2"]);
    let died = |answer: &Value| -> BTreeSet<String> {
        answer["died"].as_array().unwrap().iter().map(|id| id.as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(died(&bred), old.into_iter().collect(), "{bred}");
    assert_eq!(died(&planned), died(&bred), "{planned}");
}

#[test]
fn nothing_is_born_if_a_sheet_cannot_be_written() {
    let folder = pool("2");
    let folder = folder.path();
    let before = files(&folder.join("pool"));
    for option in ["--sheet", "--refused"] {
        let said = dreams(folder, &["breed", "pool", "--brood", "1", option, "nowhere/sheet.png"]);
        assert_eq!(said.status.code(), Some(3), "{said:?}");
        assert!(String::from_utf8_lossy(&said.stderr).contains("cannot write `nowhere/sheet.png`"), "{said:?}");
        assert_eq!(before, files(&folder.join("pool")), "{option}");
    }
    answer(folder, &["breed", "pool", "--brood", "1", "--sheet", "sheet.png"]);
    assert!(fs::read(folder.join("sheet.png")).unwrap().starts_with(b"\x89PNG"));
}

#[test]
fn screening_strength_and_seed_are_as_asked() {
    let folder = pool("3");
    let folder = folder.path();
    let parent = ids(&shown(folder)["sheep"]).remove(0);
    let planned = |words: &[&str]| answer(folder, &[&["breed", "pool", "--dry-run", "--brood", "6"], words].concat());
    let candidates = |plan: &Value| -> Vec<u64> {
        plan["born"].as_array().unwrap().iter().map(|birth| number(&birth["candidates"])).collect()
    };
    for (asked, best_of) in [("5", 5), ("1", 1)] {
        let plan = planned(&["--screen", asked]);
        let screened = candidates(&plan).iter().filter(|count| **count == best_of).count();
        assert_eq!(screened, if best_of == 1 { 6 } else { 3 }, "half of the births: {plan}");
    }
    assert_ne!(planned(&["--seed", "8"])["seed"], planned(&[])["seed"]);
    assert_eq!(planned(&["--seed", "8"]), planned(&["--seed", "8"]));
    let before = genes(&folder.join(format!("pool/genomes/{parent}.plant")));
    let changed = ["1", "4"].map(|strength| {
        let copy = format!("pool-{strength}");
        programs::succeed(Command::new("cp").current_dir(folder).args(["-r", "pool", &copy]));
        let breed = ["breed", &copy, "--brood", "1", "--from", &parent, "--op", "genes", "--strength", strength];
        let child = ids(&answer(folder, &breed)["born"]).remove(0);
        let after = genes(&folder.join(format!("{copy}/genomes/{child}.plant")));
        after.iter().zip(&before).map(|(after, before)| (after - before).abs()).sum::<f64>()
    });
    assert!(changed[1] > changed[0] && changed[0] > 0.0, "{changed:?}");
    for (words, told) in [(["--screen", "0"], "1..=64"), (["--strength", "0"], "0"), (["--seed", "x"], "invalid digit")]
    {
        let said = dreams(folder, &[&["breed", "pool"][..], &words].concat());
        assert_eq!(said.status.code(), Some(2), "{said:?}");
        assert!(String::from_utf8_lossy(&said.stderr).contains(told), "{words:?}: {said:?}");
    }
}

#[test]
fn every_operator_is_listed_and_can_be_asked_for() {
    let folder = pool("3");
    let folder = folder.path();
    let parents = ids(&shown(folder)["sheep"]);
    let operators = answer(folder, &["breed", "pool", "--op", "list"]);
    let operators = operators.as_array().unwrap();
    let species: BTreeSet<&str> = operators.iter().map(|it| it["species"].as_str().unwrap()).collect();
    assert_eq!(species, BTreeSet::from(["agents", "expr", "flam3", "plant"]));
    for operator in operators.iter().filter(|it| it["species"] == "plant") {
        let from = parents[..number(&operator["parents"]) as usize].join(",");
        let name = operator["name"].as_str().unwrap();
        let plan = answer(folder, &["breed", "pool", "--dry-run", "--brood", "1", "--from", &from, "--op", name]);
        assert_eq!(plan["born"][0]["operator"], json!(name), "{plan}");
    }
}

#[test]
fn votes_are_read_of_folders_and_of_the_standard_input_and_one_that_is_refused_hides_no_other() {
    let folder = pool("2");
    let folder = folder.path();
    let sheep = ids(&shown(folder)["sheep"]);
    fs::create_dir(folder.join("reports")).unwrap();
    for (name, shown) in [("a.json", 10), ("b.json", 20), ("c.txt", 90)] {
        fs::write(folder.join("reports").join(name), report("lobby", &sheep, shown, &[3, 1])).unwrap();
    }
    let heard = answer(folder, &["votes", "pool", "--unit", "lobby", "reports"]);
    assert_eq!(heard["units"]["lobby"]["showings"], json!(40), "{heard}");
    // Two reports one after the other; the first is of nobody who is known.
    let both = report("stairs", &sheep, 30, &[3, 1]) + "\n" + &report("lobby", &sheep, 30, &[3, 1]);
    fs::write(folder.join("both.json"), both).unwrap();
    let mut votes = Command::new("sh");
    votes.current_dir(folder).args(["-c", "exec \"$0\" votes pool - --json < both.json"]).arg(programs::dreams());
    let said = programs::output(&mut votes);
    let heard = json(&said);
    assert_eq!((said.status.code(), &heard["units"]["lobby"]["showings"]), (Some(1), &json!(20)), "{heard}");
    assert_eq!(heard["refused"].as_array().unwrap().len(), 1, "{heard}");
}

#[test]
fn totals_may_grow_as_fast_as_the_shortest_loop_allows() {
    let folder = pool("2");
    let folder = folder.path();
    let sheep = ids(&shown(folder)["sheep"]);
    let days = std::time::SystemTime::UNIX_EPOCH.elapsed().unwrap().as_secs() / 86_400;
    // So many showings of half a minute as there are in the time since the ledger began, and two days.
    let most = (days - 20_782 + 2) * 86_400 / 30;
    let half = u32::try_from(most / 2).unwrap();
    fs::write(folder.join("possible.json"), report("lobby", &sheep, half - 10, &[1, 0])).unwrap();
    fs::write(folder.join("hasty.json"), report("lobby", &sheep, half + 2_900, &[1, 0])).unwrap();
    let votes = ["votes", "pool", "--unit", "lobby", "--loop", "30"];
    let said = dreams(folder, &[&votes[..], &["hasty.json"]].concat());
    assert_eq!(said.status.code(), Some(1));
    assert!(json(&said)["refused"][0]["why"].as_str().unwrap().contains("grow faster than showings can"), "{said:?}");
    assert_eq!(answer(folder, &[&votes[..], &["possible.json"]].concat())["refused"], json!([]));
    assert_eq!(answer(folder, &["votes", "pool", "hasty.json"])["refused"], json!([]), "of loops of four seconds");
}

#[test]
fn two_pools_are_merged_and_merged_again_nothing_is_new() {
    let folder = pool("2");
    let folder = folder.path();
    answer(folder, &["pool", "new", "other", "--seed", "4", "--species", "plant"]);
    let born = ids(&answer(folder, &["breed", "other", "--brood", "3"])["born"]);
    let before = files(&folder.join("pool"));
    let merge = ["pool", "merge", "pool", "other"];
    let planned = answer(folder, &[&merge[..], &["--dry-run"]].concat());
    assert_eq!((&planned["sheep"], &planned["changed"]), (&json!(born), &json!(false)));
    assert_eq!(before, files(&folder.join("pool")));
    assert_eq!(answer(folder, &merge)["sheep"], json!(born));
    assert_eq!(shown(folder)["living"], 5);
    assert_eq!(answer(folder, &["pool", "check", "pool"])["faults"], json!([]), "their genomes came, too");
    assert_eq!(answer(folder, &merge)["sheep"], json!([]));
    assert_eq!(answer(folder, &["pool", "show", "other"])["living"], 3, "the other pool stays as it is");
}

#[test]
fn a_unit_can_have_sheep_that_no_other_has() {
    let folder = pool("8");
    let folder = folder.path();
    let elect = |unit: &str, words: &[&str]| {
        let elect = ["elect", "pool", unit, "--for", unit, "--size", "160x90", "--fps", "10", "--write"];
        answer(folder, &[&elect[..], words].concat())
    };
    let reasons = |edition: &Value| {
        let sheep = edition["sheep"].as_array().unwrap();
        sheep.iter().filter(|sheep| sheep["why"] == "unique").count()
    };
    let hall = elect("hall", &["--sheep", "4", "--unique", "2"]);
    assert_eq!((hall["sheep"].as_array().unwrap().len(), reasons(&hall)), (4, 2), "{hall}");
    let stairs = elect("stairs", &["--sheep", "4", "--unique", "1"]);
    assert_eq!(reasons(&stairs), 1, "{stairs}");
    let [hall, stairs] = [hall, stairs].map(|edition| ids(&edition["sheep"]));
    assert!(hall[2..].iter().all(|id| !stairs.contains(id)), "{hall:?} {stairs:?}");
    assert!(stairs.last().is_some_and(|id| !hall.contains(id)), "{hall:?} {stairs:?}");
}

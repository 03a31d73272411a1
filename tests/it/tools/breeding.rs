//! `dreams pool`, `breed`, `votes`, `family` and `elect`: from random genomes to an elected flock.
//!
//! Owns the claims on whole runs of the program. The rules themselves are tried in `crates/breeding`.

use crate::syscall_faults::at_every_step;
use claims::programs::{self, json, output, succeed};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::Mutex;

/// `dreams WORDS... --json` in `folder`.
pub(crate) fn dreams(folder: &Path, words: &[&str]) -> Output {
    output(Command::new(programs::dreams()).current_dir(folder).args(words).arg("--json"))
}

/// Its answer; it must end with 0.
pub(crate) fn answer(folder: &Path, words: &[&str]) -> Value {
    let said = dreams(folder, words);
    assert_eq!(said.status.code(), Some(0), "{words:?}: {}", String::from_utf8_lossy(&said.stderr));
    json(&said)
}

/// The files of pools by the number of births: each is bred once, for it takes most of a second for each birth.
static POOLS: Mutex<BTreeMap<String, Files>> = Mutex::new(BTreeMap::new());

/// A folder with the pool `pool`, which breeds plants, and has so many of them.
pub(crate) fn pool(births: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut pools = POOLS.lock().unwrap();
    if let Some(files) = pools.get(births) {
        for (path, bytes) in files {
            let path = folder.path().join("pool").join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, bytes).unwrap();
        }
    } else {
        answer(folder.path(), &["pool", "new", "pool", "--seed", "3", "--species", "plant"]);
        answer(folder.path(), &["breed", "pool", "--brood", births]);
        pools.insert(births.to_owned(), files(&folder.path().join("pool")));
    }
    folder
}

/// A copy of the first genome of the pool, as a file of the artist's own.
fn own_genome(folder: &Path) -> String {
    let first = ids(&answer(folder, &["pool", "show", "pool", "--all"])["sheep"]).into_iter().min().unwrap();
    fs::copy(folder.join(format!("pool/genomes/{first}.plant")), folder.join("own.plant")).unwrap();
    "own.plant".to_owned()
}

/// How many genomes wait to be born, and how many sheep were brought in.
fn brought_in(folder: &Path) -> [usize; 2] {
    let shown = answer(folder, &["pool", "show", "pool"]);
    let imports = shown["sheep"].as_array().unwrap().iter().filter(|sheep| sheep["operator"] == "import").count();
    [shown["waiting"].as_u64().unwrap() as usize, imports]
}

/// The ids of a list of sheep in an answer.
pub(crate) fn ids(list: &Value) -> Vec<String> {
    list.as_array().unwrap().iter().map(|sheep| sheep["id"].as_str().unwrap().to_owned()).collect()
}

/// Every file of a folder, by its path in there.
pub(crate) type Files = BTreeMap<PathBuf, Vec<u8>>;

/// Reads every file below `folder`.
pub(crate) fn files(folder: &Path) -> Files {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if entry.is_dir() {
            found.extend(
                files(&entry)
                    .into_iter()
                    .map(|(path, bytes)| (Path::new(entry.file_name().unwrap()).join(path), bytes)),
            );
        } else {
            found.insert(entry.file_name().unwrap().into(), fs::read(&entry).unwrap());
        }
    }
    found
}

/// A status report of `unit` on the first sheep of `sheep`, each shown so often.
pub(crate) fn report(unit: &str, sheep: &[String], shown: u32, up: &[u32]) -> String {
    let totals =
        sheep.iter().zip(up).map(|(id, up)| (id.clone(), json!({"shown": shown, "up": up, "down": 0, "near_s": 0})));
    let sheep: serde_json::Map<String, Value> = totals.collect();
    json!({"unit": unit, "status": null, "votes": {"ledger": "f3a9c2d17b60e845", "since_day": 20_782, "sheep": sheep}})
        .to_string()
}

#[test]
fn the_same_seed_makes_the_same_pool_on_any_number_of_threads() {
    let pools = ["1", "2", "7"].map(|threads| {
        let folder = tempfile::tempdir().unwrap();
        answer(folder.path(), &["pool", "new", "pool", "--seed", "3", "--species", "plant"]);
        for births in ["4", "3"] {
            answer(folder.path(), &["breed", "pool", "--brood", births, "--threads", threads]);
            let own = own_genome(folder.path());
            answer(folder.path(), &["pool", "add", "pool", &own, "--as-strangers"]);
        }
        files(&folder.path().join("pool"))
    });
    assert!(pools[0].len() > 7 && pools[0] == pools[1] && pools[0] == pools[2]);
}

#[test]
fn a_brood_of_named_parents_tells_its_family_and_its_genomes_do_too() {
    let folder = pool("3");
    let folder = folder.path();
    let parents = ids(&answer(folder, &["pool", "show", "pool"])["sheep"]);
    let from = parents[..2].join(",");
    let brood = answer(folder, &["breed", "pool", "--brood", "2", "--from", &from, "--op", "either"]);
    let children = ids(&brood["born"]);
    assert_eq!(children.len(), 2, "{brood}");
    let family = answer(folder, &["family", "pool", &children[0]]);
    assert_eq!(family["sheep"]["operator"], "either");
    let ancestors = ids(&family["ancestors"]);
    assert!(parents[..2].iter().all(|parent| ancestors.contains(parent)), "{family}");
    let genome = fs::read_to_string(folder.join(format!("pool/genomes/{}.plant", children[0]))).unwrap();
    assert!(parents[..2].iter().all(|parent| genome.contains(parent)), "{genome}");
    assert_eq!(ids(&answer(folder, &["family", "pool", &parents[0]])["children"]), children);
    // Ids can be written without the pool's name.
    let (short, _) = children[0].split_once('-').unwrap();
    assert_eq!(answer(folder, &["family", "pool", short])["sheep"]["id"], json!(children[0]));
    assert_eq!(answer(folder, &["pool", "check", "pool"])["faults"], json!([]));
}

#[test]
fn what_is_planned_changes_nothing_and_what_is_wrong_is_told_with_both_values() {
    let folder = pool("3");
    let folder = folder.path();
    let before = files(&folder.join("pool"));
    let planned = answer(folder, &["breed", "pool", "--dry-run"]);
    assert_eq!((planned["born"].as_array().unwrap().len(), &planned["dry_run"]), (20, &json!(true)));
    for (words, exit, told) in [
        (&["breed", "pool", "--op", "sex"][..], 2, "no operator `sex` makes a child of 1 plant"),
        (&["breed", "pool", "--from", "9.00009"], 2, "no sheep `9.00009` in pool"),
        (&["family", "pool", "x"], 2, "no sheep `x` in pool"),
        (&["pool", "new", "pool"], 1, "`pool` is a pool already"),
        (&["breed", "pool", "--from", "a,b,c"], 2, "wanted one id, or two with a comma between them, found 3"),
        (&["pool", "show", "nowhere"], 3, "cannot read `nowhere/pool.toml`"),
        (&["pool", "mark", "pool", "keep", "1.2"], 2, "no sheep `1.2` in pool"),
        (&["votes", "pool", "nowhere.json"], 3, "cannot read `nowhere.json`"),
    ] {
        let said = dreams(folder, words);
        let error = String::from_utf8_lossy(&said.stderr);
        assert_eq!(said.status.code(), Some(exit), "{words:?}: {error}");
        assert!(error.contains(told), "{words:?}: {error}");
    }
    let genome = programs::repository().join("flock-tools/demo/genomes/orchid.flam3");
    let said = dreams(folder, &["pool", "add", "pool", genome.to_str().unwrap()]);
    assert!(String::from_utf8_lossy(&said.stderr).contains("is a .flam3, the pool breeds plant"), "{said:?}");
    assert_eq!(before, files(&folder.join("pool")));
    // A torn last line is what a power cut leaves; anything else is named.
    let ledger = folder.join("pool/ledger.jsonl");
    let text = fs::read_to_string(&ledger).unwrap();
    fs::write(&ledger, format!("{text}{{\"number\":9")).unwrap();
    assert_eq!(answer(folder, &["pool", "show", "pool"])["living"], 3);
    fs::write(&ledger, text.replacen("\"born\"", "\"burn\"", 1)).unwrap();
    let said = dreams(folder, &["pool", "show", "pool"]);
    assert_eq!(said.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&said.stderr).contains("line 2 of ledger"), "{said:?}");
}

#[test]
fn a_brood_that_is_killed_at_any_write_loses_nothing_that_was_told() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    let ledger = folder.join("pool/ledger.jsonl");
    // Genomes that are drawn in no time, for the brood is bred again after each fault.
    let genomes = ["3", "5", "7"].map(|waves| {
        let name = format!("{waves}.expr");
        let text = format!("(expression 1 (picture (+ 0.5 (* 0.3 (sin (+ (* {waves} x) (wave 1 0)))))))");
        fs::write(folder.join(&name), text).unwrap();
        name
    });
    answer(folder, &["pool", "new", "pool", "--seed", "3", "--species", "expr"]);
    answer(folder, &["pool", "add", "pool", &genomes[0]]);
    answer(folder, &["pool", "add", "pool", &genomes[1], &genomes[2], "--as-strangers"]);
    let before = fs::read_to_string(&ledger).unwrap();
    succeed(Command::new("cp").current_dir(folder).args(["-r", "pool", "first"]));
    let prepare = || {
        fs::remove_dir_all(folder.join("pool")).unwrap();
        succeed(Command::new("cp").current_dir(folder).args(["-r", "first", "pool"]));
        let mut breeding = Command::new(programs::dreams());
        breeding.args(["breed", folder.join("pool").to_str().unwrap(), "--brood", "2", "--threads", "1"]);
        breeding
    };
    let faults = at_every_step(&["rename", "fsync", "fdatasync", "write"], &folder.join("calls"), prepare, |step| {
        assert!(fs::read_to_string(&ledger).unwrap().starts_with(&before), "{step}");
        assert_eq!(answer(folder, &["pool", "check", "pool"])["faults"], json!([]), "{step}");
        // A genome that waits is born, or waits on.
        assert_eq!(brought_in(folder).iter().sum::<usize>(), 3, "{step}");
    });
    assert!(faults >= 8, "{faults} faults");
    assert_eq!(answer(folder, &["breed", "pool", "--brood", "2"])["missing"], 0);
    assert_eq!(brought_in(folder), [0, 3]);
}

#[test]
fn genomes_that_wait_are_the_first_strangers_of_the_next_broods() {
    let folder = pool("2");
    let folder = folder.path();
    let own = own_genome(folder);
    let add = ["pool", "add", "pool", &own, &own, "--as-strangers"];
    answer(folder, &[&add[..], &["--dry-run"]].concat());
    assert_eq!(brought_in(folder), [0, 0]);
    answer(folder, &add);
    assert_eq!(brought_in(folder), [2, 0]);
    assert_eq!(answer(folder, &["pool", "show", "pool"])["living"], 2);
    // A child of named parents is no stranger.
    let parent = ids(&answer(folder, &["pool", "show", "pool"])["sheep"]).remove(0);
    let planned = |words: &[&str]| {
        let brood = answer(folder, &[&["breed", "pool", "--dry-run", "--brood", "3"], words].concat());
        let operators = brood["born"].as_array().unwrap().iter().map(|sheep| sheep["operator"].clone());
        operators.collect::<Vec<_>>()
    };
    assert_eq!(planned(&["--from", &parent]), ["mutation", "mutation", "mutation"]);
    assert_eq!(planned(&[]), ["import", "import", "chance"]);
    for left in [1, 0] {
        let born = answer(folder, &["breed", "pool", "--brood", "1"])["born"][0].clone();
        assert_eq!((&born["operator"], &born["parents"]), (&json!("import"), &json!([])), "{born}");
        assert_eq!(brought_in(folder), [left, 2 - left]);
        let genome = folder.join(format!("pool/genomes/{}.plant", born["id"].as_str().unwrap()));
        assert!(fs::read_to_string(genome).unwrap().contains("operator = \"import\""));
    }
    assert_eq!(planned(&[]), ["chance", "chance", "chance"]);
    assert_eq!(answer(folder, &["pool", "check", "pool"])["faults"], json!([]));
}

#[test]
fn reports_in_any_order_lost_or_repeated_give_the_same_ratings_and_hostile_ones_change_nothing() {
    let folder = pool("4");
    let folder = folder.path();
    let sheep = ids(&answer(folder, &["pool", "show", "pool"])["sheep"]);
    let reports = [[1, 0, 0, 0], [3, 0, 1, 0], [6, 0, 1, 2]];
    for (at, up) in reports.iter().enumerate() {
        fs::write(folder.join(format!("{at}.json")), report("lobby", &sheep, 10 * (at as u32 + 1), up)).unwrap();
    }
    let ratings = |pool: &str| {
        let shown = answer(folder, &["pool", "show", pool]);
        shown["sheep"].as_array().unwrap().iter().map(|it| (it["id"].clone(), it["rating"].clone())).collect::<Vec<_>>()
    };
    succeed(Command::new("cp").current_dir(folder).args(["-r", "pool", "other"]));
    let unknown = dreams(folder, &["votes", "pool", "0.json"]);
    assert_eq!(unknown.status.code(), Some(1));
    assert!(
        json(&unknown)["refused"][0]["why"].as_str().unwrap().contains("`lobby` is not one of those that are known")
    );
    for files in [&["0.json"][..], &["1.json"], &["2.json"]] {
        answer(folder, &[&["votes", "pool", "--unit", "lobby"], files].concat());
    }
    answer(folder, &["votes", "other", "--unit", "lobby", "2.json", "0.json", "2.json"]);
    let rated = ratings("pool");
    assert_eq!((rated.clone(), &rated[0].0), (ratings("other"), &json!(sheep[0])), "the first is liked most");
    // A report without votes is no error: a unit need not send them. One that is too long is not cut, but refused.
    fs::write(folder.join("none.json"), "{\"unit\":\"lobby\",\"status\":{}}").unwrap();
    assert_eq!(answer(folder, &["votes", "pool", "none.json"])["refused"], json!([]));
    fs::write(folder.join("long.json"), " ".repeat(4 << 20) + &report("lobby", &sheep, 40, &[9; 4])).unwrap();
    let long = json(&dreams(folder, &["votes", "pool", "long.json"]));
    assert!(long["refused"][0]["why"].as_str().unwrap().contains("more than 4194304 bytes"), "{long}");
    let before = files(&folder.join("pool"));
    let hostile = [
        report("lobby", &sheep, u32::MAX, &[9; 4]),
        report("lobby", &sheep, 20, &[1; 4]).replace("20782", "99999"),
        report("lobby", &sheep, 20, &[1; 4]).replace("\"up\":1", "\"up\":-1"),
        // Doubled members: which one would count?
        report("lobby", &sheep, 40, &[9; 4]).replacen("\"up\":", "\"up\":1,\"up\":", 1),
        report("lobby", &sheep, 40, &[9; 4]).replacen("\"votes\":", "\"votes\":null,\"votes\":", 1),
        report("lobby", &sheep, 40, &[9; 4]).replacen("\"sheep\":{", "\"sheep\":{},\"sheep\":{", 1),
        report("lobby", &sheep, 40, &[9; 4]).replacen("\"unit\":", "\"unit\":\"stairs\",\"unit\":", 1),
        report("Lobby/../x", &sheep, 20, &[1; 4]),
        "{".to_owned(),
        String::new(),
    ];
    for text in hostile {
        fs::write(folder.join("hostile.json"), &text).unwrap();
        let said = dreams(folder, &["votes", "pool", "hostile.json"]);
        assert_eq!(said.status.code(), Some(1), "{text}: {said:?}");
    }
    assert_eq!(before, files(&folder.join("pool")));
}

#[test]
fn an_elected_flock_has_no_fault_and_newcomers_are_linked_when_it_is_elected_again() {
    let folder = pool("8");
    let folder = folder.path();
    let elect = ["elect", "pool", "edition", "--sheep", "6", "--for", "lobby", "--size", "160x90", "--fps", "10"];
    let proposed = answer(folder, &elect);
    assert!(!folder.join("edition").exists() && proposed["changed"] == false);
    let frames = proposed["frames"].as_u64().unwrap();
    let sheep = proposed["sheep"].as_array().unwrap().len() as u64;
    assert_eq!(frames, sheep * 768 + 2 * sheep * 384, "{proposed}");
    assert!(proposed["cpu_hours"].as_f64().unwrap() > 0.0 && proposed["gigabytes"].as_f64().unwrap() > 0.0);
    let written = answer(folder, &[&elect[..], &["--write"]].concat());
    // All are shown, as the graph alone tells: nothing is rendered yet.
    let shares = answer(folder, &["share", "edition"]);
    assert_eq!((shares["sheep"].as_array().unwrap().len() as u64, &shares["faults"]), (sheep, &json!([])), "{shares}");
    assert_eq!(ids(&written["sheep"]), ids(&proposed["sheep"]));
    // One that is rejected leaves, a newcomer that is kept comes in.
    let gone = &ids(&written["sheep"])[0];
    answer(folder, &["pool", "mark", "pool", "reject", gone]);
    let born = ids(&answer(folder, &["breed", "pool", "--brood", "2"])["born"]);
    answer(folder, &["pool", "mark", "pool", "keep", &born[0]]);
    let again = answer(folder, &[&elect[..], &["--write"]].concat());
    assert_eq!(again["left"].as_array().unwrap().first(), Some(&json!(gone)), "{again}");
    assert!(ids(&again["sheep"]).contains(&born[0]), "{again}");
    let manifest = fs::read_to_string(folder.join("edition/flock.toml")).unwrap();
    assert!(!manifest.contains(gone.as_str()) && manifest.contains(&born[0]), "{manifest}");
    // Nobody is left without a way on, although transitions went with the one that left.
    let shares = answer(folder, &["share", "edition"]);
    assert_eq!(
        (shares["faults"].clone(), shares["sheep"].as_array().unwrap().len()),
        (json!([]), ids(&again["sheep"]).len())
    );
    let into = again["transitions"].as_array().unwrap().iter().filter(|pair| pair[1] == json!(born[0])).count();
    assert!(into >= 2, "{again}");
}

#[test]
fn a_licence_that_forbids_sale_is_passed_on_and_not_bred_from_where_only_ours_are() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    answer(folder, &["pool", "new", "any", "--seed", "3", "--species", "plant"]);
    answer(folder, &["breed", "any", "--brood", "2"]);
    let shown = answer(folder, &["pool", "show", "any"]);
    assert_eq!(shown["sheep"][0]["licence"], "LicenseRef-ours", "what is made here by chance is ours: {shown}");
    let [stranger, other] = [0, 1].map(|at| ids(&shown["sheep"])[at].clone());
    let text = fs::read_to_string(folder.join(format!("any/genomes/{other}.plant"))).unwrap();
    fs::write(folder.join("nc.plant"), text.replace("LicenseRef-ours", "CC-BY-NC-4.0")).unwrap();
    let added = answer(folder, &["pool", "add", "any", "nc.plant"])["sheep"][0].as_str().unwrap().to_owned();
    let child = answer(folder, &["breed", "any", "--brood", "1", "--from", &format!("{stranger},{added}")]);
    let child = ids(&child["born"]).remove(0);
    let licence = &answer(folder, &["family", "any", &child])["sheep"]["licence"];
    assert_eq!(licence, "CC-BY-NC-4.0 AND LicenseRef-ours");
    answer(folder, &["pool", "new", "ours", "--ours", "--species", "plant"]);
    let added = answer(folder, &["pool", "add", "ours", "nc.plant"])["sheep"][0].as_str().unwrap().to_owned();
    let said = dreams(folder, &["breed", "ours", "--from", &added]);
    assert_eq!(said.status.code(), Some(2));
    assert!(
        String::from_utf8_lossy(&said.stderr).contains("is under `CC-BY-NC-4.0`, and the pool breeds only"),
        "{said:?}"
    );
}

#[test]
fn genomes_that_are_brought_in_are_no_brood_and_who_is_taken_back_from_the_dead_lives() {
    let folder = pool("3");
    let folder = folder.path();
    let first = ids(&answer(folder, &["pool", "show", "pool"])["sheep"]).remove(0);
    fs::copy(folder.join(format!("pool/genomes/{first}.plant")), folder.join("own.plant")).unwrap();
    let before = answer(folder, &["pool", "show", "pool"])["broods"].clone();
    answer(folder, &["pool", "add", "pool", "own.plant"]);
    let after = answer(folder, &["pool", "show", "pool"]);
    assert_eq!((&after["broods"], &after["living"]), (&before, &json!(4)));
    answer(folder, &["pool", "mark", "pool", "reject", &first]);
    assert_eq!(answer(folder, &["pool", "show", "pool"])["living"], 3);
    answer(folder, &["pool", "mark", "pool", "none", &first]);
    assert_eq!(answer(folder, &["pool", "show", "pool"])["living"], 4);
    // A pool that has lost a genome is not merged in part.
    answer(folder, &["pool", "new", "other", "--species", "plant"]);
    fs::remove_file(folder.join(format!("pool/genomes/{first}.plant"))).unwrap();
    let said = dreams(folder, &["pool", "merge", "other", "pool"]);
    assert_eq!(said.status.code(), Some(3));
    assert!(String::from_utf8_lossy(&said.stderr).contains(&format!("the genome of sheep `{first}` is missing")));
    assert_eq!(answer(folder, &["pool", "show", "other"])["living"], 0);
}

#[test]
fn what_no_brood_takes_is_named_by_a_look_and_drawn_with_its_reasons() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for (name, motion) in [("still", "0"), ("moving", "(wave 1 0)")] {
        let text = format!("(expression 1 (picture (+ 0.5 (* 0.3 (sin (+ (* 5 x) {motion}))))))");
        fs::write(folder.join(format!("{name}.expr")), text).unwrap();
    }
    answer(folder, &["pool", "new", "pool", "--seed", "3", "--species", "expr"]);
    let added = answer(folder, &["pool", "add", "pool", "still.expr"]);
    assert_eq!(added["faults"], json!(["`still.expr` is still"]), "it is taken all the same");
    assert_eq!(answer(folder, &["pool", "check", "pool"])["faults"], json!([]));
    let still = added["sheep"][0].as_str().unwrap();
    let looked = dreams(folder, &["pool", "check", "pool", "--look"]);
    assert_eq!((looked.status.code(), &json(&looked)["faults"]), (Some(1), &json!([format!("{still} is still")])));
    // In a pool whose sheep are all alike, whatever is too like them is refused.
    answer(folder, &["pool", "new", "alike", "--seed", "3", "--species", "expr"]);
    let added = answer(folder, &[&["pool", "add", "alike"][..], &["moving.expr"; 8]].concat());
    let parent = added["sheep"][0].as_str().unwrap();
    let words = ["breed", "alike", "--brood", "1", "--op", "number", "--from", parent, "--refused", "refused.png"];
    let brood = json(&dreams(folder, &words));
    assert_eq!((&brood["missing"], &brood["refused"]), (&json!(1), &json!({"clone": 20})), "{brood}");
    let png = fs::read(folder.join("refused.png")).unwrap();
    assert!(png.starts_with(b"\x89PNG"));
    // Four rows of five pictures, each with a line below it, and the edge.
    assert_eq!(u32::from_be_bytes(png[20..24].try_into().unwrap()), 4 * (135 + 12 + 8) + 8);
}

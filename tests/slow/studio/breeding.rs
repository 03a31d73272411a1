//! Broods on the page: a pool that begins, crossings that there are not, and the dead as parents.
//!
//! Owns these claims. That an accepted sheep has its true parents, a test beside the code claims for every species.

use claims::programs::{self, succeed};
use claims::studio::browser::Browser;
use claims::studio::page::{DESK, Page};
use claims::studio::running::Studio;
use claims::studio::sheep::{demo, many, quick};
use serde_json::{Value, json};
use std::fs;
use std::io::Write as _;
use std::path::Path;
use std::process::Command;

/// A page on the Breed view of the studio.
fn breed(studio: &Studio, params: &str) -> Page {
    let page = Page::open(&Browser::start(), &studio.address(), DESK);
    page.until("the studio is open", "document.body.dataset.view === 'wall'");
    page.ask(&format!("location.hash = '#/breed{params}'"));
    page.until("Breed is drawn", "document.querySelector('.view.breed')?.dataset.state === 'ready'");
    page
}

/// What finds the cell of a sheep.
fn cell(sheep: &str) -> String {
    format!(".view.breed .kid[data-sheep='{sheep}']")
}

/// Waits until the pool has so many sheep; returns their parents, by their ids.
fn pool(studio: &Studio, sheep: usize) -> Vec<(Value, Value)> {
    let mut found = Vec::new();
    claims::wait::until(&format!("{sheep} sheep are in the pool"), 300, || {
        let mut state = studio.get("/api/state");
        let all = state["candidates"].as_array_mut().expect("a list").drain(..);
        found = all.map(|mut one| (one["id"].take(), one["parents"].take())).collect();
        found.len() >= sheep
    });
    assert_eq!(found.len(), sheep);
    found
}

#[test]
fn the_pointer_begins_a_pool_and_a_second_child_of_the_same_parent_brings_it_in_no_second_time() {
    let flock = many(5);
    let studio = Studio::of(flock.path());
    let page = breed(&studio, "");
    page.click(&cell("s000"));
    // The rail has a link of the same name.
    page.click(".view.breed .bar .strong");
    for (child, sheep) in [("b0001-01", 2), ("b0001-02", 3)] {
        let there = format!("document.querySelector(\"{} .waits\")?.textContent === ''", cell(child));
        page.until_within(&format!("`{child}` is there"), 300, &there);
        page.click(&cell(child));
        page.click_named("Into the pool");
        let pool = pool(&studio, sheep);
        let [founders, children]: [Vec<_>; 2] = [true, false]
            .map(|is_founder| pool.iter().filter(|(_, parents)| (*parents == json!([])) == is_founder).collect());
        let [(founder, _)] = founders[..] else { panic!("{pool:?}") };
        assert!(children.iter().all(|(_, parents)| *parents == json!([founder])), "{pool:?}");
        page.click(&cell(child));
    }
    assert_eq!(json!(page.complaints()), json!([]));
}

#[test]
fn who_crosses_sheep_of_two_species_is_told_that_they_do_not_cross() {
    let flock = demo();
    let studio = Studio::of(flock.path());
    let page = breed(&studio, "");
    let middle = |sheep: &str| page.middle(&format!("document.querySelector(\"{}\")", cell(sheep)));
    page.drag(middle("aurora"), middle("bower"));
    let told = "expression and flame do not cross: each child is a mutant of one parent";
    let said = format!("document.querySelector('#said').textContent === '{told}'");
    page.until("it is said", &said);
    page.until(
        "it stands above the brood",
        &format!("document.querySelector('.view.breed .heading').textContent.includes('{told}')"),
    );
    // Two of one species cross, and nothing is said.
    page.press("s");
    // By the page itself: what is said above the sheep moves them, also between a look and a click of a slow machine.
    let choose = |sheep: &str| page.ask(&format!("document.querySelector(\"{}\").click()", cell(sheep)));
    choose("aurora");
    choose("dahlia");
    page.until("they can be crossed", "document.querySelector('.view.breed .strong').textContent === 'Cross 2'");
    choose("bower");
    page.until("they cannot", "document.querySelector('.view.breed .strong').textContent === 'Breed 3'");
    assert_eq!(json!(page.complaints()), json!([]));
}

#[test]
fn the_dead_may_be_parents_and_who_is_nobody_is_named() {
    let desk = tempfile::tempdir().unwrap();
    let pool = desk.path().join("pool");
    let dead = pool_with_a_death(desk.path());
    let flock = many(5);
    let studio = Studio::with(flock.path(), &["--pool", pool.to_str().unwrap()]);
    let page = breed(&studio, &format!("?from={dead},nobody"));
    page.until("nobody is named", "document.querySelector('#said').textContent.includes('breed from nobody')");
    let first = format!("document.querySelector(\"{}\")", cell(&dead));
    page.until("the dead one is chosen", &format!("{first}?.getAttribute('aria-pressed') === 'true'"));
    assert!(page.ask(&format!("{first}.getAttribute('aria-label')")).as_str().unwrap().contains("dead"));
    page.press("b");
    page.until("there is a brood", "document.querySelector('.view.breed h2').textContent.startsWith('Brood 1')");
    assert_eq!(studio.get("/api/broods")["broods"][0]["parents"], json!([dead]));
    // Whoever starts over begins with strangers.
    page.press("r");
    page.until(
        "there are strangers",
        "document.querySelector('.view.breed h2').textContent === 'Brood 2 of 2: strangers'",
    );
    assert_eq!(json!(page.complaints()), json!([]));
}

/// Makes the pool `pool` in `folder`, of two sheep; returns the id of the dead one.
fn pool_with_a_death(folder: &Path) -> String {
    let pool = |words: &[&str]| -> Value {
        let said = succeed(Command::new(programs::dreams()).arg("pool").args(words).arg("--json").current_dir(folder));
        serde_json::from_slice(&said).unwrap()
    };
    pool(&["new", "pool", "--seed", "3", "--species", "expr"]);
    for kind in 0..2 {
        fs::write(folder.join(format!("g{kind}.expr")), quick(kind)).unwrap();
    }
    let added = pool(&["add", "pool", "g0.expr", "g1.expr"]);
    let dead = added["sheep"][0].as_str().unwrap().to_owned();
    // As `dreams breed` writes it when a sheep has lived long enough.
    let ledger = folder.join("pool/ledger.jsonl");
    let text = fs::read_to_string(&ledger).unwrap();
    let last: Value = serde_json::from_str(text.lines().last().unwrap()).unwrap();
    let number = last["number"].as_u64().unwrap() + 1;
    let death = json!({ "number": number, "pool": last["pool"], "day": last["day"], "event": "died", "id": dead });
    let mut ledger = fs::OpenOptions::new().append(true).open(&ledger).unwrap();
    writeln!(ledger, "{death}").unwrap();
    dead
}

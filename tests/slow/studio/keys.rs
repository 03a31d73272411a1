//! A key hits what is focused, and the next key the next.
//!
//! Owns the claims on culling by keys: where the focus is after each, under filters and at the end, and that nothing is
//! marked twice or deleted.

use claims::studio::browser::Browser;
use claims::studio::page::{DESK, Page};
use claims::studio::running::Studio;
use claims::studio::sheep::ring;
use serde_json::{Value, json};

/// A page on the Wall of a flock of `sheep`, and what keeps both alive.
fn wall(sheep: usize) -> (tempfile::TempDir, Studio, Page) {
    let flock = ring("meadow", sheep, 1);
    let studio = Studio::of(flock.path());
    let page = Page::open(&Browser::start(), &studio.address(), DESK);
    page.until("the Wall is drawn", "document.querySelector('.view.wall')?.dataset.state === 'ready' && document.querySelector('[data-sheep][aria-selected=true]')");
    (flock, studio, page)
}

/// The sheep that has the focus of the keyboard.
fn focused(page: &Page) -> String {
    let told = page.ask("document.activeElement?.closest('[data-sheep]')?.dataset.sheep ?? ''");
    told.as_str().expect("an id is a text").to_owned()
}

/// The marks as the program has them, once all that was asked for is answered.
fn marks(studio: &Studio, page: &Page, count: usize) -> Vec<(String, Value)> {
    let mut found = Vec::new();
    claims::wait::until(&format!("{count} sheep are marked"), 60, || {
        let state = studio.get("/api/state");
        let sheep = state["sheep"].as_array().expect("a list");
        let marked = sheep.iter().filter(|sheep| sheep["mark"] != "none");
        found = marked.map(|sheep| (sheep["id"].as_str().unwrap().to_owned(), sheep["mark"].clone())).collect();
        found.len() >= count
    });
    assert_eq!(json!(page.complaints()), json!([]));
    found
}

#[test]
fn a_key_hits_what_is_focused_and_the_next_key_the_next() {
    let (_flock, studio, page) = wall(40);
    let order: Vec<String> = serde_json::from_value(
        page.ask("[...document.querySelectorAll('[data-sheep]')].map(one => one.dataset.sheep)"),
    )
    .unwrap();
    page.press("Home");
    assert_eq!(focused(&page), order[0]);
    let mut expected = Vec::new();
    for (at, sheep) in order.iter().take(20).enumerate() {
        assert_eq!(&focused(&page), sheep, "before key {at}");
        let (key, mark) = if at % 3 == 0 { ("k", "kept") } else { ("x", "rejected") };
        page.press(key);
        expected.push((sheep.clone(), json!(mark)));
    }
    let mut told = marks(&studio, &page, 20);
    told.sort_by(|a, b| a.0.cmp(&b.0));
    expected.sort_by(|a, b| a.0.cmp(&b.0));
    assert_eq!(told, expected);
    // Without Shift the focus goes on; with it, it stays.
    let before = focused(&page);
    page.press("Shift+K");
    assert_eq!(focused(&page), before);
}

#[test]
fn digits_rate_what_is_focused_and_stay_there() {
    let (_flock, studio, page) = wall(6);
    page.press("Home");
    let first = focused(&page);
    let rated = |rating: u64| {
        claims::wait::until(&format!("`{first}` is rated {rating}"), 60, || {
            let state = studio.get("/api/state");
            let sheep = state["sheep"].as_array().expect("a list");
            let others = sheep.iter().filter(|sheep| sheep["id"] != first.as_str());
            assert!(others.map(|sheep| &sheep["rating"]).all(|rating| rating == 0), "{state}");
            sheep.iter().any(|sheep| sheep["id"] == first.as_str() && sheep["rating"] == rating)
        });
    };
    for key in ["4", "1", "0", "5"] {
        page.press(key);
        assert_eq!(focused(&page), first);
        rated(key.parse().unwrap());
    }
    let said = page.ask("document.activeElement.getAttribute('aria-label')");
    assert!(said.as_str().unwrap().contains("rated 5"), "{said}");
}

#[test]
fn who_takes_all_sheep_out_is_asked_whether_none_shall_be_left() {
    let (_flock, studio, page) = wall(6);
    page.press("Control+a");
    page.press("Delete");
    page.until("it is asked", "document.querySelector('dialog[open] h2')");
    assert_eq!(page.ask("document.querySelector('dialog[open] h2').textContent"), "No sheep would be left");
    page.press("Escape");
    page.until("the question is gone", "!document.querySelector('dialog[open]')");
    assert_eq!(studio.get("/api/state")["sheep"].as_array().map(Vec::len), Some(6));
}

#[test]
fn keys_that_come_faster_than_answers_hit_one_sheep_each() {
    let (_flock, studio, page) = wall(40);
    page.press("Home");
    // All at once, in one turn of the page: no answer of the program comes between.
    page.ask("for (let at = 0; at < 25; at++) document.activeElement.dispatchEvent(new KeyboardEvent('keydown', { key: 'x', bubbles: true, cancelable: true }))");
    let told = marks(&studio, &page, 25);
    assert_eq!(told.len(), 25, "{told:?}");
    assert!(told.iter().all(|(_, mark)| mark == "rejected"));
}

#[test]
fn under_a_filter_the_next_sheep_has_the_focus_and_at_the_end_it_stays() {
    let (_flock, studio, page) = wall(6);
    page.ask("location.hash = '#/wall?mark=none'");
    page.until("the filter is on", "document.querySelectorAll('[data-sheep]').length === 6");
    page.press("Home");
    for left in (1..6).rev() {
        let before = focused(&page);
        page.press("x");
        page.until(
            &format!("{left} are left"),
            &format!("document.querySelectorAll('[data-sheep]').length === {left}"),
        );
        let after = focused(&page);
        assert!(after != before && !after.is_empty(), "after `{before}` the focus is on `{after}`");
    }
    page.press("x");
    assert_eq!(marks(&studio, &page, 6).len(), 6);
    page.until("the Wall says that no sheep fits", "document.body.innerText.includes('No sheep fits')");
    // Whoever has come to the end can go on: undo brings the last one back, with the focus.
    page.press("z");
    page.until("the last one is back", "document.querySelectorAll('[data-sheep]').length === 1");
    assert_eq!(studio.get("/api/state")["sheep"].as_array().map(Vec::len), Some(6), "nothing was deleted");
}

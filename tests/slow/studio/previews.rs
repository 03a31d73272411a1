//! Previews of transitions, of those that exist and of those that do not.
//!
//! Owns the claims that a link is seen before it is made, that species are no bar, and that a preview plays while it is
//! drawn.

use claims::studio::browser::Browser;
use claims::studio::page::{DESK, Page};
use claims::studio::running::Studio;
use claims::studio::sheep::demo;
use serde_json::{Value, json};
use tempfile::TempDir;

/// A page on the graph of the demo.
fn graph(params: &str) -> (TempDir, Studio, Page) {
    let flock = demo();
    let studio = Studio::of(flock.path());
    let page = Page::open(&Browser::start(), &studio.address(), DESK);
    page.until("the studio is open", "document.body.dataset.view === 'wall'");
    page.ask(&format!("location.hash = '#/graph{params}'"));
    page.until("the graph is drawn", "document.querySelector('.view.graph')?.dataset.state === 'ready'");
    (flock, studio, page)
}

/// The state of the job that draws the last moving preview.
fn drawing(studio: &Studio) -> Value {
    let mut jobs = studio.get("/api/jobs");
    let all = jobs["jobs"].as_array_mut().expect("a list");
    all.drain(..).rfind(|job| job["kind"] == "moving").expect("there is one")["state"].take()
}

#[test]
fn a_link_between_two_species_is_seen_before_it_is_made_and_plays_while_it_is_drawn() {
    let (_flock, studio, page) = graph("");
    let before = studio.manifest();
    let disc = |sheep: &str| page.middle(&format!("document.querySelector('.view.graph [data-sheep={sheep}]')"));
    let (from, to) = (disc("aurora"), disc("bower"));
    let long = f64::hypot(to.0 - from.0, to.1 - from.1);
    let radius =
        page.ask("document.querySelector('.view.graph [data-sheep=aurora]').getBoundingClientRect().width / 2");
    let part = 0.95 * radius.as_f64().unwrap() / long;
    let rim = (from.0 + (to.0 - from.0) * part, from.1 + (to.1 - from.1) * part);
    page.hold(rim);
    for step in 1..=10 {
        let part = f64::from(step) / 10.0;
        page.drag_on((rim.0 + (to.0 - rim.0) * part, rim.1 + (to.1 - rim.1) * part));
    }
    page.until("the middle is seen", "document.querySelectorAll('.linkcard img').length === 3");
    page.until("it moves", "document.querySelector('.linkcard video')?.currentTime > 0");
    assert_eq!(drawing(&studio), "running", "it plays before it is drawn to its end");
    // Nobody looks at it any more.
    page.drag_on(rim);
    page.release(rim);
    claims::wait::until("the drawing ends", 60, || drawing(&studio) == "cancelled");
    assert_eq!(studio.manifest(), before, "a preview makes no link");
    assert_eq!(json!(page.complaints()), json!([]));
}

#[test]
fn an_arrow_between_two_species_has_pictures_of_its_middle_and_a_preview() {
    let (_flock, _studio, page) = graph("?at=aurora&to=selene");
    page.until("the middle is seen", "document.querySelectorAll('.view.graph .panel .middles img').length === 3");
    page.press("v");
    page.until("it moves", "document.querySelector('.view.graph .panel video')?.currentTime > 0");
    assert_eq!(json!(page.complaints()), json!([]));
}

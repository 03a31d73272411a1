//! An arrow of the graph is led elsewhere by one of its ends.
//!
//! Owns the claims that this goes by a drag, by clicks and by keys, that it is one step of undo, and that the transition keeps
//! its weight and its length.
//!
//! Start at [`Graph`].

use claims::studio::browser::Browser;
use claims::studio::page::{DESK, Page};
use claims::studio::running::Studio;
use claims::studio::sheep::ring;
use serde_json::{Value, json};
use tempfile::TempDir;

/// A page on the graph of ten sheep in a ring with chords, where an arrow is chosen.
struct Graph {
    _flock: TempDir,
    studio: Studio,
    page: Page,
}

impl Graph {
    /// With the arrow from `from` to `to`, which weighs 3.
    fn at(from: &str, to: &str) -> Self {
        let flock = ring("meadow", 10, 1);
        let studio = Studio::of(flock.path());
        let heavy = json!([{ "do": "weight", "from": from, "to": to, "value": 3.0 }]);
        studio.edit(&studio.get("/api/state")["revision"], &heavy);
        let page = Page::open(&Browser::start(), &studio.address(), DESK);
        page.until("the studio is open", "document.body.dataset.view === 'wall'");
        page.ask(&format!("location.hash = '#/graph?at={from}&to={to}'"));
        page.until("the arrow has ends", "document.querySelectorAll('.view.graph .end').length === 2");
        Self { _flock: flock, studio, page }
    }

    fn disc(&self, sheep: &str) -> (f64, f64) {
        self.page.middle(&format!("document.querySelector('.view.graph [data-sheep={sheep}]')"))
    }

    fn end(&self, end: &str) -> (f64, f64) {
        self.page.middle(&format!("document.querySelector('.view.graph .end.{end}')"))
    }

    /// Waits until there is a transition from `from` to `to`: it weighs 3 and has the frames that it had.
    fn leads(&self, from: &str, to: &str) {
        let mut found = Value::Null;
        claims::wait::until(&format!("{from} leads to {to}"), 60, || {
            found = self.transition(from, to);
            !found.is_null()
        });
        assert_eq!((&found["weight"], &found["frames"]), (&json!(3.0), &json!(384)));
        assert_eq!(json!(self.page.complaints()), json!([]));
    }

    /// The transition as the program tells it; null if there is none.
    fn transition(&self, from: &str, to: &str) -> Value {
        let mut state = self.studio.get("/api/state");
        let all = state["transitions"].as_array_mut().expect("a list");
        all.drain(..).find(|one| one["from"] == from && one["to"] == to).unwrap_or_default()
    }
}

#[test]
fn the_end_of_an_arrow_is_dragged_to_another_sheep_as_one_step() {
    let graph = Graph::at("s0", "s1");
    let first = graph.studio.manifest();
    graph.page.drag(graph.end("to"), graph.disc("s4"));
    graph.leads("s0", "s4");
    assert!(graph.transition("s0", "s1").is_null());
    assert_eq!(graph.studio.get("/api/state")["undo"], "linked s0 to s4 instead of s0 to s1");
    // The arrow is still chosen: its beginning goes elsewhere, too.
    graph.page.until(
        "its ends are drawn",
        "document.querySelector('.view.graph .end.from')?.ariaLabel.startsWith('s0 to s4')",
    );
    graph.page.drag(graph.end("from"), graph.disc("s7"));
    graph.leads("s7", "s4");
    assert!(graph.transition("s0", "s4").is_null());
    for _ in 0..2 {
        graph.studio.post("/api/undo", &json!({}));
    }
    assert_eq!(graph.studio.manifest(), first, "each was one step");
}

#[test]
fn an_arrow_is_led_elsewhere_by_clicks_and_by_keys() {
    let graph = Graph::at("s0", "s1");
    graph.page.click_named("End elsewhere");
    graph.page.click_at(graph.disc("s4"));
    graph.leads("s0", "s4");
    graph.page.until(
        "the arrow is chosen",
        "document.querySelector('.view.graph .end.to')?.ariaLabel.startsWith('s0 to s4')",
    );
    graph.page.press("Shift+M");
    graph.page.press("/");
    graph.page.enter("s7");
    graph.page.press("Enter");
    graph.page.until("the target is marked", "document.querySelector('.view.graph [data-sheep=s7].target')");
    // Escape leaves it as it is.
    graph.page.press("Escape");
    graph.page.press("Shift+M");
    graph.page.press("/");
    graph.page.enter("s7");
    graph.page.press("Enter");
    graph.page.press("Enter");
    graph.leads("s7", "s4");
    assert!(graph.transition("s0", "s4").is_null() && graph.transition("s0", "s1").is_null());
}

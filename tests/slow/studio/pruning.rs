//! What cannot be reached is taken out of the flock.
//!
//! Owns the claims that the studio's page shows what `dreams prune` proposes, drops what it drops, by keys and by the
//! pointer, and takes it back.

use claims::studio::browser::Browser;
use claims::studio::page::{DESK, Page};
use claims::studio::running::Studio;
use claims::studio::unreachable::{flock, prune};
use serde_json::json;
use std::fs;

#[test]
fn what_cannot_be_reached_is_dropped_as_by_the_command_by_key_and_by_pointer_and_comes_back() {
    let (flock, alone) = (flock(), flock());
    prune(alone.path(), &["--write"]);
    let pruned = fs::read_to_string(alone.path().join("flock.toml")).unwrap();
    let studio = Studio::of(flock.path());
    let first = studio.manifest();
    let page = Page::open(&Browser::start(), &studio.address(), DESK);
    page.until("the Wall is drawn", "document.querySelector('.view.wall')?.dataset.state === 'ready'");
    page.ask("location.hash = '#/graph'");
    page.until("the graph is drawn", "document.querySelector('.view.graph')?.dataset.state === 'ready'");
    let is = |text: &str, what: &str| claims::wait::until(what, 60, || studio.manifest() == text);
    page.press("k");
    page.until("it is asked", "document.activeElement?.textContent === 'Drop 2 sheep'");
    let shown =
        "[...document.querySelectorAll('dialog [aria-label=\"Sheep to drop\"] li')].map(one => one.textContent)";
    assert_eq!(page.ask(shown), json!(["x0", "x1"]));
    page.press("Enter");
    is(&pruned, "it is pruned by the key");
    page.until("the page has six sheep", "document.querySelectorAll('.view.graph [data-sheep]').length === 6");
    page.press("z");
    is(&first, "it is as it was");
    page.until("the page has eight sheep", "document.querySelectorAll('.view.graph [data-sheep]').length === 8");
    page.press("Escape");
    page.click_named("Prune");
    page.click_named("Link x0 instead");
    page.until("both are in", "document.querySelector('dialog .told').textContent.startsWith('Nothing to drop')");
    page.click_named("Leave it");
    page.press("z");
    is(&first, "the link is gone");
    page.click_named("Prune");
    page.click_named("Drop 2 sheep");
    is(&pruned, "it is pruned by the pointer");
    assert_eq!(json!(page.complaints()), json!([]));
}

//! What cannot be reached is taken out of the flock.
//!
//! Owns the claims that the studio's page shows what `dreams prune` proposes, drops what it drops, by keys and by the
//! pointer, and takes it back.

use super::browser::Browser;
use super::page::{DESK, Page};
use super::running::Studio;
use super::sheep::ring;
use crate::programs::{self, succeed};
use serde_json::{Value, json};
use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

/// A flock of a ring of six, and of two sheep that lead into it and are never reached.
fn flock() -> TempDir {
    let folder = ring("meadow", 6, 1);
    let mut text = fs::read_to_string(folder.path().join("flock.toml")).unwrap();
    for (id, to) in [("x0", "x1"), ("x1", "s0")] {
        write!(text, "\n[[sheep]]\nid = \"{id}\"\nframes = 768\nclip = \"loops/{id}.mp4\"\n").unwrap();
        write!(text, "\n[[transition]]\nfrom = \"{id}\"\nto = \"{to}\"\nframes = 384\nclip = \"t/{id}.mp4\"\n")
            .unwrap();
    }
    fs::write(folder.path().join("flock.toml"), text).unwrap();
    folder
}

/// The answer of `dreams prune`.
fn prune(folder: &Path, options: &[&str]) -> Value {
    let said = succeed(Command::new(programs::dreams()).arg("prune").arg(folder).arg("--json").args(options));
    serde_json::from_slice(&said).unwrap()
}

#[test]
fn the_page_proposes_what_the_command_proposes_and_says_what_would_bring_the_rest_in() {
    let flock = flock();
    let studio = Studio::of(flock.path());
    let (told, proposed) = (studio.get("/api/prune"), prune(flock.path(), &[]));
    assert_eq!((&told["drop"], &told["ties"], &told["fewest"]), (&proposed["drop"], &proposed["ties"], &json!(1)));
    assert_eq!(told["was"]["worst_ratio"], studio.get("/api/state")["figures"]["worst_ratio"]);
    assert_eq!((&told["figures"]["sheep"], &told["figures"]["shown"]), (&json!(6), &json!(6)));
    let link = |of: &Value| json!({ "from": of["from"], "to": of["to"], "frames": of["frames"] });
    let links = |parts: &Value, of: fn(&Value) -> Vec<&Value>| -> Vec<Value> {
        parts.as_array().unwrap().iter().flat_map(of).filter(|one| !one.is_null()).map(link).collect()
    };
    let ours = links(&told["parts"], |part| part["links"].as_array().unwrap().iter().collect());
    assert_eq!(ours, links(&proposed["parts"], |part| vec![&part["entry"], &part["exit"]]));
    assert_eq!(studio.ask("GET", "/api/prune?keep=x0", None).status, 409, "no cycle leads through it");
    assert_eq!(studio.ask("GET", "/api/prune?keep=nobody", None).status, 404);
}

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

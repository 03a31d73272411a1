//! What a page is told of changes.
//!
//! Owns the claim that a page which fetches only what is new has the state that the program has, whatever happened between.
//! The page's own code puts the state together.
//!
//! Start at [`a_page_that_is_told_only_what_is_new_has_the_whole_state`].

use super::browser::Browser;
use super::edits::{EditsByChance, edits};
use super::page::{DESK, Page};
use super::running::Studio;
use super::sheep::ring;
use serde_json::{Value, json};

/// Has a store of the page take what is new, and compares it with the whole state: where they first differ, or nothing. What
/// is told of each fetch and each moment is another one, and figures are told with seven digits.
const COMPARE: &str = "(async () => {
  const { Store } = await import('/app/store.js')
  window.known ??= new Store()
  const fetched = async path => (await fetch(path)).json()
  const told = await fetched('/api/state?since=' + known.state.tag)
  known.replace(structuredClone(told))
  const whole = await fetched('/api/state')
  const differ = (a, b, path) => {
    if (typeof a === 'number' && typeof b === 'number') return Math.abs(a - b) <= 1e-6 * Math.max(Math.abs(a), Math.abs(b)) ? null : path
    if (a === null || b === null || typeof a !== 'object' || typeof b !== 'object') return Object.is(a, b) ? null : path
    for (const key of new Set([...Object.keys(a), ...Object.keys(b)])) {
      if (['tag', 'now_ms'].includes(key)) continue
      const found = differ(a[key], b[key], `${path}.${key}`)
      if (found) return found
    }
    return null
  }
  return { isNew: 'since' in told, bytes: JSON.stringify(told).length, off: differ(known.state, whole, '') }
})()";

#[test]
fn a_page_that_is_told_only_what_is_new_has_the_whole_state() {
    let flock = ring("meadow", 40, 2);
    let mut studio = Studio::of(flock.path());
    let browser = Browser::start();
    let page = Page::open(&browser, &studio.address(), DESK);
    page.until("the page is there", "document.body.dataset.view === 'wall'");
    let is_so = |step: &str, is_new: bool| {
        let told = page.ask(COMPARE);
        assert_eq!((&told["off"], &told["isNew"]), (&Value::Null, &json!(is_new)), "after {step}: {told}");
        told["bytes"].as_u64().expect("a number")
    };
    let whole = is_so("the start", false);
    let mut edits_by_chance = EditsByChance::of(flock.path(), 5);
    let mut revision = studio.get("/api/state")["revision"].clone();
    for at in 0..edits().min(60) {
        let edit = edits_by_chance.next();
        revision = studio.edit(&revision, &json!([edit.request]))["revision"].clone();
        let sheep = studio.get("/api/state")["sheep"][at % 9]["id"].clone();
        match at % 5 {
            0 => studio.post("/api/marks", &json!({ "marks": [{ "sheep": sheep, "mark": "kept", "rating": at % 6 }] })),
            1 => studio.post("/api/pins", &json!({ "sheep": sheep, "x": 0.25, "y": 0.5 })),
            2 => studio.post("/api/pins", &json!({ "sheep": sheep, "x": null, "y": null })),
            _ => Value::Null,
        };
        is_so(&format!("edit {at}: {:?}", edit.words), true);
    }
    for step in ["undo", "redo", "undo"] {
        studio.post(&format!("/api/{step}"), &json!({}));
        is_so(step, true);
    }
    assert!(is_so("nothing", true) < whole / 10, "what did not change is not told");
    studio.kill_and_restart();
    page.ask(&format!("location.href = '{}'", studio.address()));
    page.until(
        "the page is signed in again",
        "document.querySelector('#closed').hidden && document.querySelector('#offline').hidden",
    );
    is_so("a restart", false);
}

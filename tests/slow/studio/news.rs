//! What a page is told of changes.
//!
//! Owns the claim that a page which fetches only what is new has the state that the program has, whatever happened between.
//! The page's own code puts the state together.
//!
//! Start at [`a_page_that_is_told_only_what_is_new_has_the_whole_state`].

use claims::studio::browser::Browser;
use claims::studio::edits_by_chance::{EditsByChance, edits};
use claims::studio::page::{DESK, Page};
use claims::studio::running::Studio;
use claims::studio::sheep::ring;
use serde_json::{Value, json};

/// Has a store of the page take what is new, and compares it with the whole state: where they first differ, or nothing. What
/// is told of each fetch and each moment is another one, and figures are told with seven digits.
const COMPARE: &str = "(async () => {
  const { Store } = await import('/app/store.js')
  window.known ??= new Store()
  const { secret } = await import('/app/session.js')
  const fetched = async path => (await fetch(path, { headers: { 'X-Studio-Secret': secret() } })).json()
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
        let edit = edits_by_chance.choose();
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

#[test]
fn an_edit_that_is_made_elsewhere_changes_the_figures_that_a_page_shows() {
    let flock = ring("meadow", 12, 2);
    let studio = Studio::of(flock.path());
    let page = Page::open(&Browser::start(), &studio.address(), DESK);
    let figure = "document.querySelector('[data-figure=worst_ratio]')?.textContent";
    page.until("the page shows the worst ratio", figure);
    let before = page.ask(figure);
    let told =
        studio.edit(&studio.get("/api/state")["revision"], &json!([{ "do": "want", "sheep": "s3", "value": 40.0 }]));
    page.until("another worst ratio is shown", &format!("{figure} !== {before}"));
    let shown: f64 = page.ask(figure).as_str().unwrap().parse().unwrap();
    let is = told["figures"]["worst_ratio"].as_f64().unwrap();
    assert!((shown - is).abs() <= 0.06 * is.max(1.0), "{shown} is shown, {is} is so");
}

/// The answer to a job that is asked for comes after the program has told more of it.
const LATE: &str = "const quick = window.fetch
  window.fetch = async (path, ...all) => {
    const answer = await quick(path, ...all)
    if (String(path) === '/api/ship/check') await new Promise(done => { window.answer = done })
    return answer
  }";

#[test]
fn an_answer_that_comes_late_does_not_take_back_what_the_events_have_told() {
    let flock = ring("meadow", 4, 0);
    let studio = Studio::of(flock.path());
    let page = Page::prepared(&Browser::start(), &studio.address(), DESK, LATE);
    page.until("the studio is open", "document.body.dataset.view === 'wall'");
    page.ask("location.hash = '#/ship'");
    page.until("the view is drawn", "document.querySelector('.view.ship')?.dataset.state === 'ready'");
    page.click_named("Check");
    page.until("the answer is held back", "window.answer");
    claims::wait::until("the check is over", 60, || {
        studio.get("/api/jobs")["jobs"]
            .as_array()
            .unwrap()
            .iter()
            .any(|job| job["kind"] == "check" && job["state"] == "done")
    });
    page.ask("location.hash = '#/jobs'");
    let says = "document.querySelector('.view.jobs .job .chip')?.textContent === 'done'";
    page.until("the page says that it is done", says);
    page.ask("answer()");
    page.ask("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))");
    assert_eq!(page.ask(says), true);
}

/// A stream of events to which the claim adds its own, as if the program had told them.
const LISTENED: &str =
    "window.EventSource = class extends EventSource { constructor(...all) { super(...all); window.stream = this } }";

#[test]
fn a_cell_says_how_far_its_clip_is_rendered_and_no_other_cell_is_drawn() {
    let flock = ring("meadow", 12, 1);
    let studio = Studio::of(flock.path());
    let page = Page::prepared(&Browser::start(), &studio.address(), DESK, LISTENED);
    page.until("the Wall is drawn", "document.querySelector('.view.wall')?.dataset.state === 'ready' && document.querySelector('[data-sheep=s3] .state')?.textContent === 'missing'");
    let told = |state: &str, done: u32| {
        let job = json!({ "id": 900, "kind": "render", "what": "the loop of s3", "about": { "sheep": "s3" }, "state": state, "done": done,
                          "of": 200, "per_second": null, "left_s": null, "cost_s": null, "log": [], "error": null, "paused": false, "can_pause": true });
        page.ask(&format!(
            "stream.dispatchEvent(new MessageEvent('job', {{ data: JSON.stringify({{ job: {job} }}) }}))"
        ));
    };
    let says = |text: &str| {
        page.until(
            &format!("the cell says `{text}`"),
            &format!("document.querySelector('[data-sheep=s3] .state').textContent === '{text}'"),
        );
    };
    told("queued", 0);
    says("queued");
    told("running", 1);
    says("0 %");
    page.ask("window.drawn = new Set(); new MutationObserver(all => all.forEach(({ target }) => drawn.add(target.closest?.('[data-sheep]')?.dataset.sheep ?? target.parentElement?.closest('[data-sheep]')?.dataset.sheep)))
        .observe(document.querySelector('.field-of-cells'), { subtree: true, childList: true, attributes: true, characterData: true })");
    told("running", 87);
    says("43 %");
    told("running", 190);
    says("95 %");
    assert_eq!(page.ask("[...drawn]"), json!(["s3"]));
    let heard = page.ask("document.querySelector('[data-sheep=s3]').getAttribute('aria-label')");
    assert!(heard.as_str().unwrap().contains("rendering 95 %"), "{heard}");
    // Of a job that is over nothing is left: the document says what became of the clip.
    told("cancelled", 190);
    says("missing");
}

//! What the Wall shows, in which order, and what comes into the flock from it.
//!
//! Owns the claims on its search, its orders and its filters, on what is not measured yet, on an archive, and on a new name.
//!
//! Start at [`Wall`].

use claims::studio::browser::Browser;
use claims::studio::page::{DESK, Page};
use claims::studio::running::Studio;
use claims::studio::sheep::{many, quick};
use claims::wait;
use serde_json::{Value, json};
use std::fs;
use tempfile::TempDir;

/// Seconds for what the program works at.
const WORK_S: u32 = 600;
/// The sheep on the Wall, in their order.
const SHOWN: &str = "[...document.querySelectorAll('.view.wall .field-of-cells > [data-sheep]')]
    .sort((a, b) => a.ariaPosInSet - b.ariaPosInSet).map(one => one.dataset.sheep)";

/// A studio of ten sheep with clips, beside an archive of two, and a page on its Wall.
struct Wall {
    _folders: [TempDir; 2],
    studio: Studio,
    page: Page,
}

impl Wall {
    fn new() -> Self {
        Self::with("")
    }

    /// The same; the script `before` runs before any of the page.
    fn with(before: &str) -> Self {
        let (flock, archive) = (many(10), tempfile::tempdir().unwrap());
        fs::write(archive.path().join("calm.expr"), "(expression 1 (picture (+ 0.4 (* 0.1 (sin (wave 1 0))))))\n")
            .unwrap();
        fs::write(archive.path().join("spare.expr"), quick(7)).unwrap();
        let studio = Studio::with(flock.path(), &["--archive", archive.path().to_str().unwrap()]);
        let page = Page::prepared(&Browser::start(), &studio.address(), DESK, before);
        page.until("the Wall is drawn", "document.querySelector('.view.wall')?.dataset.state === 'ready' && document.querySelectorAll('[data-sheep]').length === 12");
        Self { _folders: [flock, archive], studio, page }
    }

    /// All sheep as the program has them, of the flock and of the archive.
    fn sheep(&self) -> Vec<Value> {
        let state = self.studio.get("/api/state");
        ["sheep", "candidates"].iter().flat_map(|list| state[list].as_array().unwrap().clone()).collect()
    }

    /// Has the Wall show what fits, by its address.
    fn open(&self, params: &str) {
        self.page.ask(&format!("location.hash = '#/wall?{params}'"));
        self.page.until("the address is taken", &format!("location.hash === '#/wall?{params}'"));
    }

    /// Chooses `value` in the control with this name.
    fn choose(&self, control: &str, value: &str) {
        let select = format!("document.querySelector('.view.wall select[aria-label={control}]')");
        self.page.until(
            &format!("`{control}` has `{value}`"),
            &format!("[...{select}?.options ?? []].some(one => one.value === '{value}')"),
        );
        self.page.ask(&format!(
            "(() => {{ const one = {select}; one.value = '{value}'; one.dispatchEvent(new Event('change')) }})()"
        ));
    }

    /// Waits until the Wall shows these, in any order.
    fn shows(&self, what: &str, wanted: impl Iterator<Item = String>) {
        let mut ids: Vec<String> = wanted.collect();
        ids.sort();
        self.page.until(
            &format!("the Wall shows {what}: {ids:?}"),
            &format!("({SHOWN}).sort().join() === '{}'", ids.join(",")),
        );
    }

    /// Has all sheep measured by the program.
    fn measure(&self) {
        self.studio.post("/api/jobs", &json!({ "kind": "measure" }));
        wait::until("all are measured", WORK_S, || self.sheep().iter().all(|one| !one["activity"].is_null()));
    }

    fn is_written(&self, text: &str) {
        wait::until(&format!("the manifest has `{text}`"), 60, || self.studio.manifest().contains(text));
    }
}

fn id(sheep: &Value) -> String {
    sheep["id"].as_str().expect("an id is a text").to_owned()
}

/// A control, its choices, and which sheep fit each.
type Filter = (&'static str, &'static [(&'static str, fn(&Value) -> bool)]);

const FILTERS: [Filter; 8] = [
    (
        "From",
        &[
            ("flock", |one| one["in_flock"] == true),
            ("pool", |one| one["source"] == "pool"),
            ("archive", |one| one["source"] == "archive"),
            ("candidates", |one| one["in_flock"] == false),
        ],
    ),
    (
        "Mark",
        &[
            ("kept", |one| one["mark"] == "kept"),
            ("none", |one| one["mark"] == "none"),
            ("rejected", |one| one["mark"] == "rejected"),
            ("open", |one| one["mark"] != "rejected"),
        ],
    ),
    (
        "Share",
        &[
            ("less", |one| ratio(one).is_some_and(|ratio| ratio < 0.8)),
            ("more", |one| ratio(one).is_some_and(|ratio| ratio > 1.25)),
            ("never", |one| one["in_flock"] == true && one["shown"] == false),
        ],
    ),
    (
        "Clip",
        &[
            ("there", |one| one["state"] == "there"),
            ("open", |one| one["state"] == "missing" || one["state"] == "none"),
            ("damaged", |_| false),
        ],
    ),
    ("Species", &[("expr", |one| one["species"] == "expr")]),
    ("Licence", &[("none given", |one| one["licence"].is_null())]),
    ("Votes", &[("liked", |_| false), ("none", |one| one["votes"].is_null())]),
    ("Rating", &[("1", |one| number(one, "rating") >= 1.0), ("3", |one| number(one, "rating") >= 3.0)]),
];

/// An order, and what falls, or stays, from a sheep to the next.
type Order = (&'static str, fn(&Value) -> f64);

const ORDERS: [Order; 7] = [
    ("worst", |one| ratio(one).map_or(-1.0, |ratio| ratio.log2().abs())),
    ("share", |one| number(one, "share")),
    ("votes", |_| 0.0),
    ("rating", |one| number(one, "rating")),
    ("activity", |one| number(one, "activity")),
    ("newest", |one| number(one, "made_ms")),
    ("cost", |one| if one["state"] == "there" { 0.0 } else { number(one, "frames") }),
];

fn ratio(one: &Value) -> Option<f64> {
    one["ratio"].as_f64().filter(|_| one["shown"] == true)
}

/// The figure of a sheep; 0 if it is not known.
fn number(one: &Value, name: &str) -> f64 {
    one[name].as_f64().unwrap_or_default()
}

/// Sheep of every kind: marked, rated, wished more and less, and without a loop.
fn varied() -> Wall {
    let wall = Wall::new();
    let marks = json!([
        { "sheep": "s001", "mark": "kept", "rating": 5 },
        { "sheep": "s002", "mark": "rejected", "rating": 2 },
        { "sheep": "spare", "mark": "kept", "rating": 3 },
    ]);
    wall.studio.post("/api/marks", &json!({ "marks": marks }));
    fs::remove_file(wall.studio.folder.join("loops/s006.mp4")).unwrap();
    let wants = json!([
        { "do": "want", "sheep": "s003", "value": 4.0 },
        { "do": "want", "sheep": "s004", "value": 0.25 },
    ]);
    wall.studio.edit(&wall.studio.get("/api/state")["revision"], &wants);
    let is_told = "document.querySelector('[data-sheep=s006] .state').textContent === 'missing'";
    wall.page.until("the page knows that a loop is missing", is_told);
    wall.measure();
    wall
}

#[test]
fn each_filter_of_the_wall_and_its_search_show_the_sheep_that_they_say() {
    let wall = varied();
    let all = wall.sheep();
    wall.page.press("f");
    for (control, choices) in FILTERS {
        for (value, fits) in choices {
            wall.choose(control, value);
            wall.shows(&format!("`{control}` `{value}`"), all.iter().filter(|one| fits(one)).map(id));
        }
        wall.page.click_named("Show all");
        wall.shows("all", all.iter().map(id));
    }
    // Of both, what fits both.
    wall.choose("Mark", "kept");
    wall.choose("From", "archive");
    wall.shows("what is kept in the archive", ["spare".to_owned()].into_iter());
    wall.page.click_named("Show all");
    wall.page.press("/");
    wall.page.enter("S00");
    let named = |part: &str| all.iter().map(id).filter(|id| id.contains(part)).collect::<Vec<_>>();
    wall.shows("what is found", named("s00").into_iter());
    wall.page.enter("7");
    wall.shows("the one that is found", named("s007").into_iter());
}

#[test]
fn each_order_of_the_wall_is_the_one_that_it_says() {
    let wall = varied();
    let all = wall.sheep();
    let of = |id: &Value| all.iter().find(|one| one["id"] == *id).expect("a sheep that is there");
    for (order, figure) in ORDERS {
        wall.choose("Order", order);
        let shown = wall.page.ask(SHOWN);
        let figures: Vec<f64> = shown.as_array().unwrap().iter().map(|id| figure(of(id))).collect();
        assert_eq!(figures.len(), 12, "`{order}`: {shown}");
        assert!(figures.windows(2).all(|two| two[0] >= two[1] - 1e-6), "`{order}`: {shown} {figures:?}");
    }
    wall.choose("Order", "id");
    let mut names: Vec<String> = all.iter().map(id).collect();
    names.sort();
    assert_eq!(wall.page.ask(SHOWN), json!(names));
    assert_eq!(json!(wall.page.complaints()), json!([]));
}

#[test]
fn a_choice_by_what_is_seen_says_how_many_are_not_measured_and_has_them_measured() {
    // Strips in view are made: here none is asked for.
    let wall = Wall::with("Object.defineProperty(HTMLImageElement.prototype, 'src', { get: () => '', set: () => {} })");
    wall.choose("Order", "activity");
    let says =
        "[...document.querySelectorAll('.view.wall .banner')].find(one => one.checkVisibility())?.textContent ?? ''";
    wall.page.until("the Wall says that sheep are not measured", &format!("({says}).includes('not measured yet')"));
    wall.studio.post("/api/jobs/pause", &json!({ "paused": true }));
    wall.page.click_named("Measure them");
    wall.page.until("the Wall says that they wait", &format!("({says}).includes('waits for other jobs')"));
    wall.studio.post("/api/jobs/pause", &json!({ "paused": false }));
    wait::until("all are measured", WORK_S, || wall.sheep().iter().all(|one| !one["activity"].is_null()));
    wall.page.until("nothing is left to be said", &format!("({says}) === ''"));
    // The page was told of each: its choices are those of the program.
    let all = wall.sheep();
    wall.page.press("f");
    let mut lively: Vec<f64> = all.iter().map(|one| number(one, "activity")).collect();
    lively.sort_by(f64::total_cmp);
    let third = lively[2 * lively.len() / 3];
    wall.choose("Activity", "2");
    wall.shows("the lively ones", all.iter().filter(|one| number(one, "activity") >= third).map(id));
    wall.page.click_named("Show all");
    // Every sheep is of one of the colours that are offered.
    let offered = wall.page.ask(
        "[...document.querySelector('.view.wall select[aria-label=Colour]').options].map(one => one.value).filter(Boolean)",
    );
    let mut coloured = Vec::new();
    for colour in offered.as_array().unwrap().iter().map(|colour| colour.as_str().unwrap()) {
        wall.choose("Colour", colour);
        let shown = wall.page.ask(SHOWN).as_array().unwrap().clone();
        assert!(!shown.is_empty(), "`{colour}`");
        coloured.extend(shown.iter().map(|id| id.as_str().unwrap().to_owned()));
    }
    coloured.sort();
    let mut names: Vec<String> = all.iter().map(id).collect();
    names.sort();
    assert_eq!((coloured, offered.as_array().unwrap().len() > 1), (names, true));
    assert_eq!(json!(wall.page.complaints()), json!([]));
}

#[test]
fn a_sheep_of_an_archive_comes_into_the_flock_by_one_key_and_goes_by_undo() {
    let wall = Wall::new();
    wall.open("of=archive");
    wall.shows("the archive", ["calm", "spare"].map(str::to_owned).into_iter());
    wall.page.press("Home");
    wall.page.press("a");
    wall.is_written("id = \"calm\"");
    wall.shows("what is left", ["spare".to_owned()].into_iter());
    let state = wall.studio.get("/api/state");
    let own = state["sheep"].as_array().unwrap().iter().find(|one| one["id"] == "calm");
    assert_eq!(own.map(|one| &one["genome"]), Some(&json!(true)));
    wall.page.press("z");
    wall.shows("the archive again", ["calm", "spare"].map(str::to_owned).into_iter());
    assert!(!wall.studio.manifest().contains("calm"));
}

#[test]
fn a_sheep_has_another_name_with_its_files_and_keeps_its_mark() {
    let wall = Wall::new();
    wall.studio.post("/api/marks", &json!({ "marks": [{ "sheep": "s005", "mark": "kept" }] }));
    wall.page.ask("location.hash = '#/graph?at=s005'");
    wall.page.until("the sheep is chosen", "document.querySelector('.panel h2')?.textContent === 's005'");
    wall.page.click_named("Rename…");
    wall.page.enter("orchid");
    wall.page.press("Enter");
    wall.is_written("id = \"orchid\"");
    wall.page.until("it is chosen by its new name", "document.querySelector('.panel h2')?.textContent === 'orchid'");
    let all = wall.sheep();
    let own = all.iter().find(|one| one["id"] == "orchid").expect("it is there");
    assert_eq!((&own["mark"], &own["state"]), (&json!("kept"), &json!("there")));
    assert!(wall.studio.folder.join("loops/orchid.mp4").exists() && !wall.studio.manifest().contains("s005"));
}

//! A whole task of an artist, by the keyboard alone and by the pointer alone.
//!
//! Owns the claim: of 300 sheep 30 are chosen, linked and balanced, two joins are looked at, one transition is rendered as a
//! draft, and the flock is packed.
//!
//! Start at [`Task`].

use claims::programs::{self, succeed};
use claims::studio::browser::Browser;
use claims::studio::page::{DESK, Page};
use claims::studio::running::Studio;
use claims::studio::sheep::many;
use serde_json::{Value, json};
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::process::Command;
use tempfile::TempDir;

/// A studio of 300 sheep, with a key that may sign, and its page on the Wall.
struct Task {
    flock: TempDir,
    desk: TempDir,
    studio: Studio,
    page: Page,
}

/// Seconds for what the program works at.
const WORK_S: u32 = 900;

impl Task {
    fn new() -> Self {
        let (flock, desk) = (many(300), tempfile::tempdir().unwrap());
        // One of the two links was rendered before; the flock takes it up again. It is of the same two kinds of sheep.
        let clip = |name: &str| flock.path().join(format!("transitions/{name}.mp4"));
        fs::hard_link(clip("s004=s005"), clip("s029=s000")).unwrap();
        let at = |name: &str| desk.path().join(name).to_str().unwrap().to_owned();
        for (name, text) in [("artist.key", include_str!("../../fixtures/keys/artist.key")), ("passphrase", "velvet\n")]
        {
            fs::write(at(name), text).unwrap();
            fs::set_permissions(at(name), fs::Permissions::from_mode(0o600)).unwrap();
        }
        fs::write(at("artist.pub"), include_str!("../../fixtures/keys/artist.pub")).unwrap();
        let [key, passphrase, outbox] = [at("artist.key"), at("passphrase"), at("outbox")];
        let options = ["--key", &key, "--passphrase-file", &passphrase, "--outbox", &outbox];
        let studio = Studio::with(flock.path(), &options);
        let page = Page::open(&Browser::start(), &studio.address(), DESK);
        page.until("the Wall is drawn", "document.querySelector('.view.wall')?.dataset.state === 'ready'");
        Self { flock, desk, studio, page }
    }

    /// Waits until the sheep of the flock are so many.
    fn has_sheep(&self, sheep: usize) {
        let shown = format!("document.querySelectorAll('.view.wall [data-sheep]').length === {sheep}");
        self.page.until(&format!("{sheep} sheep are on the Wall"), &shown);
        let there = self.studio.manifest().matches("[[sheep]]").count();
        assert_eq!(there, sheep);
    }

    /// Waits until the manifest has `text`.
    fn is_written(&self, text: &str) {
        let mut ticks = 0;
        claims::wait::until(&format!("the manifest has `{text}`"), 70, || {
            ticks += 1;
            assert!(
                ticks < 60_000,
                "the manifest has no `{text}`; the page says {}",
                self.page.ask("document.body.innerText")
            );
            self.studio.manifest().contains(text)
        });
    }

    /// Waits until the transition is chosen in the graph.
    fn has_chosen(&self, from: &str, to: &str) {
        let ends = format!("document.querySelector('.view.graph h2.ends')?.textContent === '{from} to {to}'");
        self.page.until(&format!("the arrow from {from} to {to} is chosen"), &ends);
    }

    /// What the loupe shows: the join's title, the clip and the frame.
    fn looks_at(&self) -> (Value, Value) {
        let canvas = "[...document.querySelectorAll('.view.walk canvas.frame')].find(one => one.checkVisibility())";
        self.page
            .until("the loupe shows a frame", &format!("{canvas}?.getAttribute('aria-label').startsWith('frame ')"));
        let title = self.page.ask(
            "[...document.querySelectorAll('.view.walk .stage h2')].find(one => one.checkVisibility()).textContent",
        );
        (title, self.page.ask(&format!("{canvas}.getAttribute('aria-label')")))
    }

    /// Waits until all is rendered: one transition, by one job, as a draft.
    fn is_rendered(&self) {
        let clip = self.flock.path().join("transitions/s005=s011.mp4");
        claims::wait::until("the transition is rendered", WORK_S, || clip.exists());
        let mut jobs = Value::Null;
        claims::wait::until("no job is left", WORK_S, || {
            jobs = self.studio.get("/api/jobs")["jobs"].take();
            let is_over = |job: &Value| ["done", "cancelled", "failed"].map(Value::from).contains(&job["state"]);
            jobs.as_array().unwrap().iter().all(is_over)
        });
        let rendered = jobs.as_array().unwrap().iter().filter(|job| job["kind"] == "render");
        let told: Vec<(&Value, &Value)> = rendered.map(|job| (&job["what"], &job["state"])).collect();
        assert_eq!(told, [(&json!("a draft of the transition from s005 to s011"), &json!("done"))]);
        // What `dreams render` would render anew with these options: nothing as drafts, else the one clip that is a draft.
        let anew = |options: &[&str]| {
            let mut render = Command::new(programs::dreams());
            render.args(["render", "--dry-run", "--json"]).args(options).arg(self.flock.path());
            let told: Value = serde_json::from_slice(&succeed(&mut render)).unwrap();
            let clips = told["clips"].as_array().unwrap().iter();
            clips.map(|clip| [clip["clip"].clone(), clip["state"].clone()]).collect::<Vec<_>>()
        };
        assert!(anew(&["--preset", "draft"]).is_empty(), "all clips are drafts");
        assert_eq!(anew(&[]), [["transitions/s005=s011.mp4", "changed"].map(Value::from)]);
    }

    /// The task is done: the bundle can be played by whoever trusts the artist.
    fn is_packed(&self) {
        let bundle = |job: &Value| job["kind"] == "pack" && job["state"] == "done";
        claims::wait::until("the flock is packed", WORK_S, || {
            let jobs = self.studio.get("/api/jobs");
            let jobs = jobs["jobs"].as_array().unwrap();
            let failed = jobs.iter().find(|job| job["kind"] == "pack" && job["state"] == "failed");
            assert!(failed.is_none(), "{failed:?}");
            jobs.iter().any(bundle)
        });
        let [outbox, artist] = ["outbox", "artist.pub"].map(|name| self.desk.path().join(name));
        let mut verify = Command::new(programs::dreams());
        verify.arg("verify").arg(outbox).arg("--trust").arg(artist);
        let said = String::from_utf8(succeed(&mut verify)).unwrap();
        assert!(!said.is_empty());
        let shown = self.studio.get("/api/state")["figures"]["shown"].clone();
        assert_eq!(shown, 30, "all that were chosen are shown");
        // What would take sheep off the wall is answered by a question, which a browser's console calls an error.
        let is_question = |complaint: &String| complaint.contains("428 (Precondition Required)");
        let wrong: Vec<String> = self.page.complaints().into_iter().filter(|one| !is_question(one)).collect();
        assert_eq!(json!(wrong), json!([]));
    }
}

#[test]
fn a_flock_is_chosen_linked_balanced_looked_at_rendered_and_packed_by_the_keyboard_alone() {
    let task = Task::new();
    let page = &task.page;
    let keys = |keys: &[&str]| keys.iter().for_each(|key| page.press(key));
    // Thirty are kept; all others are selected and taken out, which breaks the ring: that is asked.
    keys(&["Home"]);
    keys(&["k"; 30]);
    keys(&["Shift+End", "Delete"]);
    page.until("it is asked", "document.querySelector('dialog[open]')");
    keys(&["Tab", "Enter"]);
    task.has_sheep(30);
    keys(&["End", "l", "Home", "Enter"]);
    task.is_written("from = \"s029\"\nto = \"s000\"");
    keys(&["Home"]);
    keys(&["ArrowRight"; 5]);
    keys(&["l"]);
    keys(&["ArrowRight"; 6]);
    keys(&["Enter"]);
    task.is_written("from = \"s005\"\nto = \"s011\"");
    keys(&["g", "g"]);
    page.until("the graph is drawn", "document.querySelector('.view.graph')?.dataset.state === 'ready'");
    keys(&["b"]);
    page.until("a balance is offered", "document.activeElement?.textContent === 'Take these weights'");
    keys(&["Enter"]);
    task.is_written("weight = ");
    keys(&["g", "p"]);
    page.until("the walk is there", "Number(document.querySelector('.view.walk .screen')?.dataset.frame) > 3");
    keys(&["l"]);
    let (first, _) = task.looks_at();
    keys(&["ArrowDown"]);
    page.until("another join is chosen", &format!("[...document.querySelectorAll('.view.walk .stage h2')].find(one => one.checkVisibility()).textContent !== {first}"));
    let (second, before) = task.looks_at();
    keys(&["."]);
    assert_ne!((&second, &before), (&first, &task.looks_at().1), "a key leads to another frame");
    keys(&["g", "g"]);
    page.until("the graph is shown again", "document.querySelector('.view.graph')?.checkVisibility()");
    keys(&["/"]);
    page.until("a sheep can be named", "document.activeElement?.matches('.view.graph input[type=search]')");
    keys(&["s", "0", "0", "5", "Enter"]);
    page.until("the sheep is chosen", "document.querySelector('.view.graph .panel h2')?.textContent === 's005'");
    keys(&[".", "."]);
    task.has_chosen("s005", "s011");
    keys(&["d"]);
    page.until("it is asked", "document.querySelector('dialog[open]')");
    keys(&["Tab", "Enter"]);
    task.is_rendered();
    keys(&["g", "s"]);
    page.until("the flock is ready", "document.querySelector('.view.ship h2')?.textContent === 'Ready for the walls'");
    keys(&["p"]);
    task.is_packed();
}

#[test]
fn a_flock_is_chosen_linked_balanced_looked_at_rendered_and_packed_by_the_pointer_alone() {
    let task = Task::new();
    let page = &task.page;
    let sheep = |id: &str| format!(".view:not([hidden]) [data-sheep={id}]");
    let scroll_to = |id: &str| {
        let is_there = format!("document.querySelector('{}')", sheep(id));
        for _ in 0..200 {
            if page.ask(&format!("Boolean({is_there})")) == true {
                return;
            }
            page.wheel((600.0, 500.0), 300.0);
            page.ask("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))");
        }
        page.until(&format!("`{id}` is scrolled to"), &is_there);
    };
    page.click(&sheep("s000"));
    scroll_to("s029");
    page.shift_click(&sheep("s029"));
    page.click_named("Keep 30");
    scroll_to("s030");
    page.click(&sheep("s030"));
    scroll_to("s299");
    page.shift_click(&sheep("s299"));
    page.click_named("Take out 270");
    page.click_named("Do it anyway");
    task.has_sheep(30);
    page.click_named("Graph");
    page.until("the graph is drawn", "document.querySelector('.view.graph')?.dataset.state === 'ready'");
    for (from, to) in [("s029", "s000"), ("s005", "s011")] {
        let disc = |id: &str| {
            let box_of = page.ask(&format!("(({{ x, y, width, height }}) => [x + width / 2, y + height / 2, width / 2])(document.querySelector('{}').getBoundingClientRect())", sheep(id)));
            let number = |at: usize| box_of[at].as_f64().unwrap();
            (number(0), number(1), number(2))
        };
        let ((x, y, r), (to_x, to_y, _)) = (disc(from), disc(to));
        let long = f64::hypot(to_x - x, to_y - y);
        page.drag((x + (to_x - x) / long * r * 0.95, y + (to_y - y) / long * r * 0.95), (to_x, to_y));
        task.is_written(&format!("from = \"{from}\"\nto = \"{to}\""));
        task.has_chosen(from, to);
    }
    page.click_named("Whole flock");
    page.click_named("Balance");
    page.click_named("Take these weights");
    task.is_written("weight = ");
    page.click_named("Walk");
    page.click_named("The joins");
    page.click(".view.walk li:nth-child(1) .join-row");
    let (first, _) = task.looks_at();
    page.click(".view.walk li:nth-child(2) .join-row");
    page.until("another join is chosen", &format!("[...document.querySelectorAll('.view.walk .stage h2')].find(one => one.checkVisibility()).textContent !== {first}"));
    task.looks_at();
    page.click_named("Graph");
    page.click(&sheep("s005"));
    page.click_named("s011");
    task.has_chosen("s005", "s011");
    page.click_named("Render a draft");
    page.click_named("Render it");
    task.is_rendered();
    page.click_named("Ship");
    page.until("the flock is ready", "document.querySelector('.view.ship h2')?.textContent === 'Ready for the walls'");
    page.click_named("Pack");
    task.is_packed();
}

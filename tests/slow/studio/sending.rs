//! What leaves the studio, and the jobs on the way.
//!
//! Owns the claims on the passphrase at the terminal, on what is said to be new, on several keys, and on one job that is
//! paused.
//!
//! Start at [`Desk`].

use claims::programs::{self, succeed};
use claims::studio::browser::Browser;
use claims::studio::page::{DESK, Page};
use claims::studio::running::Studio;
use claims::studio::sheep::many;
use claims::wait;
use serde_json::{Value, json};
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

/// Seconds for what the program works at.
const WORK_S: u32 = 600;

/// A small flock with clips, and a folder with keys, a passphrase, an outbox and a place to publish to.
struct Desk {
    flock: TempDir,
    own: TempDir,
}

impl Desk {
    fn new() -> Self {
        let (flock, own) = (many(5), tempfile::tempdir().unwrap());
        let keep = |name: &str, text: &str| {
            let path = own.path().join(name);
            fs::write(&path, text).unwrap();
            fs::set_permissions(&path, fs::Permissions::from_mode(0o600)).unwrap();
        };
        keep("passphrase", "velvet\n");
        keep("artist.key", include_str!("../../fixtures/keys/artist.key"));
        keep("artist.pub", include_str!("../../fixtures/keys/artist.pub"));
        fs::create_dir(own.path().join("stick")).unwrap();
        Self { flock, own }
    }

    /// The path of what is called `name`.
    fn at(&self, name: &str) -> String {
        self.own.path().join(name).to_str().unwrap().to_owned()
    }

    /// The options of the studio: its key, its outbox and its target.
    fn options(&self) -> Vec<String> {
        let [key, outbox, stick] = ["artist.key", "outbox", "stick"].map(|name| self.at(name));
        ["--key", &key, "--outbox", &outbox, "--to", &stick].map(str::to_owned).to_vec()
    }
}

/// The job that `answer` names, as it is now.
fn job(studio: &Studio, answer: &Value) -> Value {
    let jobs = studio.get("/api/jobs")["jobs"].take();
    let own = jobs.as_array().unwrap().iter().find(|job| job["id"] == answer["job"]["id"]);
    own.expect("it is listed").clone()
}

/// Waits until that job is done.
fn is_done(studio: &Studio, answer: &Value) {
    wait::until(&format!("{} is done", answer["job"]["what"]), WORK_S, || {
        let own = job(studio, answer);
        assert!(own["state"] != "failed" && own["state"] != "cancelled", "{own}");
        own["state"] == "done"
    });
}

/// Waits until nothing is queued and nothing runs.
fn rests(studio: &Studio) {
    wait::until("no job is left", WORK_S, || {
        let jobs = studio.get("/api/jobs")["jobs"].take();
        let is_over = |job: &Value| ["done", "failed", "cancelled"].map(Value::from).contains(&job["state"]);
        jobs.as_array().unwrap().iter().all(is_over)
    });
}

#[test]
fn the_passphrase_is_asked_on_the_terminal_alone_and_what_waited_for_it_waits_no_longer() {
    let desk = Desk::new();
    let options = desk.options();
    let mut studio = Studio::at_terminal(desk.flock.path(), &options.iter().map(String::as_str).collect::<Vec<_>>());
    let page = Page::open(&Browser::start(), &studio.address(), DESK);
    page.until("the studio is open", "document.body.dataset.view === 'wall'");
    page.ask("location.hash = '#/ship'");
    page.until("the flock is ready", "document.querySelector('.view.ship h2')?.textContent === 'Ready for the walls'");
    page.click_named("Pack");
    let chip = "document.querySelector('.view.ship .job .chip')?.textContent";
    page.until("the page says who is waited for", &format!("{chip} === 'waits for you'"));
    assert_eq!(page.ask("document.querySelectorAll('input[type=password]').length"), 0);
    let log = page.ask("document.querySelector('.view.ship .job pre').textContent");
    assert!(log.as_str().unwrap().contains("on the terminal"), "{log}");
    studio.type_at_terminal("velvet\n");
    let opened = "document.querySelector('.view.ship .job pre').textContent.includes('the key is open')";
    page.until("the key is open", opened);
    assert_ne!(page.ask(chip), "waits for you");
    rests(&studio);
    assert_eq!(studio.get("/api/ship")["packed"], true);
    let verified = Command::new(programs::dreams())
        .args(["verify", &desk.at("outbox"), "--trust", &desk.at("artist.pub")])
        .output()
        .unwrap();
    assert!(verified.status.success(), "{verified:?}");
}

/// Has `dreams keygen` make another key, which comes first in the alphabet.
fn other_key(desk: &Desk) {
    let mut keygen = Command::new(programs::dreams());
    keygen.args(["keygen", &desk.at("aaa.key"), "--passphrase-file", &desk.at("passphrase")]);
    succeed(&mut keygen);
    assert!(Path::new(&desk.at("aaa.pub")).exists());
}

#[test]
fn what_is_new_is_said_only_when_it_is_known_and_bundles_of_each_key_are_published() {
    let desk = Desk::new();
    other_key(&desk);
    let (other, passphrase) = (desk.at("aaa.key"), desk.at("passphrase"));
    let mut options = desk.options();
    options.extend(["--key", &other, "--passphrase-file", &passphrase].map(str::to_owned));
    let studio = Studio::with(desk.flock.path(), &options.iter().map(String::as_str).collect::<Vec<_>>());
    let page = Page::open(&Browser::start(), &studio.address(), DESK);
    page.until("the studio is open", "document.body.dataset.view === 'wall'");
    page.ask("location.hash = '#/ship'");
    let news =
        "[...document.querySelectorAll('.view.ship .cards .card')].at(-1)?.querySelector('.figure')?.textContent";
    page.until("all is new", &format!("{news} === 'everything'"));
    is_done(&studio, &studio.post("/api/ship/pack", &json!({ "key": "artist", "units": ["lobby"] })));
    rests(&studio);
    page.until("nothing is new", &format!("{news} === 'nothing'"));
    let wants = json!([{ "do": "want", "sheep": "s003", "value": 4.0 }]);
    studio.edit(&studio.get("/api/state")["revision"], &wants);
    page.until("nobody knows what is new", &format!("{news} === 'not known'"));
    page.click_named("Check");
    page.until("the manifest is new", &format!("{news} === '1 change'"));
    let stick = fs::canonicalize(desk.at("stick")).unwrap();
    is_done(&studio, &studio.post("/api/ship/publish", &json!({ "to": desk.at("stick") })));
    assert!(stick.join("seals/lobby.seal").exists());
    let nowhere = studio.ask("POST", "/api/ship/publish", Some(&json!({ "to": "/elsewhere" })));
    assert_eq!(nowhere.status, 422, "{nowhere:?}");
    let choices = page.ask("[...document.querySelector('#ship-to').options].map(one => one.value)");
    assert!(choices.as_array().unwrap().contains(&json!(desk.at("stick"))), "{choices}");
}

#[test]
fn a_job_that_is_paused_by_itself_waits_while_the_others_are_made() {
    let desk = Desk::new();
    let studio = Studio::of(desk.flock.path());
    studio.post("/api/jobs/pause", &json!({ "paused": true }));
    let render = |sheep: &str| {
        fs::remove_file(desk.flock.path().join(format!("loops/{sheep}.mp4"))).unwrap();
        let told = studio.post("/api/jobs", &json!({ "kind": "render", "sheep": sheep }));
        let own = json!({ "job": told["jobs"][0] });
        assert_eq!(own["job"]["about"], json!({ "sheep": sheep }));
        own
    };
    let (other, paused) = (render("s001"), render("s002"));
    let page = Page::open(&Browser::start(), &studio.address(), DESK);
    page.until("the studio is open", "document.body.dataset.view === 'wall'");
    wait::until("the pictures of all sheep are made", WORK_S, || {
        let jobs = studio.get("/api/jobs")["jobs"].take();
        jobs.as_array().unwrap().iter().filter(|job| job["kind"] == "strip" && job["state"] == "done").count() == 5
    });
    page.ask("location.hash = '#/jobs'");
    let row = |at: usize| format!("document.querySelectorAll('ol.jobs .job')[{at}]?.getAttribute('aria-label')");
    page.until("all is listed", &format!("{} === 'pictures of sheep, done'", row(2)));
    page.click_named("Pause the loop of s002");
    wait::until("it is paused", 60, || job(&studio, &paused)["paused"] == true);
    // The pointer is on the list, so that no row may change its place.
    page.ask("window.moves = 0; new MutationObserver(() => moves++).observe(document.querySelector('ol.jobs'), { childList: true })");
    studio.post("/api/jobs/pause", &json!({ "paused": false }));
    is_done(&studio, &other);
    assert_eq!((&job(&studio, &paused)["state"], &job(&studio, &paused)["paused"]), (&json!("queued"), &json!(true)));
    page.until("the page knows that the other is done", &format!("{} === 'the loop of s001, done'", row(0)));
    assert_eq!(page.ask("moves"), 0);
    // Elsewhere, what is left to do comes first; its row has the focus before and after.
    page.ask("document.querySelectorAll('ol.jobs .job')[1].focus()");
    page.point((5.0, 5.0));
    page.until("what is paused comes first", &format!("{} === 'the loop of s002, paused'", row(0)));
    assert_eq!(page.ask("document.activeElement.getAttribute('aria-label')"), "the loop of s002, paused");
    page.click_named("Go on with the loop of s002");
    is_done(&studio, &paused);
    let over =
        studio.ask("POST", &format!("/api/jobs/{}/pause", paused["job"]["id"]), Some(&json!({ "paused": true })));
    assert_eq!(over.status, 409, "{over:?}");
}

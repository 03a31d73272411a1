//! Nobody but the artist's own page reads or changes anything.
//!
//! Owns the claims on forged requests, byte by byte and from pages of other origins in a real browser.

use super::browser::Browser;
use super::page::{DESK, Page};
use super::running::Studio;
use super::sheep::ring;
use claims::web::{Behaviour, WebServer};
use serde_json::json;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// A word of the flock, which no answer to a stranger may have.
const SECRET_WORD: &str = "velvet";

/// Every file of a flock, without what the studio keeps for itself.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.filter(|path| path.is_file()).map(|path| (path.clone(), fs::read(path).unwrap())).collect()
}

/// A request that must be refused: what is forged, its status, and its lines.
type Forgery = (&'static str, u16, String);

/// The headers of a change that is in order, and a body.
const ORIGIN: &str = "Origin: {origin}\r\n";
const KIND: &str = "Content-Type: application/json\r\n";
const SECRET: &str = "X-Studio-Secret: {secret}\r\n";
const COOKIE: &str = "Host: {host}\r\nCookie: {cookie}\r\n";
const EDIT: &str = r#"{"revision":null,"gesture":null,"edits":[{"do":"want","sheep":"s1","value":7}],"force":true}"#;

fn read(line: &str, headers: &str) -> String {
    format!("{line} HTTP/1.1\r\n{headers}\r\n")
}

fn change(line: &str, headers: &str, body: &str) -> String {
    format!("{line} HTTP/1.1\r\n{COOKIE}{headers}Content-Length: {}\r\n\r\n{body}", body.len())
}

/// A change of the flock with these headers.
fn edits(headers: &[&str]) -> String {
    change("POST /api/edits", &headers.concat(), EDIT)
}

/// Other names of this machine, and what only a page of this session knows.
fn names_and_cookies() -> Vec<Forgery> {
    vec![
        (
            "a name that was rebound to this machine",
            421,
            read("GET /api/state", "Host: evil.example:{port}\r\nCookie: {cookie}\r\n"),
        ),
        ("the same for the page", 421, read("GET /", "Host: evil.example:{port}\r\n")),
        ("the name of another port", 421, read("GET /api/state", "Host: 127.0.0.1:1\r\nCookie: {cookie}\r\n")),
        ("a name without a port", 421, read("GET /api/state", "Host: 127.0.0.1\r\nCookie: {cookie}\r\n")),
        (
            "our name as the beginning of another",
            421,
            read("GET /api/state", "Host: {host}.evil.example\r\nCookie: {cookie}\r\n"),
        ),
        ("no name", 421, "GET /api/state HTTP/1.0\r\nCookie: {cookie}\r\n\r\n".to_owned()),
        ("another name in the address", 421, read("GET http://evil.example/api/state", COOKIE)),
        ("no cookie", 401, read("GET /api/state", "Host: {host}\r\n")),
        (
            "a guessed cookie",
            401,
            read("GET /api/state", &format!("Host: {{host}}\r\nCookie: dreams-studio-{{port}}={}\r\n", "0".repeat(32))),
        ),
        ("events without a cookie", 401, read("GET /events", "Host: {host}\r\n")),
        ("pictures without a cookie", 401, read("GET /media/strip/s1", "Host: {host}\r\n")),
        (
            "a guessed token",
            401,
            change("POST /session", &[ORIGIN, KIND].concat(), r#"{"token":"00000000000000000000000000000000"}"#),
        ),
        (
            "the token from another origin",
            403,
            change("POST /session", &["Origin: http://evil.example\r\n", KIND].concat(), r#"{"token":"{token}"}"#),
        ),
    ]
}

/// Pages from elsewhere.
fn origins() -> Vec<Forgery> {
    vec![
        ("no origin", 403, edits(&[KIND, SECRET])),
        ("another origin", 403, edits(&["Origin: http://evil.example\r\n", KIND, SECRET])),
        ("the origin of a file", 403, edits(&["Origin: null\r\n", KIND, SECRET])),
        ("the origin of another port", 403, edits(&["Origin: http://127.0.0.1:1\r\n", KIND, SECRET])),
        ("our origin with another scheme", 403, edits(&["Origin: https://{host}\r\n", KIND, SECRET])),
        (
            "a browser that says it is from elsewhere",
            403,
            edits(&[ORIGIN, KIND, SECRET, "Sec-Fetch-Site: cross-site\r\n"]),
        ),
        (
            "a browser that says it is from another port",
            403,
            edits(&[ORIGIN, KIND, SECRET, "Sec-Fetch-Site: same-site\r\n"]),
        ),
        ("no secret", 403, edits(&[ORIGIN, KIND])),
        ("a guessed secret", 403, edits(&[ORIGIN, KIND, "X-Studio-Secret: 00000000000000000000000000000000\r\n"])),
    ]
}

/// Types, methods, paths and sizes.
fn forms() -> Vec<Forgery> {
    let large = format!("{{\"marks\":\"{}\"}}", "x".repeat(1_100_000));
    let long_head = format!("{COOKIE}X-Long: {}\r\n", "x".repeat(1_000_000));
    vec![
        ("a form's type", 415, edits(&[ORIGIN, SECRET, "Content-Type: application/x-www-form-urlencoded\r\n"])),
        ("the type that needs no leave", 415, edits(&[ORIGIN, SECRET, "Content-Type: text/plain\r\n"])),
        ("no type", 415, edits(&[ORIGIN, SECRET])),
        ("a change by reading", 405, read("GET /api/undo", COOKIE)),
        ("a method that no page uses", 405, change("PUT /api/edits", &[ORIGIN, KIND, SECRET].concat(), EDIT)),
        (
            "a question for leave",
            405,
            read(
                "OPTIONS /api/edits",
                "Host: {host}\r\nOrigin: http://evil.example\r\nAccess-Control-Request-Method: POST\r\n",
            ),
        ),
        ("a path out of the page's folder", 404, read("GET /app/../../flock.toml", COOKIE)),
        ("the same in disguise", 404, read("GET /app/%2e%2e/%2e%2e/flock.toml", COOKIE)),
        ("a path for a picture", 404, read("GET /media/strip/..%2f..%2fflock.toml", COOKIE)),
        ("a body of more than a megabyte", 413, change("POST /api/marks", &[ORIGIN, KIND, SECRET].concat(), &large)),
        ("a head without end", 431, read("GET /api/state", &long_head)),
    ]
}

fn forgeries() -> Vec<Forgery> {
    [names_and_cookies(), origins(), forms()].concat()
}

#[test]
fn a_forged_request_reads_and_changes_nothing() {
    let flock = ring(SECRET_WORD, 4, 1);
    let studio = Studio::of(flock.path());
    let (before, revision) = (files(flock.path()), studio.get("/api/state")["revision"].clone());
    for (forged, status, request) in forgeries() {
        let answer = studio.forge(&request);
        assert_eq!(answer.status, status, "{forged}: {} {}", answer.head, String::from_utf8_lossy(&answer.body));
        assert!(!answer.head.contains("access-control-"), "{forged}: {}", answer.head);
        assert!(!String::from_utf8_lossy(&answer.body).contains(SECRET_WORD), "{forged} is told of the flock");
        assert_eq!(files(flock.path()), before, "{forged}");
    }
    assert_eq!(studio.get("/api/state")["revision"], revision);
    // What is forged above is only one thing away from what is right.
    studio.edit(&revision, &json!([{ "do": "want", "sheep": "s1", "value": 7.0 }]));
    assert!(studio.manifest().contains("want = 7.0"), "{}", studio.manifest());
}

#[test]
fn every_answer_forbids_what_no_page_of_ours_needs() {
    let flock = ring(SECRET_WORD, 4, 1);
    let studio = Studio::of(flock.path());
    for path in ["/", "/app/app.js", "/api/state", "/media/strip/nothing", "/nowhere"] {
        let answer = studio.ask("GET", path, None);
        let policy = answer.header("content-security-policy").unwrap_or_default();
        let mut wanted = vec![
            "default-src 'none'",
            "script-src 'self'",
            "style-src 'self'",
            "img-src 'self' blob: data:",
            "media-src 'self' blob:",
            "connect-src 'self'",
            "frame-ancestors 'none'",
        ];
        wanted.retain(|part| !policy.split("; ").any(|said| said == *part));
        assert!(wanted.is_empty(), "{path}: `{policy}` lacks {wanted:?}");
        for (name, value) in [
            ("cross-origin-resource-policy", "same-origin"),
            ("cross-origin-opener-policy", "same-origin"),
            ("x-content-type-options", "nosniff"),
            ("referrer-policy", "no-referrer"),
        ] {
            assert_eq!(answer.header(name), Some(value), "{path}: {}", answer.head);
        }
    }
}

/// What a page from elsewhere tries, at the studio's origin `STUDIO`. It tells what it could read.
const STRANGER: &str = r"(async () => {
  const read = []
  const attempt = async (what, action) => { try { const got = await action(); if (got) read.push(what + ': ' + got) } catch { } }
  const change = type => ({ method: 'POST', credentials: 'include', headers: { 'Content-Type': type },
    body: JSON.stringify({ revision: null, gesture: null, edits: [{ do: 'want', sheep: 's1', value: 7 }], force: true }) })
  const element = (tag, attribute, path) => new Promise(done => {
    const made = document.createElement(tag)
    made.onload = () => done(tag === 'iframe' ? made.contentDocument?.body?.innerText : tag + ' loaded')
    made.onerror = () => done('')
    made[attribute] = STUDIO + path
    document.body.append(made)
    setTimeout(() => done(''), 3000)
  })
  await attempt('fetch', async () => (await fetch(STUDIO + '/api/state', { credentials: 'include' })).text())
  await attempt('blind fetch', async () => (await fetch(STUDIO + '/api/state', { mode: 'no-cors', credentials: 'include' })).text())
  await attempt('edit', async () => (await fetch(STUDIO + '/api/edits', change('application/json'))).text())
  await attempt('plain edit', async () => (await fetch(STUDIO + '/api/edits', { ...change('text/plain'), mode: 'no-cors' })).text())
  await attempt('beacon', () => navigator.sendBeacon(STUDIO + '/api/undo', '{}') && '')
  await attempt('script', () => element('script', 'src', '/app/app.js'))
  await attempt('image', () => element('img', 'src', '/media/strip/nothing'))
  await attempt('frame', () => element('iframe', 'src', '/'))
  await attempt('events', () => new Promise(done => {
    const events = new EventSource(STUDIO + '/events', { withCredentials: true })
    events.onopen = () => done('open')
    events.onerror = () => done('')
  }))
  await attempt('form', () => new Promise(done => {
    const form = Object.assign(document.createElement('form'), { method: 'POST', action: STUDIO + '/api/undo', target: 'hole', enctype: 'text/plain' })
    const hole = Object.assign(document.createElement('iframe'), { name: 'hole' })
    document.body.append(hole, form)
    hole.onload = () => done(hole.contentDocument?.body?.innerText)
    form.submit()
    setTimeout(() => done(''), 3000)
  }))
  return read
})()";

#[test]
fn a_page_from_elsewhere_reads_and_changes_nothing() {
    let flock = ring(SECRET_WORD, 4, 1);
    let studio = Studio::of(flock.path());
    let browser = Browser::start();
    // The artist's own page is open beside it, with its cookie.
    let own = Page::open(&browser, &studio.address(), DESK);
    own.until("the studio's page shows the flock", &format!("document.body.innerText.includes('{SECRET_WORD}')"));
    let before = files(flock.path());
    let elsewhere = tempfile::tempdir().unwrap();
    fs::write(elsewhere.path().join("page.html"), "<!doctype html><title>elsewhere</title><body>").unwrap();
    let server = WebServer::serve(elsewhere.path(), Behaviour::Good);
    // Another port of this machine is the same site, so that it is sent the cookie; another name is not.
    let foreign = server.url().replace("127.0.0.1", "evil.example");
    for from in [server.url(), foreign] {
        let page = Page::open(&browser, &format!("{from}/page.html"), DESK);
        let read = page.ask(&STRANGER.replace("STUDIO", &format!("'{}'", studio.origin())));
        assert_eq!(read, json!([]), "from {from}");
        assert_eq!(files(flock.path()), before, "from {from}");
    }
    // A name that leads to this machine is of its own origin in the eyes of the browser, which then asks for no leave.
    let rebound = Page::open(&browser, &format!("http://evil.example:{}/", studio.port), DESK);
    let seen = rebound.ask("fetch('/api/state').then(answer => answer.status)");
    assert_eq!(seen, 421, "the browser is told that it has the wrong machine");
    let text = rebound.ask("document.documentElement.innerHTML");
    assert!(!text.to_string().contains(SECRET_WORD), "{text}");
    assert_eq!(files(flock.path()), before);
}

#[test]
fn the_address_of_ipv6_is_fenced_like_that_of_ipv4() {
    let folder = ring(SECRET_WORD, 3, 0);
    let studio = Studio::of(folder.path());
    let asked = |host: &str, cookie: &str| {
        let request = read("GET /api/state", &format!("Host: {host}\r\nCookie: {cookie}\r\n"));
        let answer = studio.forge_at("::1", &request);
        (answer.status, String::from_utf8_lossy(&answer.body).contains(SECRET_WORD))
    };
    assert_eq!(asked("[::1]:{port}", "{cookie}"), (200, true));
    assert_eq!(asked("[::1]:{port}", "none"), (401, false));
    assert_eq!(asked("evil.example:{port}", "{cookie}"), (421, false));
}

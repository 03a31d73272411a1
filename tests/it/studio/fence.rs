//! Nobody but the artist's own page reads or changes anything.
//!
//! Owns the claims on forged requests, byte by byte. Pages of other origins in a real browser are in
//! `slow/studio/stranger.rs`.

use claims::studio::running::Studio;
use claims::studio::sheep::{SECRET_WORD, files, ring};
use serde_json::json;
use std::fs;
use std::path::Path;

/// A request that must be refused: what is forged, its status, and its lines.
type Forgery = (&'static str, u16, String);

/// The headers of a change that is in order, and a body.
const ORIGIN: &str = "Origin: {origin}\r\n";
const KIND: &str = "Content-Type: application/json\r\n";
const SECRET: &str = "X-Studio-Secret: {secret}\r\n";
const COOKIE: &str = "Host: {host}\r\nCookie: {cookie}\r\n";
/// The source of the routes, from the folder of the claims.
const ROUTES: &str = "../flock-tools/studio/src/routes";
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
        ("the flock with the cookie alone, which goes to every port", 403, read("GET /api/state", COOKIE)),
        ("events with the cookie alone", 403, read("GET /events", COOKIE)),
        ("pictures with the cookie alone", 403, read("GET /media/strip/s1", COOKIE)),
        ("the flock with what pictures are asked for with", 403, read("GET /api/state?look={look}", COOKIE)),
        (
            "a guessed address of a picture",
            403,
            read("GET /media/strip/s1?look=00000000000000000000000000000000", COOKIE),
        ),
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
        ("a change by reading", 405, read("GET /api/undo", &[COOKIE, SECRET].concat())),
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

/// The paths of all routes that are read, with a name that nothing has in the place of names.
fn read_routes() -> Vec<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(ROUTES);
    let texts = fs::read_dir(folder).unwrap().map(|file| fs::read_to_string(file.unwrap().path()).unwrap());
    let whole: String = texts.collect();
    let routes = whole.split(".route(\"").skip(1).filter_map(|rest| rest.split_once("\", get("));
    let paths = routes.map(|(path, _)| path.replace("{key}", "none").replace("{id}", "none"));
    let mut all: Vec<String> = paths.filter(|path| !path.contains('"')).collect();
    all.push("/events".to_owned());
    all
}

#[test]
fn whoever_has_the_cookie_alone_reads_no_route() {
    let flock = ring(SECRET_WORD, 4, 1);
    let studio = Studio::of(flock.path());
    let all = read_routes();
    assert!(all.len() >= 18 && all.contains(&"/media/preview/none".to_owned()), "{all:?}");
    for path in all {
        let answer = studio.forge(&read(&format!("GET {path}"), COOKIE));
        let why = String::from_utf8_lossy(&answer.body).into_owned();
        assert!(answer.status == 403 && why.contains("only a page of this session knows"), "{path}: {why}");
        if path == "/events" {
            // The stream does not end.
            continue;
        }
        let status = studio.ask("GET", &path, None).status;
        assert!(![401, 403, 500].contains(&status), "{path} with the secret is answered {status}");
        assert!(!path.starts_with("/api/") || status == 200 || path == "/api/walk", "{path}: {status}");
    }
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

#[test]
fn the_address_of_ipv6_is_fenced_like_that_of_ipv4() {
    let folder = ring(SECRET_WORD, 3, 0);
    let studio = Studio::of(folder.path());
    let asked = |host: &str, cookie: &str| {
        let request = read("GET /api/state", &format!("Host: {host}\r\nCookie: {cookie}\r\n{SECRET}"));
        let answer = studio.forge_at("::1", &request);
        (answer.status, String::from_utf8_lossy(&answer.body).contains(SECRET_WORD))
    };
    assert_eq!(asked("[::1]:{port}", "{cookie}"), (200, true));
    assert_eq!(asked("[::1]:{port}", "none"), (401, false));
    assert_eq!(asked("evil.example:{port}", "{cookie}"), (421, false));
}

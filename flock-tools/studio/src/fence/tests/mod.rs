//! What a page from elsewhere, another user and a broken client get: nothing.
//! Every request is sent as bytes over a real connection to a server with the fence around it.

mod crowds;

use std::io::{Read, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use axum::Router;
use axum::body::Bytes;
use axum::routing::{delete, get, post};
use tokio::runtime::Runtime;
use tokio::sync::oneshot;

use super::{Fence, MOST_BYTES, Secrets, layer};
use crate::page::Page;
use crate::server::Server;

/// Has the server close the connection after its answer.
const CLOSE: &str = "Connection: close\r\n";
/// How soon every request is answered, whoever else is there: less than the fence gives it.
const SOON: Duration = Duration::from_secs(5);

/// A studio that counts what it lets through.
struct Studio {
    port: u16,
    reads: Arc<AtomicUsize>,
    changes: Arc<AtomicUsize>,
    fence: Arc<Fence>,
    stop: Option<oneshot::Sender<()>>,
    runtime: Runtime,
}

/// A request before it is sent.
#[derive(Clone)]
struct Request {
    method: &'static str,
    path: String,
    headers: Vec<(String, String)>,
    body: String,
}

/// What came back.
#[derive(Debug)]
struct Answer {
    status: u16,
    head: String,
    body: String,
}

impl Studio {
    fn start() -> Self {
        let server = Server::bind(0).unwrap();
        let (port, runtime) = (server.port(), Server::runtime().unwrap());
        let secrets = Secrets::of([0xabc << 100, 0xdef << 100, 0xfed << 100, 0xcba << 100]);
        let fence = Arc::new(Fence::new(port, secrets));
        let (reads, changes) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicUsize::new(0)));
        let count = |counter: &Arc<AtomicUsize>| {
            let counter = Arc::clone(counter);
            move |_: Bytes| async move {
                counter.fetch_add(1, Ordering::SeqCst);
                "the flock"
            }
        };
        let inside = Router::new()
            .route("/api/state", get(count(&reads)))
            .route("/media/strip/{key}", get(count(&reads)))
            .route("/events", get(count(&reads)))
            .route("/api/edits", post(count(&changes)))
            .route("/api/jobs/{id}", delete(count(&changes)))
            .merge(Page::Embedded.router());
        let router = layer(inside, Arc::clone(&fence));
        let (stop, stopped) = oneshot::channel();
        runtime.spawn(server.serve(router, async { drop(stopped.await) }));
        Self { port, reads, changes, fence, stop: Some(stop), runtime }
    }

    fn host(&self) -> String {
        format!("127.0.0.1:{}", self.port)
    }

    /// What our own page sends.
    fn request(&self, method: &'static str, path: &str, body: &str) -> Request {
        let host = self.host();
        let mut headers = vec![
            ("Host".to_owned(), host.clone()),
            ("Cookie".to_owned(), format!("other=1; {}={}", self.fence.cookie_name(), self.fence.secrets.cookie)),
            ("Sec-Fetch-Site".to_owned(), "same-origin".to_owned()),
            ("X-Studio-Secret".to_owned(), self.fence.secrets.page.clone()),
        ];
        if method != "GET" {
            headers.push(("Origin".to_owned(), format!("http://{host}")));
            headers.push(("Content-Type".to_owned(), "application/json".to_owned()));
        }
        Request { method, path: path.to_owned(), headers, body: body.to_owned() }
    }

    fn ask(&self, request: &Request) -> Answer {
        let Request { method, path, headers, body } = request;
        let headers: String = headers.iter().flat_map(|(name, value)| [name, ": ", value, "\r\n"]).collect();
        let length = body.len();
        let text = format!("{method} {path} HTTP/1.1\r\n{headers}Content-Length: {length}\r\n{CLOSE}\r\n{body}");
        self.send(&text)
    }

    fn send(&self, text: &str) -> Answer {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(SOON)).unwrap();
        // A server that refuses early may close before it has read all.
        let _ = stream.write_all(text.as_bytes());
        let mut bytes = Vec::new();
        let _ = stream.read_to_end(&mut bytes);
        let text = String::from_utf8_lossy(&bytes).into_owned();
        let (head, body) = text.split_once("\r\n\r\n").unwrap_or((&text, ""));
        let status = head.split(' ').nth(1).and_then(|status| status.parse().ok()).unwrap_or(0);
        Answer { status, head: head.to_ascii_lowercase(), body: body.to_owned() }
    }

    fn counts(&self) -> (usize, usize) {
        (self.reads.load(Ordering::SeqCst), self.changes.load(Ordering::SeqCst))
    }
}

impl Drop for Studio {
    fn drop(&mut self) {
        let _ = self.stop.take().unwrap().send(());
        let _ = &self.runtime;
    }
}

impl Request {
    /// With this header instead, or without it if there is no value.
    fn with(mut self, name: &str, value: Option<&str>) -> Self {
        self.headers.retain(|(known, _)| known != name);
        self.headers.extend(value.map(|value| (name.to_owned(), value.to_owned())));
        self
    }

    fn and(mut self, name: &str, value: &str) -> Self {
        self.headers.push((name.to_owned(), value.to_owned()));
        self
    }
}

/// Forged requests, each with the status that it gets.
fn forged(studio: &Studio) -> Vec<(&'static str, Request, u16)> {
    let (port, own) = (studio.port, format!("http://{}", studio.host()));
    let read = || studio.request("GET", "/api/state", "");
    let edit = || studio.request("POST", "/api/edits", "{}");
    let job = || studio.request("DELETE", "/api/jobs/1", "{}");
    let at = |path: &str| studio.request("GET", path, "");
    let evil = |name: &str| format!("{name}:{port}");
    let cookie = |value: &str| format!("{}={value}", studio.fence.cookie_name());
    let mut all = vec![
        ("a name that leads here", read().with("Host", Some(&evil("evil.example"))), 421),
        ("a name that begins like ours", read().with("Host", Some(&evil("127.0.0.1.evil.example"))), 421),
        ("a name that ends like ours", edit().with("Host", Some(&evil("evil.localhost"))), 421),
        ("our address without the port", read().with("Host", Some("127.0.0.1")), 421),
        ("another port", read().with("Host", Some("127.0.0.1:1")), 421),
        ("another address of this machine", read().with("Host", Some(&evil("127.0.0.2"))), 421),
        ("two hosts", read().and("Host", "evil.example"), 421),
        ("no host", read().with("Host", None), 421),
        (
            "a rebound page that changes",
            edit().with("Host", Some(&evil("a.b"))).with("Origin", Some("http://a.b")),
            421,
        ),
        ("no cookie", read().with("Cookie", None), 401),
        ("a wrong cookie", read().with("Cookie", Some(&cookie(&"0".repeat(32)))), 401),
        ("a part of the cookie", read().with("Cookie", Some(&cookie("0"))), 401),
        ("a media file without a cookie", at("/media/strip/abc").with("Cookie", None), 401),
        ("a wrong cookie before ours", read().with("Cookie", Some(&format!("{}; {}", cookie("1"), cookie("1")))), 401),
        ("an image on another page", read().with("Sec-Fetch-Site", Some("cross-site")), 403),
        ("a page at another port", read().with("Sec-Fetch-Site", Some("same-site")), 403),
        ("a fetch of another origin", read().and("Origin", "http://evil.example"), 403),
        ("a change of another origin", edit().with("Origin", Some("http://evil.example")), 403),
        ("a change of no origin", edit().with("Origin", None), 403),
        ("a change of a hidden origin", edit().with("Origin", Some("null")), 403),
        ("a change of another port", edit().with("Origin", Some("http://127.0.0.1:1")), 403),
        ("a change of our other name", edit().with("Origin", Some(&format!("http://localhost:{port}"))), 403),
        ("a change over TLS", edit().with("Origin", Some(&own.replace("http", "https"))), 403),
        ("two origins", edit().and("Origin", "http://evil.example"), 403),
        ("a form of another site", edit().with("Sec-Fetch-Site", Some("cross-site")), 403),
        ("a change without a page", edit().with("Sec-Fetch-Site", Some("none")), 403),
        ("a change without the secret", edit().with("X-Studio-Secret", None), 403),
        ("a change with the token", edit().with("X-Studio-Secret", Some(&studio.fence.secrets.token)), 403),
        ("a change with the cookie", job().with("X-Studio-Secret", Some(&studio.fence.secrets.cookie)), 403),
        ("a form's type", edit().with("Content-Type", Some("application/x-www-form-urlencoded")), 415),
        ("a plain text", edit().with("Content-Type", Some("text/plain")), 415),
        ("a type that contains ours", edit().with("Content-Type", Some("text/plain; application/json")), 415),
        ("no type", job().with("Content-Type", None), 415),
        ("a way up", at("/app/../../flock.toml"), 404),
        ("a hidden way up", at("/media/strip/%2e%2e%2fflock.toml"), 404),
        ("a way of another system", at("/media/strip/..\\flock.toml"), 404),
        ("two slashes", at("//evil.example/api/state"), 404),
        ("too much", studio.request("POST", "/api/edits", &" ".repeat(MOST_BYTES + 1)), 413),
        ("a path that is too long", at(&format!("/api/state?{}", "a".repeat(4000))), 404),
    ];
    for method in ["OPTIONS", "PUT", "PATCH", "TRACE"] {
        all.push(("a method", Request { method, ..edit() }, 405));
    }
    all.push(("a read that changes", Request { path: "/api/edits".to_owned(), ..read() }, 405));
    all
}

/// Requests with the cookie, which a browser sends to every port, and without what only our own page was told.
fn without_a_secret(studio: &Studio) -> Vec<(&'static str, Request, u16)> {
    let Secrets { token, page, look, .. } = &studio.fence.secrets;
    let bare = |path: &str| studio.request("GET", path, "").with("X-Studio-Secret", None);
    let looks = |path: &str, look: &str| bare(&format!("{path}?at=1&look={look}"));
    vec![
        ("a read with the cookie alone", bare("/api/state"), 403),
        ("a read with the token", studio.request("GET", "/api/state", "").with("X-Studio-Secret", Some(token)), 403),
        ("a read with two secrets", studio.request("GET", "/api/state", "").and("X-Studio-Secret", "0"), 403),
        ("a read with what only elements ask with", looks("/api/state", look), 403),
        ("a picture with the cookie alone", bare("/media/strip/abc"), 403),
        ("a picture with the secret in its address", looks("/media/strip/abc", page), 403),
        ("a picture with a part of what it needs", looks("/media/strip/abc", &look[1..]), 403),
        ("events with the cookie alone", bare("/events"), 403),
        ("a picture without the cookie", looks("/media/strip/abc", look).with("Cookie", None), 401),
        (
            "a change with what only elements ask with",
            studio.request("POST", &format!("/api/edits?look={look}"), "{}").with("X-Studio-Secret", None),
            403,
        ),
    ]
}

#[test]
fn a_page_from_elsewhere_reads_and_changes_nothing() {
    let studio = Studio::start();
    let forged = [forged(&studio), without_a_secret(&studio)].concat();
    assert!(forged.len() >= 24, "{}", forged.len());
    for (what, request, status) in &forged {
        let answer = studio.ask(request);
        assert_eq!(answer.status, *status, "{what}: {answer:?}");
        assert!(!answer.body.contains("the flock"), "{what}: {answer:?}");
        assert!(!answer.head.contains("access-control"), "{what}: {answer:?}");
    }
    assert_eq!(studio.counts(), (0, 0));
}

#[test]
fn an_absolute_address_of_another_host_and_a_head_that_never_ends_are_refused() {
    let studio = Studio::start();
    let absolute = format!("GET http://evil.example/api/state HTTP/1.1\r\nHost: {}\r\n{CLOSE}\r\n", studio.host());
    assert_eq!(studio.send(&absolute).status, 421);
    let endless = format!("GET / HTTP/1.1\r\nHost: {}\r\nX: {}\r\n{CLOSE}\r\n", studio.host(), "a".repeat(70_000));
    assert_eq!(studio.send(&endless).status, 431);
    assert_eq!(studio.counts(), (0, 0));
}

#[test]
fn our_own_page_reads_and_changes_under_each_of_our_names() {
    let studio = Studio::start();
    for name in ["127.0.0.1", "localhost", "LocalHost", "[::1]"] {
        let host = format!("{name}:{}", studio.port);
        let origin = format!("http://{}", host.to_ascii_lowercase());
        let read = studio.request("GET", "/api/state", "").with("Host", Some(&host));
        let edit = studio.request("POST", "/api/edits", "{}");
        let edit = edit.with("Host", Some(&host)).with("Origin", Some(&origin));
        let job = studio.request("DELETE", "/api/jobs/1", "");
        let job = job.with("Host", Some(&host)).with("Origin", Some(&origin));
        let typed = edit.clone().with("Content-Type", Some("application/json; charset=utf-8"));
        for request in [read, edit, job, typed] {
            assert_eq!(studio.ask(&request).status, 200, "{name}: {}", request.method);
        }
    }
    assert_eq!(studio.counts(), (4, 12));
}

#[test]
fn elements_of_our_own_page_ask_for_pictures_and_events_without_a_header() {
    let studio = Studio::start();
    for path in ["/media/strip/abc", "/events"] {
        for query in ["look=", "from=7&look="] {
            let path = format!("{path}?{query}{}", studio.fence.secrets.look);
            assert_eq!(
                studio.ask(&studio.request("GET", &path, "").with("X-Studio-Secret", None)).status,
                200,
                "{path}"
            );
        }
    }
    assert_eq!(studio.counts(), (4, 0));
}

#[test]
fn the_token_of_the_address_and_no_other_begins_a_session_that_reads_and_changes() {
    let studio = Studio::start();
    let token = studio.fence.address().rsplit_once('#').unwrap().1.to_owned();
    let begin = |token: &str| {
        let request = studio.request("POST", "/session", &format!("{{\"token\":\"{token}\"}}"));
        studio.ask(&request.with("Cookie", None).with("X-Studio-Secret", None))
    };
    for wrong in ["", &token[1..], &token.to_uppercase(), &"0".repeat(32)] {
        let answer = begin(wrong);
        assert!(answer.status == 401 && !answer.head.contains("set-cookie"), "{wrong}: {answer:?}");
    }
    let answer = begin(&token);
    assert_eq!(answer.status, 200, "{answer:?}");
    let cookie = answer.head.lines().find_map(|line| line.strip_prefix("set-cookie: ")).unwrap();
    assert!(cookie.contains("; httponly; samesite=strict; path=/"), "{cookie}");
    let told: serde_json::Value = serde_json::from_str(&answer.body).unwrap();
    let cookie = cookie.split(';').next().unwrap().to_owned();
    let edit = studio.request("POST", "/api/edits", "{}").with("Cookie", Some(&cookie));
    assert_eq!(studio.ask(&edit.with("X-Studio-Secret", told["secret"].as_str())).status, 200);
    let picture = format!("/media/strip/abc?look={}", told["look"].as_str().unwrap());
    let picture = studio.request("GET", &picture, "").with("Cookie", Some(&cookie)).with("X-Studio-Secret", None);
    assert_eq!(studio.ask(&picture).status, 200);
    let elsewhere = studio.request("POST", "/session", &format!("{{\"token\":\"{token}\"}}"));
    assert_eq!(studio.ask(&elsewhere.with("Origin", Some("http://evil.example"))).status, 403);
}

#[test]
fn every_answer_forbids_what_is_from_elsewhere_and_every_refusal_is_a_sentence() {
    let studio = Studio::start();
    let refused = studio.request("GET", "/api/none", "");
    let answers = [("/", 200), ("/app/none.js", 404), ("/api/state", 200), ("/api/none", 404), ("/api/edits", 405)];
    for (path, status) in answers {
        let answer = studio.ask(&studio.request("GET", path, ""));
        assert_eq!(answer.status, status, "{path}");
        for header in [
            "content-security-policy: default-src 'none'; script-src 'self'; style-src 'self';",
            "frame-ancestors 'none'",
            "cross-origin-resource-policy: same-origin",
            "cross-origin-opener-policy: same-origin",
            "x-content-type-options: nosniff",
            "referrer-policy: no-referrer",
        ] {
            assert!(answer.head.contains(header), "{path} lacks `{header}`: {}", answer.head);
        }
    }
    let body: serde_json::Value = serde_json::from_str(&studio.ask(&refused).body).unwrap();
    assert_eq!(body["error"], "there is nothing of this name");
}

#[test]
fn the_page_itself_may_be_opened_by_a_link_and_holds_no_secret() {
    let studio = Studio::start();
    let link = studio.request("GET", "/", "").with("Cookie", None).with("Sec-Fetch-Site", Some("cross-site"));
    let answer = studio.ask(&link.clone().and("Sec-Fetch-Mode", "navigate"));
    assert_eq!(answer.status, 200);
    let Secrets { token, cookie, page, look } = &studio.fence.secrets;
    for secret in [token, cookie, page, look] {
        assert!(!answer.body.contains(secret.as_str()) && !answer.head.contains(secret.as_str()));
    }
    assert_eq!(studio.ask(&link.and("Sec-Fetch-Mode", "no-cors")).status, 403);
}

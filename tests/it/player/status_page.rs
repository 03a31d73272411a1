//! The status page, for an installer, a monitoring system and a browser.
//!
//! Owns the claims on its addresses, and on how a browser shows it.

use crate::flocks::SMALL;
use crate::player::flock_switch::edition;
use crate::player_run::{PlayerRun, RunningPlayer};
use crate::programs::{output, succeed};
use crate::updates::sticks::Unit;
use std::fs;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

/// An answer of the page: head and body.
pub(crate) struct Answer {
    head: String,
    pub(crate) body: Vec<u8>,
}

impl Answer {
    fn text(&self) -> String {
        String::from_utf8(self.body.clone()).unwrap()
    }
}

/// How long the page may take to answer.
const PATIENCE: Duration = Duration::from_mins(1);

/// Requests a page from `socket`, by HTTP 1.0, so that the body is not encoded.
pub(crate) fn ask(socket: &Path, request: &str) -> Answer {
    let mut stream = UnixStream::connect(socket).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    write!(stream, "{request} HTTP/1.0\r\nHost: unit\r\nConnection: close\r\n\r\n").unwrap();
    let mut all = Vec::new();
    stream.read_to_end(&mut all).expect("the page answers within a minute");
    let end = all.windows(4).position(|four| four == b"\r\n\r\n").expect("a head ends with an empty line");
    Answer { head: String::from_utf8(all[..end].to_vec()).unwrap().to_lowercase(), body: all[end + 4..].to_vec() }
}

/// A player that plays and serves its page at `address`.
fn serving(address: &str) -> (PlayerRun, RunningPlayer) {
    let flock = SMALL.flock();
    let playing = PlayerRun::of(&flock.folder).with(&["--screen", "virtual", "--seed", "1", "--status", address]);
    let mut running = playing.start();
    running.await_lines(40);
    (playing, running)
}

/// The same, on the socket returned.
fn on_a_socket() -> (PlayerRun, RunningPlayer, PathBuf) {
    let socket = tempfile::Builder::new().prefix("page").tempdir().unwrap().keep().join("socket");
    let (playing, running) = serving(&format!("unix:{}", socket.display()));
    (playing, running, socket)
}

/// The same, at the host and port returned.
fn on_a_port() -> (PlayerRun, RunningPlayer, String) {
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let address = format!("127.0.0.1:{port}");
    let (playing, running) = serving(&address);
    (playing, running, address)
}

#[test]
fn the_page_tells_what_is_on_the_glass_in_three_forms_and_shows_it() {
    let (_playing, _running, socket) = on_a_socket();
    let page = ask(&socket, "GET /");
    assert!(page.head.starts_with("http/1.1 200") || page.head.starts_with("http/1.0 200"), "{}", page.head);
    assert!(page.head.contains("text/html"), "{}", page.head);
    let html = page.text();
    assert!(!html.contains("http://") && !html.contains("https://"), "the page needs nothing from elsewhere");

    let status = ask(&socket, "GET /status.json");
    assert!(status.head.contains("application/json"), "{}", status.head);
    let document: serde_json::Value = serde_json::from_str(&status.text()).unwrap();
    assert!(document.is_object(), "{document}");

    let metrics = ask(&socket, "GET /metrics");
    assert!(metrics.head.contains("application/openmetrics-text"), "{}", metrics.head);
    let text = metrics.text();
    assert!(text.ends_with("# EOF\n"), "{text}");
    for family in ["flips", "late", "joins", "faults"] {
        assert!(text.contains(family), "the metrics count {family}: {text}");
    }

    let picture = ask(&socket, "GET /screen.jpg");
    assert!(picture.head.contains("image/jpeg"), "{}", picture.head);
    assert_eq!(pixels(&picture.body, "jpg").len() % (320 * 240 * 3), 0, "the picture is whole");
}

#[test]
fn the_page_refuses_what_it_does_not_have() {
    let (_playing, _running, socket) = on_a_socket();
    assert!(ask(&socket, "GET /no-such-page").head.contains(" 404"));
    assert!(ask(&socket, "POST /").head.contains(" 405"));
}

#[test]
fn the_page_tells_number_and_age_of_the_flock_the_last_contact_and_the_keys() {
    let unit = Unit::new();
    let flock = SMALL.flock();
    unit.maker.vouch(&unit.stick());
    unit.maker.call_back(&unit.stick());
    unit.maker.bundle(&unit.stick(), &edition(&flock, "one"), &[], 7);
    unit.updated(&[]);
    unit.maker.bundle(&unit.stick(), &edition(&flock, "one"), &[], 3);
    assert_eq!(unit.update(&[]).status.code(), Some(1));
    let socket = unit.path("socket");
    let address = format!("unix:{}", socket.display());
    let playing = PlayerRun::of(&unit.path("store/current")).with(&["--screen", "virtual", "--status", &address]);
    let mut running = playing.start();
    running.await_line_with("\"flip\"");
    let facts: serde_json::Value = serde_json::from_slice(&ask(&socket, "GET /status.json").body).unwrap();
    let (generation, contact) = (&facts["generation"], &facts["contact"]);
    let trusted = fs::read_to_string(unit.maker.keys().join("artist.pub")).unwrap();
    let id = trusted.lines().next().unwrap().rsplit(' ').next().unwrap();
    assert_eq!((&generation["sequence"], &generation["is_on_trial"]), (&7.into(), &true.into()), "{facts}");
    assert_eq!((generation["signer"].as_str(), contact["trusted"][0].as_str()), (Some(id), Some(id)), "{facts}");
    assert!(generation["created"].is_string() && generation["age_s"].is_u64() && contact["age_s"].is_u64(), "{facts}");
    let stranger = unit.maker.stranger().to_string();
    assert_eq!((contact["source"].as_str(), contact["revoked"][0].as_str()), (Some("stick"), Some(&*stranger)));
    assert_eq!(contact["result"], "refused: older than what was played");
}

#[test]
fn the_page_is_told_to_nobody_who_was_led_here_by_another_name() {
    let (_playing, _running, address) = on_a_port();
    let port = address.rsplit(':').next().unwrap();
    let status = |host: &str| {
        let mut stream = TcpStream::connect(&address).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        write!(stream, "GET /status.json HTTP/1.1\r\nHost: {host}\r\n\r\n").unwrap();
        let mut told = String::new();
        stream.read_to_string(&mut told).expect("the page answers within a minute");
        told.split(' ').nth(1).unwrap().to_owned()
    };
    let name =
        fs::read_to_string("/etc/hostname").map_or_else(|_| "localhost".to_owned(), |name| name.trim().to_owned());
    for own in
        ["localhost", &address, "127.0.0.1", &format!("LocalHost:{port}"), &name, &format!("{name}.local:{port}")]
    {
        assert_eq!(status(own), "200", "{own}");
    }
    for other in ["example.org", "localhost.example.org", "192.0.2.1", "0.0.0.0", ""] {
        assert_eq!(status(other), "421", "{other}");
    }
}

#[test]
fn the_page_shows_its_picture_in_a_browser_without_a_complaint() {
    let (playing, _running, address) = on_a_port();
    let shot = playing.path("page.png");
    let mut chromium = Command::new("timeout");
    chromium.args(["60", "chromium", "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"]);
    chromium.arg(format!("--user-data-dir={}", playing.path("chromium").display()));
    chromium.args(["--window-size=1280,1200", "--virtual-time-budget=4000", "--enable-logging=stderr"]);
    chromium.arg(format!("--screenshot={}", shot.display())).arg(format!("http://{address}/"));
    let said = output(&mut chromium);
    let console = String::from_utf8_lossy(&said.stderr);
    assert!(said.status.success(), "{console}");
    assert!(!console.contains("CONSOLE"), "the browser's console is empty: {console}");
    let rgb = pixels(&fs::read(&shot).unwrap(), "png");
    let vivid = rgb.chunks(3).filter(|pixel| pixel.iter().max().unwrap() - pixel.iter().min().unwrap() > 120).count();
    assert!(vivid * 50 > rgb.len() / 3, "the test picture's colours are on the page: {vivid} vivid pixels");
}

/// The RGB bytes of a picture, as `ffmpeg` decodes it.
pub(crate) fn pixels(picture: &[u8], kind: &str) -> Vec<u8> {
    let file = tempfile::Builder::new().suffix(&format!(".{kind}")).tempfile().unwrap();
    fs::write(file.path(), picture).unwrap();
    let mut ffmpeg = Command::new("ffmpeg");
    ffmpeg.args(["-v", "error", "-nostdin", "-i"]).arg(file.path());
    ffmpeg.args(["-frames:v", "1", "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]);
    succeed(&mut ffmpeg)
}

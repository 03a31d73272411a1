//! The status page, for an installer, a monitoring system and a browser.
//!
//! Owns the claims on its addresses, and on how a browser shows it.

use claims::editions::edition;
use claims::flocks::SMALL;
use claims::player_run::PlayerRun;
use claims::programs::{output, repository};
use claims::status_page::{PATIENCE, ask, on_a_port, on_a_socket, pixels};
use claims::unit::Unit;
use std::fs;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::process::Command;

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
fn what_a_unit_prints_of_its_status_is_json_and_nothing_else() {
    let (_playing, running, address) = on_a_port();
    let (_, port) = address.split_once(':').unwrap();
    let status = |port: &str| {
        output(Command::new(repository().join("image-build/system/usr/bin/dreams-status")).arg(port)).stdout
    };
    let document: serde_json::Value = serde_json::from_slice(&status(port)).expect("one document");
    assert!(document["flips"].is_u64(), "{document}");
    drop(running);
    assert_eq!(status(port), b"", "nobody answers");
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

//! Updates over HTTP, with good and bad answers.
//!
//! Owns the claims on `dreams-update` with an address: what it requests, how often, and what it rejects. The server is
//! in `tests/rig/web.rs`.

use crate::updates::sticks::object;
use claims::bundle_maker::{files_in, rubbish};
use claims::programs::{output, succeed, votes as counter};
use claims::unit::Unit;
use claims::wait::ends_within;
use claims::web::{Behaviour, WebServer};
use serde_json::{Value, json};
use std::fs;
use std::io::{self, BufRead, BufReader, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::{Arc, Mutex};
use std::thread;
use votes::{Ledger, LedgerId, Store, Visit, Vote};

/// The most bytes of the answers when there is no news.
const SMALL: u64 = 64 << 10;

/// Updates from an address; returns the exit code and the JSON answer, if there is one.
fn fetch(unit: &Unit, url: &str, options: &[&str]) -> (Option<i32>, Value) {
    let said = output(unit.update_from(Some(Path::new(url))).args(options));
    (said.status.code(), serde_json::from_slice(&said.stdout).unwrap_or_default())
}

#[test]
fn a_look_without_news_costs_one_small_request_however_large_the_flock() {
    let unit = Unit::new();
    unit.maker.bundle(&unit.stick(), &rubbish(1_125, 100, 0), &["lobby"], 1);
    unit.updated(&[]);
    let web = WebServer::serve(&unit.stick(), Behaviour::Good);
    let (code, answer) = fetch(&unit, &web.url(), &[]);
    assert_eq!((code, &answer["outcome"]), (Some(0), &"no-news".into()));
    let (asked, sent) = web.heard();
    assert_eq!(asked, ["seals/lobby.seal"]);
    assert!(sent < SMALL, "{sent} bytes were sent");
}

#[test]
fn a_unit_tells_how_it_is_only_where_its_owner_says_and_after_a_look_that_was_due() {
    let unit = Unit::new();
    unit.maker.bundle(&unit.stick(), &rubbish(3, 5_000, 0), &[], 1);
    let (web, home) =
        (WebServer::serve(&unit.stick(), Behaviour::Good), WebServer::serve(&unit.stick(), Behaviour::Good));
    // The player's status page, as far as the updater sees it.
    fs::write(unit.stick().join("status.json"), "{\"flock\": \"aurora\"}").unwrap();
    let page = web.url().replace("http://", "");
    let config = unit.path("update.toml").display().to_string();
    let schedule = |name: &str| unit.path(name).display().to_string();
    let look = |url: &str, name: &str| fetch(&unit, url, &["--config", &config, "--schedule", &schedule(name)]).0;
    fs::write(&config, format!("status = \"{page}\"\n")).unwrap();
    assert_eq!((look(&web.url(), "quiet"), home.received().len()), (Some(0), 0), "off by default");

    fs::write(&config, format!("status = \"{page}\"\nreport_to = \"{}/units\"\n", home.url())).unwrap();
    assert_eq!(look(&web.url(), "one"), Some(0));
    assert_eq!(look(&web.url(), "one"), Some(0), "that was not due");
    let told: Vec<Value> = home.received().iter().map(|text| serde_json::from_str(text).unwrap()).collect();
    let [told] = &told[..] else { panic!("it is told once a look: {told:?}") };
    let found = (&told["unit"], &told["update"]["outcome"], &told["error"], &told["status"]["flock"]);
    assert_eq!(found, (&"lobby".into(), &"no-news".into(), &Value::Null, &"aurora".into()));

    web.behave(Behaviour::Portal);
    assert_eq!(look(&web.url(), "two"), Some(3));
    let told: Value = serde_json::from_str(&home.received()[0]).unwrap();
    assert!(told["error"].as_str().is_some_and(|error| error.contains("portal")), "{told}");
    assert!(told["update"].is_null() && told["status"].is_null(), "{told}");

    drop(home);
    web.behave(Behaviour::Good);
    assert_eq!(look(&web.url(), "three"), Some(0), "that nobody listens stops nothing");
}

/// A store in `folder`, of showings of sheep with their votes, in this order and so long.
fn counted(folder: &Path, showings: &[(&str, Option<Vote>)], lasting_ns: u64) {
    fs::create_dir(folder).unwrap();
    let mut ledger = Ledger::new(LedgerId(0xf3a9), 20_700, false);
    let ends = [("end", None)];
    for (step, (sheep, vote)) in (0..).zip(showings.iter().chain(&ends)) {
        let visit = Visit { seed: 1, step, sheep: (*sheep).to_owned() };
        ledger.show(&visit, step * lasting_ns, &mut || 0);
        ledger.show(&visit, (step + 1) * lasting_ns - 1, &mut || 0);
        if let Some(vote) = vote {
            ledger.vote(&visit, *vote).unwrap();
        }
    }
    Store::open(folder).unwrap().0.save(&ledger).unwrap();
}

#[test]
fn what_is_sent_tells_nothing_about_anybody() {
    let unit = Unit::new();
    unit.maker.bundle(&unit.stick(), &rubbish(3, 5_000, 0), &[], 1);
    let home = WebServer::serve(&unit.stick(), Behaviour::Good);
    let (up, down) = (Some(Vote::Up), Some(Vote::Down));
    let morning = [("a", up), ("b", None), ("a", None), ("c", down), ("b", up)];
    let evening = [("b", up), ("c", down), ("a", None), ("b", None), ("a", up)];
    let shown = |name: &str, showings: &[_], lasting_ns| {
        counted(&unit.path(name), showings, lasting_ns);
        succeed(Command::new(counter()).arg("--show").arg("--store").arg(unit.path(name)))
    };
    let told = shown("votes", &morning, 7_000_000_000);
    assert_eq!(told, shown("others", &evening, 70_000_000_000), "the same bytes for any order and time");
    let told: Value = serde_json::from_slice(&told).unwrap();
    let totals = |shown, up, down| json!({ "shown": shown, "up": up, "down": down, "near_s": 0 });
    let sheep = json!({ "a": totals(2, 1, 0), "b": totals(2, 1, 0), "c": totals(1, 0, 1) });
    assert_eq!(told, json!({ "ledger": "000000000000f3a9", "since_day": 20_700, "sheep": sheep }), "and nothing else");

    let config = unit.path("update.toml").display().to_string();
    let report_to = format!("report_to = \"{}/units\"\n", home.url());
    let report = |more: &str, name: &str| {
        let address = if more.starts_with("owner") { "" } else { &report_to };
        fs::write(&config, format!("status = \"127.0.0.1:1\"\n{address}{more}")).unwrap();
        let schedule = unit.path(name).display().to_string();
        fetch(&unit, &home.url(), &["--config", &config, "--schedule", &schedule]);
        serde_json::from_str::<Value>(&home.received()[0]).unwrap()
    };
    assert_eq!(report("", "silent").get("votes"), None, "off by default");
    assert_eq!(report(&format!("votes = {:?}\n", unit.path("votes")), "open")["votes"], told, "exactly what is shown");
    assert_eq!(report(&format!("votes = {:?}\n", unit.path("none")), "none").get("votes"), None);

    // To the address of the owner, and votes only if the owner says so.
    let owned = |more: &str, name: &str| {
        fs::write(unit.path("owner.toml"), format!("{report_to}{more}")).unwrap();
        report(&format!("owner = {:?}\nvotes = {:?}\n", unit.path("owner.toml"), unit.path("votes")), name)
    };
    assert_eq!(owned("", "owner").get("votes"), None);
    assert_eq!(owned("report_votes = true\n", "owner-votes")["votes"], told);
}

#[test]
fn a_server_that_dies_at_every_chunk_costs_time_and_no_byte_twice() {
    let unit = Unit::new();
    let (one, two) = (rubbish(6, 300_000, 0), rubbish(6, 300_000, 3));
    unit.maker.bundle(&unit.stick(), &one, &[], 1);
    let web = WebServer::serve(&unit.stick(), Behaviour::Dies(70_000));
    let (code, answer) = fetch(&unit, &web.url(), &[]);
    assert_eq!((code, &answer["outcome"]), (Some(0), &"installed".into()));
    let content: usize = one.values().map(Vec::len).sum();
    assert_eq!(answer["fetched_bytes"], content);
    assert_eq!(unit.playing(), Some(one));
    let papers = |sent: u64, content: u64| sent.checked_sub(content).expect("all of the content was sent");
    assert!(papers(web.heard().1, content as u64) < 4_000, "beside the content, only seal and list");

    unit.maker.bundle(&unit.stick(), &two, &[], 2);
    let (_, answer) = fetch(&unit, &web.url(), &[]);
    assert_eq!(answer["fetched_bytes"], 900_000, "only what is new");
    assert!(papers(web.heard().1, 900_000) < 4_000);
    assert_eq!(unit.playing(), Some(two));
}

#[test]
fn a_server_that_drips_is_left_and_what_came_stays() {
    let unit = Unit::new();
    let files = rubbish(2, 50_000, 0);
    unit.maker.bundle(&unit.stick(), &files, &[], 1);
    let web = WebServer::serve(&unit.stick(), Behaviour::Drips);
    // All of it would take three hours.
    let mut look = unit.update_from(Some(Path::new(&web.url()))).stdout(Stdio::null()).spawn().unwrap();
    assert!(ends_within(&look, 150), "it still waits");
    assert_eq!(look.wait().unwrap().code(), Some(3));
    let came = files_in(&unit.path("store/incoming")).unwrap().into_values().map(|part| part.len()).sum::<usize>()
        + files_in(&unit.path("store/objects")).unwrap().into_values().map(|object| object.len()).sum::<usize>();
    assert!(came > 100, "{came} bytes came");
    web.behave(Behaviour::Good);
    let (code, answer) = fetch(&unit, &web.url(), &[]);
    let content: usize = files.values().map(Vec::len).sum();
    assert_eq!((code, answer["fetched_bytes"].as_u64()), (Some(0), Some((content - came) as u64)));
    assert_eq!(unit.playing(), Some(files));
}

#[test]
fn whatever_a_server_answers_instead_the_unit_keeps_its_flock_and_takes_the_next_good_answer() {
    let unit = Unit::new();
    let (one, two) = (rubbish(3, 5_000, 0), rubbish(3, 5_000, 1));
    unit.maker.bundle(&unit.stick(), &one, &["lobby"], 1);
    unit.updated(&[]);
    unit.maker.bundle(&unit.stick(), &two, &["lobby"], 2);
    let elsewhere = WebServer::serve(&unit.stick(), Behaviour::Portal);
    let web = WebServer::serve(&unit.stick(), Behaviour::Good);
    let cases = [
        (Behaviour::Portal, 3),
        (Behaviour::Says("Content-Type: TEXT/HTML; charset=utf-8\r\n", b"Welcome!"), 3),
        (Behaviour::Says("Content-Type: application/xhtml+xml\r\n", b"Welcome!"), 3),
        (Behaviour::Says("", b"\n<!DOCTYPE html><title>Welcome!</title>"), 3),
        (Behaviour::Says("Content-Encoding: gzip\r\n", b"\x1f\x8b\x08Welcome!"), 3),
        (Behaviour::Says("", b"\x1f\x8b\x08Welcome!"), 3),
        (Behaviour::Says("", b"Welcome!"), 1),
        (Behaviour::Redirects(elsewhere.url()), 3),
        (Behaviour::Redirects(web.url()), 3),
        (Behaviour::Fails, 3),
        (Behaviour::Refuses, 3),
        (Behaviour::Dies(0), 3),
        (Behaviour::Dies(100), 3),
        (Behaviour::PromisesMore, 3),
        (Behaviour::PromisesLess, 1),
        (Behaviour::Endless, 1),
    ];
    for (behaviour, code) in cases {
        web.behave(behaviour.clone());
        let (found, answer) = fetch(&unit, &web.url(), &[]);
        assert_eq!((found, answer), (Some(code), Value::Null), "{behaviour:?}");
        assert_eq!(unit.playing().as_ref(), Some(&one), "{behaviour:?}");
        assert!(web.heard().0.len() < 20, "{behaviour:?}: it is not asked for ever");
    }
    let (code, _) = fetch(&unit, "http://127.0.0.1:9", &[]);
    assert_eq!(code, Some(3), "nobody listens there");
    // A redirect is followed if the files there are signed.
    elsewhere.behave(Behaviour::Good);
    web.behave(Behaviour::Redirects(elsewhere.url()));
    let (code, answer) = fetch(&unit, &format!("{}/", web.url()), &[]);
    assert_eq!((code, &answer["outcome"]), (Some(0), &"installed".into()));
    assert_eq!(unit.playing(), Some(two));
}

/// A proxy on this machine, for as long as this process runs: its address, and the addresses that it was asked for. A
/// strict one connects to port 443 only, as many do.
fn proxy(is_strict: bool) -> (String, Arc<Mutex<Vec<String>>>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("http://{}", listener.local_addr().unwrap());
    let asked: Arc<Mutex<Vec<String>>> = Arc::default();
    let notes = Arc::clone(&asked);
    thread::spawn(move || {
        for visitor in listener.incoming().flatten() {
            let mut reader = BufReader::new(visitor.try_clone().unwrap());
            let mut line = String::new();
            reader.read_line(&mut line).unwrap();
            let place = line.strip_prefix("CONNECT ").unwrap().split(' ').next().unwrap().to_owned();
            while line.trim() != "" {
                line.clear();
                reader.read_line(&mut line).unwrap();
            }
            notes.lock().unwrap().push(place.clone());
            if is_strict && !place.ends_with(":443") {
                (&visitor).write_all(b"HTTP/1.1 403 Forbidden\r\n\r\n").unwrap();
                continue;
            }
            let server = TcpStream::connect(&place).unwrap();
            (&visitor).write_all(b"HTTP/1.1 200 Connected\r\n\r\n").unwrap();
            let (mut to, mut from) = (server.try_clone().unwrap(), server);
            thread::spawn(move || io::copy(&mut reader, &mut to).ok());
            thread::spawn(move || io::copy(&mut from, &mut &visitor).ok());
        }
    });
    (address, asked)
}

#[test]
fn what_is_fetched_through_a_proxy_comes_from_nowhere_else() {
    let unit = Unit::new();
    let files = rubbish(3, 5_000, 0);
    unit.maker.bundle(&unit.stick(), &files, &[], 1);
    let web = WebServer::serve(&unit.stick(), Behaviour::Good);
    let config = unit.path("update.toml");
    let look = |proxy: &str| {
        fs::write(&config, format!("proxy = \"{proxy}\"\n")).unwrap();
        let mut look = unit.update_from(Some(Path::new(&web.url())));
        let said = output(look.arg("--config").arg(&config));
        (said.status.code(), String::from_utf8(said.stderr).unwrap())
    };
    assert_eq!(look("http://127.0.0.1:9").0, Some(3), "nobody listens there, and nobody is asked without it");
    let (strict, asked) = proxy(true);
    let (code, said) = look(&strict);
    assert!(code == Some(3) && said.contains("proxy") && said.contains("403"), "{code:?}: {said}");
    assert!(!asked.lock().unwrap().is_empty());
    assert_eq!(web.heard().0, [""; 0]);
    let (address, asked) = proxy(false);
    assert_eq!(look(&address).0, Some(0));
    assert_eq!(unit.playing(), Some(files));
    let (requests, places) = (web.heard().0.len(), asked.lock().unwrap());
    assert!(requests > 5 && places.len() == requests, "{places:?}");
    assert!(places.iter().all(|place| web.url().ends_with(place.as_str())), "{places:?}");
}

#[test]
fn a_server_that_answers_403_for_what_is_not_there_serves_a_flock_and_one_that_gives_nothing_is_told() {
    let unit = Unit::new();
    let files = rubbish(3, 5_000, 0);
    // For all units: the unit asks for a seal of its own first, and for a system, which are not there.
    unit.maker.bundle(&unit.stick(), &files, &[], 1);
    let web = WebServer::serve(&unit.stick(), Behaviour::Refuses);
    let said = output(&mut unit.update_from(Some(Path::new(&web.url()))));
    let error = String::from_utf8_lossy(&said.stderr);
    assert!(said.status.code() == Some(3) && error.contains("403 to all"), "{error}");
    web.behave(Behaviour::Bucket);
    let (code, answer) = fetch(&unit, &web.url(), &[]);
    assert_eq!((code, &answer["outcome"]), (Some(0), &"installed".into()));
    assert_eq!(unit.playing(), Some(files));
    // An empty one has nothing for this unit.
    fs::remove_dir_all(unit.stick()).unwrap();
    web.behave(Behaviour::Good);
    assert_eq!(fetch(&unit, &web.url(), &[]).1["outcome"], "no-bundle");
}

#[test]
fn a_part_is_taken_for_what_it_is() {
    for (behaviour, code, sent) in [
        (Behaviour::Good, 0, 4_000),
        (Behaviour::Whole, 0, 5_000),
        // After a wrong range the whole file is requested again.
        (Behaviour::WrongPart, 0, 3_999 + 5_000),
        (Behaviour::Astray, 3, 0),
        (Behaviour::LyingPart, 0, 4_001 + 5_000),
    ] {
        let unit = Unit::new();
        let files = rubbish(1, 5_000, 0);
        unit.maker.bundle(&unit.stick(), &files, &[], 1);
        let clip = &files["loops/0.mp4"];
        let incoming = unit.path("store/incoming");
        fs::create_dir_all(&incoming).unwrap();
        fs::write(incoming.join(bundle::ObjectId::of(clip).to_string()), &clip[..1_000]).unwrap();
        let web = WebServer::serve(&unit.stick(), behaviour.clone());
        let (found, _) = fetch(&unit, &web.url(), &[]);
        let (asked, all) = web.heard();
        assert_eq!(found, Some(code), "{behaviour:?}");
        if code == 0 {
            let papers = all - files["flock.toml"].len() as u64 - sent;
            assert!(papers < 1_500, "{behaviour:?}: {papers} bytes more than expected were sent for {asked:?}");
            assert_eq!(unit.playing().as_ref(), Some(&files), "{behaviour:?}");
        } else {
            assert!(asked.iter().filter(|path| **path == object(clip)).count() < 10, "{asked:?}");
            web.behave(Behaviour::Good);
            let (found, answer) = fetch(&unit, &web.url(), &[]);
            let rest = files["flock.toml"].len() as u64 + 4_000;
            assert_eq!((found, answer["fetched_bytes"].as_u64()), (Some(0), Some(rest)), "what was there stayed");
        }
    }
}

#[test]
fn the_window_is_kept_by_a_unit_that_knows_the_time_and_by_no_other() {
    let unit = Unit::new();
    unit.maker.bundle(&unit.stick(), &rubbish(2, 500, 0), &["lobby"], 1);
    let web = WebServer::serve(&unit.stick(), Behaviour::Good);
    let [config, system] = ["update.toml", "os-release"].map(|name| unit.path(name));
    let hour = |hours: i64| {
        let mut date = Command::new("date");
        let told = succeed(date.arg("--utc").arg(format!("--date={hours} hours")).arg("+%H:%M"));
        String::from_utf8(told).unwrap().trim().to_owned()
    };
    let look = |made: &str| {
        fs::write(&system, format!("ID=other\nDREAMS_DATE={made}\n")).unwrap();
        let window = format!("window = \"{}-{}\"\nsystem = \"{}\"\n", hour(10), hour(11), system.display());
        fs::write(&config, format!("url = \"{}\"\n{window}", web.url())).unwrap();
        let mut command = unit.update_from(None);
        let said = output(command.arg("--config").arg(&config).arg("--schedule").arg(unit.path("schedule")));
        assert_eq!(said.status.code(), Some(0), "{}", String::from_utf8_lossy(&said.stderr));
        serde_json::from_slice::<Value>(&said.stdout).unwrap()["outcome"].clone()
    };
    assert_eq!(look("2026-01-01T00:00:00Z"), "not-now", "a clock that is right");
    assert_eq!(look("2096-01-01T00:00:00Z"), "installed", "a clock that is behind its system");
}

#[test]
fn a_unit_looks_for_news_when_it_is_time_and_not_before() {
    let unit = Unit::new();
    unit.maker.bundle(&unit.stick(), &rubbish(2, 500, 0), &["lobby"], 1);
    let web = WebServer::serve(&unit.stick(), Behaviour::Good);
    let config = unit.path("update.toml");
    fs::write(&config, format!("url = \"{}\"\nevery_minutes = 60\n", web.url())).unwrap();
    let look = || {
        let mut command = unit.update_from(None);
        let said = output(command.arg("--config").arg(&config).arg("--schedule").arg(unit.path("schedule")));
        assert_eq!(said.status.code(), Some(0), "{}", String::from_utf8_lossy(&said.stderr));
        serde_json::from_slice::<Value>(&said.stdout).unwrap()["outcome"].clone()
    };
    assert_eq!(look(), "installed");
    web.heard();
    assert_eq!(look(), "not-now");
    assert_eq!(web.heard().0, [""; 0]);
    fs::remove_file(unit.path("schedule")).unwrap();
    assert_eq!(look(), "no-news");
    fs::write(&config, "").unwrap();
    fs::remove_file(unit.path("schedule")).unwrap();
    assert_eq!(look(), "not-now", "there is nowhere to look, and that is fine");
}

#[test]
fn a_unit_reports_as_often_as_its_owner_says_whether_it_looks_or_not() {
    let unit = Unit::new();
    unit.maker.bundle(&unit.stick(), &rubbish(3, 5_000, 0), &[], 1);
    let (web, home) =
        (WebServer::serve(&unit.stick(), Behaviour::Portal), WebServer::serve(&unit.stick(), Behaviour::Good));
    let (config, owner, schedule) = (unit.path("update.toml"), unit.path("owner.toml"), unit.path("schedule"));
    fs::write(&config, format!("status = \"127.0.0.1:1\"\nowner = {owner:?}\n")).unwrap();
    fs::write(&owner, format!("report_to = \"{}/units\"\nreport_every = 5\n", home.url())).unwrap();
    let options = ["--config", config.to_str().unwrap(), "--schedule", schedule.to_str().unwrap()];
    // The next minute of the timer; `due` are the times that have come since.
    let minute = |due: &[&str]| {
        let mut kept: Value = fs::read(&schedule).map_or(json!({}), |text| serde_json::from_slice(&text).unwrap());
        for time in due {
            kept[*time] = json!(0);
        }
        fs::write(&schedule, kept.to_string()).unwrap();
        fetch(&unit, &web.url(), &options);
        let errors =
            home.received().into_iter().map(|text| serde_json::from_str::<Value>(&text).unwrap()["error"].clone());
        (web.heard().0.len(), errors.collect::<Vec<_>>())
    };
    let (looked, errors) = minute(&[]);
    assert!(looked > 0 && errors.len() == 1, "both at once after the start: {errors:?}");
    assert!(errors[0].as_str().is_some_and(|error| error.contains("portal")), "{errors:?}");
    assert_eq!(minute(&[]), (0, vec![]), "neither is due");
    assert_eq!(minute(&["report_due_s"]), (0, errors), "a report alone knows how the last look ended");
    let (looked, errors) = minute(&["due_s"]);
    assert!(looked > 0 && errors.is_empty(), "a look alone: {errors:?}");
    web.behave(Behaviour::Good);
    assert_eq!(minute(&["due_s", "report_due_s"]).1, [Value::Null]);
    assert_eq!(minute(&["report_due_s"]), (0, vec![Value::Null]), "the error is over");
    fs::write(&owner, format!("report_to = \"{}/units\"\n", home.url())).unwrap();
    let (looked, errors) = minute(&[]);
    assert!(looked > 0 && errors == [Value::Null], "settings that change have it look and report: {errors:?}");
    assert_eq!(minute(&["report_due_s"]), (0, vec![]), "by default only after a look");
}

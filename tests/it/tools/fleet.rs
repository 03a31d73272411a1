//! `dreams fleet`: what units report, on one page, as metrics and as alarms.
//!
//! Owns the claims on reports of real units and of strangers, on what is kept and what is shown of them, and on alarms.
//! The page in a browser is a claim of `tests/slow`.

use super::breeding::{answer, report as report_of_votes};
use claims::bundle_maker::rubbish;
use claims::fleet::{Fleet, Hook};
use claims::programs::{dreams, json, output};
use claims::status_page::{on_a_port, pixels};
use claims::unit::Unit;
use claims::wait;
use claims::web::{Behaviour, WebServer};
use ct_codecs::{Base64, Decoder, Encoder};
use serde_json::{Value, json};
use std::fs;
use std::io::Write;
use std::net::TcpStream;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::thread;
use std::time::Duration;

/// Reads `OpenMetrics` as Prometheus does, and prints each sample: its name, its labels by name, and its value.
const PARSER: &str = "
import json, sys
from prometheus_client.openmetrics.parser import text_string_to_metric_families
for family in text_string_to_metric_families(sys.stdin.read()):
    for sample in family.samples:
        print(family.type, sample.name, json.dumps(sample.labels, sort_keys=True), float(sample.value))
";

/// `dreams fleet FOLDER` with options.
fn fleet(folder: &Path, options: &[&str]) -> Output {
    output(Command::new(dreams()).arg("fleet").arg(folder).args(options))
}

/// The report of a unit with which nothing is wrong.
fn fine(unit: &str) -> Value {
    json!({"unit": unit, "update": null, "error": null, "status": {"flock": "aurora", "screen": {}, "too_slow": false,
        "generation": {"sequence": 7}}, "machine": {"system": "1.2", "temperature_c": 50}})
}

/// The JPEG that the demo's documentation shows, made small.
fn small_jpeg(folder: &Path) -> Vec<u8> {
    let (from, to) = (claims::programs::repository().join("flock-tools/demo/picture.jpg"), folder.join("small.jpg"));
    let mut ffmpeg = Command::new("ffmpeg");
    ffmpeg.args(["-loglevel", "error", "-i"]).arg(from).args(["-vf", "scale=160:-2"]).arg(&to);
    claims::programs::succeed(&mut ffmpeg);
    fs::read(to).unwrap()
}

#[test]
fn a_unit_that_reports_is_shown_with_what_hangs_there_and_is_still_known_after_a_kill() {
    let unit = Unit::new();
    let folder = unit.path("reports");
    let fleet_server = Fleet::of(&folder, &[]);
    unit.maker.bundle(&unit.stick(), &rubbish(3, 5_000, 0), &[], 1);
    let web = WebServer::serve(&unit.stick(), Behaviour::Good);
    fs::write(unit.stick().join("status.json"), "{\"flock\": \"aurora\", \"screen\": {}}").unwrap();
    let page = web.url().replace("http://", "");
    let config = unit.path("update.toml");
    fs::write(&config, format!("status = \"{page}\"\nreport_to = \"http://{}/units\"\n", fleet_server.place)).unwrap();
    let look = |schedule: &str| {
        let mut update = unit.update_from(Some(Path::new(&web.url())));
        output(update.arg("--config").arg(&config).arg("--schedule").arg(unit.path(schedule))).status.code()
    };
    assert_eq!(look("one"), Some(0));
    let shown = fleet_server.units();
    let of = |shown: &Value| {
        let unit = &shown["units"][0];
        [&unit["unit"], &unit["ok"], &unit["flock"], &unit["sequence"], &unit["flock_since"]].map(Clone::clone)
    };
    assert_eq!(of(&shown)[..4], [json!("lobby"), json!(true), json!("aurora"), json!(1)], "{shown}");
    assert!(of(&shown)[4].as_str().is_some_and(|since| since.starts_with("20")), "{shown}");
    let text = fleet_server.get("/").body;
    assert!(text.contains("<h1>One unit</h1>") && text.contains(">lobby<") && text.contains("<b>aurora</b>"), "{text}");

    drop(fleet_server);
    let again = Fleet::of(&folder, &[]);
    assert_eq!(of(&again.units()), of(&shown), "nothing is lost");
    web.behave(Behaviour::Portal);
    fs::write(&config, format!("status = \"{page}\"\nreport_to = \"http://{}/units\"\n", again.place)).unwrap();
    assert_eq!(look("two"), Some(3));
    let shown = again.units();
    let kinds: Vec<_> = shown["units"][0]["wrong"].as_array().unwrap().iter().map(|wrong| &wrong["kind"]).collect();
    assert_eq!((&shown["ok"], kinds), (&json!(false), vec![&json!("update-failed"), &json!("no-player")]), "{shown}");
}

#[test]
fn the_picture_on_the_wall_is_shown_where_the_owner_allows_it() {
    let unit = Unit::new();
    let (_playing, _running, page) = on_a_port();
    let fleet = Fleet::of(&unit.path("reports"), &[]);
    unit.maker.bundle(&unit.stick(), &rubbish(3, 5_000, 0), &[], 1);
    let web = WebServer::serve(&unit.stick(), Behaviour::Good);
    let (config, owner) = (unit.path("update.toml"), unit.path("owner.toml"));
    fs::write(&config, format!("status = \"{page}\"\nowner = {owner:?}\n")).unwrap();
    for (allowed, status) in [("", 404), ("report_picture = true\n", 200), ("", 404)] {
        fs::write(&owner, format!("report_to = \"http://{}/units\"\n{allowed}", fleet.place)).unwrap();
        let mut update = unit.update_from(Some(Path::new(&web.url())));
        let schedule = tempfile::tempdir().unwrap();
        output(update.arg("--config").arg(&config).arg("--schedule").arg(schedule.path().join("schedule")));
        assert_eq!(fleet.units()["units"][0]["flock"], "small", "{allowed}");
        assert_eq!(fleet.get("/picture/lobby").status, status, "{allowed}");
        let report: Value = serde_json::from_slice(&fs::read(unit.path("reports/lobby.json")).unwrap()).unwrap();
        let jpeg = report.get("picture").map(|picture| {
            Base64::decode_to_vec(picture.as_str().unwrap(), None).expect("the picture is written in Base64")
        });
        let size = jpeg.map(|jpeg| pixels(&jpeg, "jpg").len());
        assert_eq!(size, (status == 200).then_some(320 * 240 * 3), "{allowed}");
    }
}

#[test]
fn hostile_reports_change_nothing_and_each_is_answered_in_words() {
    let folder = tempfile::tempdir().unwrap();
    let reports = folder.path().join("reports");
    let fleet = Fleet::of(&reports, &["--most", "2"]);
    assert_eq!(fleet.report(&fine("lobby").to_string()), (204, String::new()));
    let before = fleet.units();
    let jpeg = small_jpeg(folder.path());
    let picture = |bytes: &[u8]| {
        json!({"unit": "lobby", "picture": Base64::encode_to_string(bytes).unwrap(), "status": {}}).to_string()
    };
    let hostile = [
        (String::new(), 400, "not JSON"),
        ("{\"unit\": \"lobby\"".to_owned(), 400, "not JSON"),
        ("[".repeat(20_000), 400, "not JSON"),
        ("[".repeat(500_000), 400, "more than 20000 lists"),
        (format!("{{\"unit\": \"lobby\", \"a\": \"{}\"}}", "b".repeat(1 << 20)), 413, "at most 1048576 bytes"),
        (format!("{{\"unit\": \"lobby\", \"a\": [{}1]}}", "1e15,".repeat(200_000)), 400, "more than 1048576 bytes"),
        (json!({"unit": "../lobby"}).to_string(), 400, "not of a unit"),
        (json!({"unit": "lobby/../../x"}).to_string(), 400, "not of a unit"),
        (json!({"unit": "Lobby"}).to_string(), 400, "not of a unit"),
        (json!({"unit": {"$ne": 1}}).to_string(), 400, "no text `unit`"),
        (picture(b"<svg xmlns='http://www.w3.org/2000/svg' onload='alert(1)'/>"), 400, "not a whole JPEG"),
        (picture(&jpeg[..jpeg.len() / 2]), 400, "not a whole JPEG"),
        (picture(&[0xff].repeat(70_000)), 400, "more than 65536 bytes"),
    ];
    for (text, status, why) in hostile {
        let (said, words) = fleet.report(&text);
        let start: String = text.chars().take(80).collect();
        assert!(said == status && words.contains(why), "{said} `{words}`, expected {status} `{why}`: {start}");
    }
    let age = |shown: &Value| {
        let mut shown = shown.clone();
        shown["units"][0]["age_s"].take();
        shown
    };
    assert_eq!(age(&fleet.units()), age(&before));
    assert_eq!(fleet.report(&fine("attic").to_string()).0, 204);
    let (status, words) = fleet.report(&fine("cellar").to_string());
    assert!(status == 403 && words.contains("2 units already") && words.contains("--unit"), "{words}");
    let mut files: Vec<_> = fs::read_dir(&reports).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    files.sort();
    assert_eq!(files, ["attic.json", "lobby.json", "lock"]);

    let evil = "</td><script>alert(1)</script>\u{1b}[2J";
    let report = json!({"unit": "lobby", "error": evil, "status": {"flock": evil}, "machine": {"system": evil}});
    assert_eq!(fleet.report(&report.to_string()).0, 204);
    let text = fleet.get("/").body;
    assert!(
        !text.contains("<script>") && text.contains("&lt;script&gt;alert(1)") && !text.contains('\u{1b}'),
        "{text}"
    );
    assert_eq!(fleet.report(&picture(&jpeg)).0, 204);
    let shown = fleet.get("/picture/lobby");
    assert!(shown.head.contains("content-type: image/jpeg"), "{}", shown.head);
    assert_eq!(fleet.get("/picture/..%2flobby").status, 404);
}

#[test]
fn only_what_names_this_server_and_sends_json_from_no_page_is_let_in() {
    let folder = tempfile::tempdir().unwrap();
    let options = ["--path", "/units", "--host", "fleet.example.org", "--unit", "lobby"];
    let fleet = Fleet::of(folder.path(), &options);
    let get = |host: &str| fleet.send("GET /fleet.json", &[("Host", host)], b"").status;
    let hosts = ["evil.example", "fleet.example.org.evil.example", "FLEET.example.org:80", "localhost:1", "10.0.0.1"];
    assert_eq!(hosts.map(get), [421, 421, 200, 200, 200]);
    let report = fine("lobby").to_string();
    let post = |line: &str, headers: &[(&str, &str)]| fleet.send(line, headers, report.as_bytes()).status;
    let json = ("Content-Type", "application/json");
    assert_eq!(post("POST /", &[json]), 404, "only at its path");
    assert_eq!(post("POST /units", &[]), 415);
    assert_eq!(post("POST /units", &[("Content-Type", "text/plain")]), 415, "as any page may send it");
    assert_eq!(post("POST /units", &[json, ("Origin", "http://localhost")]), 403);
    assert_eq!(post("POST /units", &[json, ("Host", "evil.example")]), 421);
    let (status, words) = fleet.report(&fine("attic").to_string());
    assert!(status == 403 && words.contains("`attic`"), "only named units report: {words}");
    assert_eq!(fleet.units()["units"][0]["last_seen"], Value::Null);
    assert_eq!(post("POST /units", &[json]), 204);
    assert!(fleet.get("/").head.contains("default-src 'none'"));

    let taken = output(Command::new(dreams()).arg("fleet").arg(folder.path()).args(["--listen", "0"]));
    let words = String::from_utf8(taken.stderr).unwrap();
    assert!(taken.status.code() == Some(1) && words.contains("another `dreams fleet`"), "{words}");
    let other = tempfile::tempdir().unwrap();
    let taken = output(Command::new(dreams()).arg("fleet").arg(other.path()).args(["--listen", &fleet.place]));
    let words = String::from_utf8(taken.stderr).unwrap();
    assert!(taken.status.code() == Some(1) && words.contains("cannot listen at"), "{words}");
}

/// The most memory that a process has had, in kB.
fn most_memory_kb(process: u32) -> u64 {
    let status = fs::read_to_string(format!("/proc/{process}/status")).unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
    line.trim().trim_end_matches(" kB").parse().unwrap()
}

#[test]
fn reports_of_many_small_objects_take_little_memory_however_many_come_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let fleet = Fleet::of(folder.path(), &[]);
    let of = |objects: usize| format!("{{\"unit\": \"lobby\", \"a\": [{}0]}}", "{\"\":0},".repeat(objects));
    let (most, more) = (of(19_990), of(140_000));
    thread::scope(|senders| {
        for _ in 0..16 {
            senders.spawn(|| assert_eq!((fleet.report(&most).0, fleet.report(&more).0), (204, 400)));
        }
    });
    let kb = most_memory_kb(fleet.process());
    assert!(kb < 100_000, "{kb} kB");
}

#[test]
fn slow_senders_keep_no_report_out() {
    let folder = tempfile::tempdir().unwrap();
    let fleet = Fleet::of(folder.path(), &[]);
    let slow: Vec<TcpStream> = (0..60)
        .map(|_| {
            let mut stream = TcpStream::connect(&fleet.place).unwrap();
            let head =
                "POST / HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: 9\r\n\r\n{";
            stream.write_all(head.as_bytes()).unwrap();
            stream
        })
        .collect();
    assert_eq!(fleet.get("/").status, 200, "all of them were heard before");
    assert_eq!(fleet.report(&fine("lobby").to_string()), (204, String::new()));
    assert_eq!(slow.len(), 60, "they are still there");
}

#[test]
fn an_alarm_is_sent_once_for_each_state_is_tried_again_and_survives_a_kill() {
    let folder = tempfile::tempdir().unwrap();
    let hook = Hook::answering(&[503]);
    let url = hook.url();
    let options = ["--alarm", &url];
    let hot = |unit: &str| {
        let mut report = fine(unit);
        report["machine"]["temperature_c"] = json!(90);
        report.to_string()
    };
    let states = |alarms: &[Value]| -> Vec<String> {
        alarms.iter().map(|alarm| format!("{} {}", alarm["id"], alarm["state"]).replace('"', "")).collect()
    };
    let fleet = Fleet::of(folder.path(), &options);
    assert_eq!(fleet.report(&fine("attic").to_string()).0, 204);
    assert_eq!(fleet.report(&hot("lobby")).0, 204);
    let alarms = hook.await_alarms(2);
    assert_eq!(states(&alarms), ["lobby-1 wrong", "lobby-1 wrong"], "the first was not accepted");
    assert_eq!(alarms[0], alarms[1]);
    assert_eq!(alarms[0]["began"], json!(["hot"]));
    assert!(alarms[0]["text"].as_str().unwrap().starts_with("lobby: Its processor has 90 °C. "), "{}", alarms[0]);
    // They are noted after the answer of the webhook: a kill in between sends the last one again, with its id.
    let noted = |fleet: &Fleet, result: &str, count: u32| {
        let line = format!("dreams_fleet_alarms_total{{result=\"{result}\"}} {count}\n");
        wait::until("the alarms among the metrics", 10, || fleet.get("/metrics").body.contains(&line));
    };
    noted(&fleet, "failed", 1);
    noted(&fleet, "sent", 1);

    // A report that says the same, a kill, and a start: no alarm. The next state is sent after them.
    assert_eq!(fleet.report(&hot("lobby")).0, 204);
    drop(fleet);
    let fleet = Fleet::of(folder.path(), &options);
    assert_eq!(fleet.report(&hot("lobby")).0, 204);
    assert_eq!(fleet.report(&hot("attic")).0, 204);
    assert_eq!(states(&hook.await_alarms(3)[2..]), ["attic-1 wrong"], "nothing is sent twice");
    assert_eq!(fleet.report(&fine("lobby").to_string()).0, 204);
    assert_eq!(states(&hook.await_alarms(4)[3..]), ["lobby-2 right"]);
    assert_eq!(fleet.report(&fine("attic").to_string()).0, 204);
    assert_eq!(states(&hook.await_alarms(5)[4..]), ["attic-2 right"]);
    noted(&fleet, "sent", 3);
    drop(fleet);

    // The same without a server: a unit that fell silent, once.
    let file = folder.path().join("lobby.json");
    let mut kept: Value = serde_json::from_slice(&fs::read(&file).unwrap()).unwrap();
    kept["fleet"]["arrived_s"] = json!(1_700_000_000);
    fs::write(&file, kept.to_string()).unwrap();
    for _ in 0..2 {
        assert_eq!(self::fleet(folder.path(), &options).status.code(), Some(1));
    }
    let alarms = hook.received();
    assert_eq!(states(&alarms[5..]), ["lobby-3 wrong"]);
    assert_eq!(alarms[5]["wrong"][0]["kind"], "silent");
}

#[test]
fn a_webhook_that_cannot_be_reached_is_an_error_and_its_address_stays_secret() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("lobby.json"), json!({"unit": "lobby", "error": "no route"}).to_string()).unwrap();
    let said = fleet(folder.path(), &["--alarm", "http://127.0.0.1:1/secret-4711"]);
    let words = String::from_utf8(said.stderr).unwrap();
    assert_eq!(said.status.code(), Some(3), "{words}");
    assert!(words.contains("cannot send the alarm of `lobby`") && !words.contains("4711"), "{words}");
    let mut hidden = Command::new(dreams());
    hidden.arg("fleet").arg(folder.path()).env("DREAMS_FLEET_ALARM", "http://127.0.0.1:1/secret-4711");
    assert_eq!(output(&mut hidden).status.code(), Some(3), "no list of processes need show it");
    let said = fleet(folder.path(), &["--alarm", "example.org/secret"]);
    assert_eq!(said.status.code(), Some(2), "an address begins with http:// or https://");
}

#[test]
fn a_slow_webhook_does_not_hold_up_the_end() {
    let folder = tempfile::tempdir().unwrap();
    let hook = Hook::refusing_after(Duration::from_secs(2));
    let fleet = Fleet::of(folder.path(), &["--alarm", &hook.url()]);
    for number in 0..10 {
        let report = json!({"unit": format!("unit-{number}"), "error": "no route", "status": {}});
        assert_eq!(fleet.report(&report.to_string()).0, 204);
    }
    // By the third all are due, one after the other: 14 seconds are left at least.
    hook.await_alarms(3);
    fleet.interrupt(8);
}

#[test]
fn prometheus_reads_the_metrics() {
    let folder = tempfile::tempdir().unwrap();
    let fleet = Fleet::of(folder.path(), &["--unit", "lobby", "--unit", "attic"]);
    let mut report = fine("lobby");
    report["status"]["flock"] = json!("a \"b\" \\ c\nd é");
    report["machine"]["disk"] =
        json!({"total_bytes": 64_000_000_000_u64, "free_bytes": 1_000_000_u64, "worn_percent": 7});
    report["machine"]["uptime_s"] = json!(77);
    assert_eq!(fleet.report(&report.to_string()).0, 204);
    assert_eq!(fleet.report("{}").0, 400);
    let answer = fleet.get("/metrics");
    assert!(answer.head.contains("content-type: application/openmetrics-text; version=1.0.0; charset=utf-8"));
    // Debian's python, which has the package.
    let mut parser = Command::new("/usr/bin/python3");
    parser.args(["-c", PARSER]).stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut parser = parser.spawn().unwrap();
    parser.stdin.take().unwrap().write_all(answer.body.as_bytes()).unwrap();
    let read = wait::output("the parser of Prometheus", 60, parser);
    assert!(read.status.success(), "{}", answer.body);
    let read = String::from_utf8(read.stdout).unwrap();
    for sample in [
        "gauge dreams_fleet_units {} 2.0",
        "counter dreams_fleet_reports_total {\"result\": \"taken\"} 1.0",
        "counter dreams_fleet_reports_total {\"result\": \"refused\"} 1.0",
        "counter dreams_fleet_alarms_total {\"result\": \"sent\"} 0.0",
        "gauge dreams_unit_ok {\"unit\": \"attic\"} 0.0",
        "gauge dreams_unit_wrong {\"kind\": \"silent\", \"unit\": \"attic\"} 1.0",
        "gauge dreams_unit_wrong {\"kind\": \"disk-full\", \"unit\": \"lobby\"} 1.0",
        "gauge dreams_unit_uptime_seconds {\"unit\": \"lobby\"} 77.0",
        "gauge dreams_unit_temperature_celsius {\"unit\": \"lobby\"} 50.0",
        "gauge dreams_unit_disk_free_bytes {\"unit\": \"lobby\"} 1000000.0",
        "gauge dreams_unit_disk_worn_ratio {\"unit\": \"lobby\"} 0.07",
    ] {
        assert!(read.lines().any(|line| line == sample), "`{sample}` is missing:\n{read}");
    }
    assert!(read.contains("info dreams_unit_hanging_info {\"flock\": \"a \\\"b\\\" \\\\ c"), "{read}");
}

#[test]
fn a_folder_of_reports_is_shown_as_a_table_as_json_and_as_one_file() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    let mut with_picture = fine("lobby");
    with_picture["picture"] = json!(Base64::encode_to_string(small_jpeg(folder.path())).unwrap());
    write("anything.json", &with_picture.to_string());
    let said = fleet(folder.path(), &[]);
    let text = String::from_utf8(said.stdout).unwrap();
    assert_eq!(said.status.code(), Some(0), "{text}");
    assert!(text.starts_with("unit ") && text.contains("\nlobby  fine   aurora 7 "), "{text}");

    write("broken.json", "{");
    write("attic.json", &json!({"unit": "attic", "error": null, "status": null}).to_string());
    let page = folder.path().join("page.html");
    let said = fleet(folder.path(), &["--json", "--unit", "cellar", "--out", page.to_str().unwrap()]);
    let shown = json(&said);
    assert_eq!((said.status.code(), &shown["ok"]), (Some(1), &json!(false)), "{shown}");
    let units: Vec<_> = shown["units"].as_array().unwrap().iter().map(|unit| (&unit["unit"], &unit["ok"])).collect();
    let expected = [("attic", false), ("cellar", false), ("lobby", true)].map(|(unit, ok)| (json!(unit), json!(ok)));
    assert_eq!(units, expected.iter().map(|(unit, ok)| (unit, ok)).collect::<Vec<_>>());
    assert!(shown["refused"][0]["file"].as_str().unwrap().ends_with("broken.json"), "{shown}");
    assert!(shown["units"][1]["wrong"][0]["what"].as_str().unwrap().contains("never reported"), "{shown}");
    let page = fs::read_to_string(page).unwrap();
    assert!(
        page.contains("src=\"data:image/jpeg;base64,/9j/") && !page.contains("<script"),
        "one file needs nothing else"
    );

    let missing = fleet(&folder.path().join("nowhere"), &["--json"]);
    assert_eq!((missing.status.code(), json(&missing)["error"]["exit"].clone()), (Some(3), json!(3)));
}

#[test]
fn the_votes_in_kept_reports_are_read_where_they_lie() {
    let folder = tempfile::tempdir().unwrap();
    let reports = folder.path().join("reports");
    let hook = Hook::answering(&[]);
    let server = Fleet::of(&reports, &["--alarm", &hook.url()]);
    answer(folder.path(), &["pool", "new", "pool", "--seed", "3", "--species", "plant"]);
    answer(folder.path(), &["breed", "pool", "--brood", "1"]);
    let pool = answer(folder.path(), &["pool", "show", "pool"]);
    let sheep: Vec<String> =
        pool["sheep"].as_array().unwrap().iter().map(|it| it["id"].as_str().unwrap().into()).collect();
    assert_eq!(server.report(&report_of_votes("lobby", &sheep, 10, &[3])), (204, String::new()));
    hook.await_alarms(1);
    let sent = "dreams_fleet_alarms_total{result=\"sent\"} 1\n";
    wait::until("the list of alarms beside the report", 10, || server.get("/metrics").body.contains(sent));
    let said = answer(folder.path(), &["votes", "pool", "reports", "--unit", "lobby"]);
    assert_eq!((&said["refused"], &said["units"]["lobby"]["showings"]), (&json!([]), &json!(10)), "{said}");
}

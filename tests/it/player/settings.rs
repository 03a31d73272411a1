//! Settings of the owner that change while the picture is shown.
//!
//! Owns the claims on the running player that need no display: what it says of a change, that the picture goes on, and that
//! files which are not whole change nothing. `tests/slow/display/owner_hours.rs` has the claims on a real display.

use claims::flocks::JOINS;
use claims::owner::Settings;
use claims::player_run::{PlayerRun, RunningPlayer};
use claims::status_page::ask;
use claims::wait;
use rustix::process::Signal;
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};

/// How long a change may take until it is in use: the player looks once a second.
const SOON_S: u32 = 10;

/// A player that goes by `settings`, and the socket of its status page.
fn playing(settings: &Settings) -> (RunningPlayer, PathBuf) {
    let (kept, page) = (settings.path("kept"), settings.path("page"));
    let status = format!("unix:{}", page.display());
    let options = ["--screen", "virtual", "--seed", "1", "--status", &status, "--owner", kept.to_str().unwrap()];
    let mut running = PlayerRun::of(&JOINS.flock().folder).with(&options).start();
    running.await_lines(40);
    (running, page)
}

/// What the status says of the newest change.
fn changed(page: &Path) -> Value {
    let facts: Value = serde_json::from_slice(&ask(page, "GET /status.json").body).unwrap();
    facts["settings"]["changed"].clone()
}

#[test]
fn changed_settings_are_in_use_at_once_and_the_picture_goes_on() {
    let settings = Settings::new();
    assert_eq!(settings.set("rotate = 90\n").0, Some(0));
    let (mut running, page) = playing(&settings);
    assert_eq!(changed(&page), Value::Null, "settings at the start are no change");
    let steps: [(&str, &[&str]); 4] = [
        ("rotate = 180\nbrightness = 30\n", &["brightness", "rotate"]),
        ("rotate = 180\nbrightness = 30\nmargin = 3\nurl = \"https://example.org\"\n", &["margin"]),
        ("margin = 3\nclosed = [\"2020-01-01\"]\n", &["brightness", "closed", "rotate"]),
        ("# nothing\n", &["closed", "margin"]),
    ];
    for (text, keys) in steps {
        assert_eq!(settings.set(text).0, Some(0), "{text}");
        wait::until(&format!("{keys:?} are in use"), SOON_S, || {
            running.catch_up();
            changed(&page) == json!(keys)
        });
        running.await_lines(60);
    }
    running.signal(Signal::TERM);
    let (code, trace) = running.end_within(10);
    let end = trace.end.expect("a run that ends says its counts");
    assert_eq!((code, end.skipped, end.repeated, end.faults), (Some(0), 0, 0, 0), "{:?}", trace.faults);
}

#[test]
fn settings_that_are_not_whole_change_nothing_in_a_running_player() {
    let settings = Settings::new();
    assert_eq!(settings.set("rotate = 90\nmargin = 3\n").0, Some(0));
    let (mut running, page) = playing(&settings);
    let [first, second] = ["kept", "kept.kept"].map(|name| (settings.path(name), settings.read(name).unwrap()));
    let cut = |text: &str| text[..text.len() / 2].to_owned();
    for (path, text) in [
        (&first.0, cut(&first.1)),
        (&first.0, "rotate = 180\n".to_owned()),
        (&first.0, "no settings".to_owned()),
        (&second.0, cut(&second.1)),
        (&second.0, second.1.replace("of = \"", "of = \"0")),
        (&second.0, String::new()),
    ] {
        fs::write(path, &text).unwrap();
        // Two seconds: the player looks twice.
        running.await_lines(60);
        assert_eq!(changed(&page), Value::Null, "`{text}` in `{}`", path.display());
        for (path, text) in [&first, &second] {
            fs::write(path, text).unwrap();
        }
    }
    assert_eq!(settings.set("margin = 3\n").0, Some(0));
    wait::until("settings that are whole are in use", SOON_S, || {
        running.catch_up();
        changed(&page) == json!(["rotate"])
    });
}

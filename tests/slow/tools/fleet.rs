//! The page of all units in a browser.
//!
//! Owns the claim that it is whole and quiet at every width, works with the keyboard, updates by itself, and says so when the
//! server is gone. Its reports, its JSON and its metrics are in `it/tools/fleet.rs`.

use claims::fleet::Fleet;
use claims::programs::{repository, succeed};
use claims::studio::browser::Browser;
use claims::studio::page::{Page, Window};
use ct_codecs::{Base64, Encoder};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use std::process::Command;

/// The longest time until the page has asked again, in seconds: three times what it says.
const NEWER_S: u32 = 30;

/// The report of a unit with a long name for everything, and of one with nothing but its name.
fn reports(folder: &Path) -> [Value; 4] {
    let (from, to) = (repository().join("flock-tools/demo/picture.jpg"), folder.join("small.jpg"));
    let mut ffmpeg = Command::new("ffmpeg");
    succeed(ffmpeg.args(["-loglevel", "error", "-i"]).arg(from).args(["-vf", "scale=320:-2"]).arg(&to));
    let picture = Base64::encode_to_string(fs::read(to).unwrap()).unwrap();
    let long = "<b>Supercalifragilistic</b>".repeat(20);
    let machine = json!({"system": "1.2", "programs": "0.1.0", "slot": "a", "temperature_c": 50, "uptime_s": 90_000,
        "address": "192.168.1.20", "disk": {"total_bytes": 64_000_000_000_u64, "free_bytes": 41_000_000_000_u64}});
    let fine = json!({"screen": {}, "flock": "aurora", "generation": {"sequence": 7}});
    [
        json!({"unit": "lobby", "status": fine, "machine": machine, "picture": picture}),
        json!({"unit": "a".repeat(64), "error": long, "status": {"flock": long, "faults": 2,
            "latest_faults": [{"message": long}]}, "machine": {"system": long, "programs": long, "slot": long,
            "address": long, "rolled_back": {"from": long, "why": long}, "temperature_c": 99}}),
        json!({"unit": "nothing"}),
        json!({"unit": "stairs", "status": fine, "machine": machine}),
    ]
}

#[test]
fn the_page_of_all_units_is_whole_at_every_width_and_updates_by_itself() {
    let folder = tempfile::tempdir().unwrap();
    let fleet = Fleet::of(
        &folder.path().join("reports"),
        &["--unit", "lobby", "--unit", "stairs", "--unit", "nothing", "--unit", &"a".repeat(64), "--unit", "never"],
    );
    let reports = reports(folder.path());
    for report in &reports {
        assert_eq!(fleet.report(&report.to_string()), (204, String::new()));
    }
    let address = format!("http://{}/", fleet.place);
    let desk = Window { width: 1280, height: 900, is_dark: false, scale: 1 };
    let page = Page::open(&Browser::start(), &address, desk);
    page.until("the picture is there", "document.images.length === 1 && document.images[0].naturalWidth === 320");
    for (width, is_dark) in
        [(390, false), (390, true), (768, true), (1216, false), (1217, false), (1280, true), (1920, false)]
    {
        page.resize(Window { width, is_dark, ..desk });
        let outside = page.ask("document.documentElement.scrollWidth - innerWidth");
        assert_eq!(outside, 0, "at {width} pixels nothing is outside");
        let cut = page.ask("[...document.querySelectorAll('th, td, li, small')].filter(one => one.checkVisibility() && one.scrollWidth > one.clientWidth + 1 && one.closest('tbody')).map(one => one.textContent)");
        assert_eq!(cut, json!([]), "at {width} pixels nothing is cut");
    }
    assert_eq!(page.ask("document.title"), "(3) Fleet");
    assert_eq!(page.ask("document.querySelectorAll('tbody b b, script:not([src])').length"), 0);
    let rows = page.ask("[...document.querySelectorAll('tbody tr')].map(row => row.className).join(' ')");
    assert_eq!(rows, "wrong wrong wrong fine fine");
    let steps = page.ask("[...document.querySelectorAll('.wrong li:not(.remark)')].every(one => one.querySelector('em').textContent.length > 20)");
    assert_eq!(steps, true, "every wrong thing says what to do");

    page.press("Tab");
    page.press("Tab");
    assert_eq!(page.ask("document.activeElement.id"), "to-never");
    page.press("Enter");
    page.until("the row of the link is chosen", "document.activeElement.id === 'unit-never'");
    let mut newer = reports[3].clone();
    newer["status"]["flock"] = json!("dawn");
    assert_eq!(fleet.report(&newer.to_string()).0, 204);
    page.until_within("the new flock", NEWER_S, "document.querySelector('#unit-stairs').textContent.includes('dawn')");
    assert_eq!(page.ask("document.activeElement.id"), "unit-never", "what has the focus keeps it");
    assert_eq!(page.complaints(), [""; 0]);
    let elsewhere: Vec<_> = page.requests().into_iter().filter(|asked| !asked.starts_with(&address)).collect();
    assert_eq!(elsewhere, [""; 0]);
    assert_eq!(page.ask("document.getElementById('offline').checkVisibility()"), false);
    drop(fleet);
    page.until_within("that the server is gone", NEWER_S, "document.getElementById('offline').checkVisibility()");
}

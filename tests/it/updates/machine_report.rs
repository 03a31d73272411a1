//! What the report of a unit says of its machine.
//!
//! Owns the claims on the field `machine` of what `dreams-update` sends. Folders stand for `/sys` and for what
//! `dreams-mend` remembers; that it remembers a system that was left is claimed in `unit/boot_repair.rs`.

use claims::bundle_maker::rubbish;
use claims::programs::output;
use claims::unit::Unit;
use claims::web::{Behaviour, WebServer};
use rustix::fs::{major, minor};
use serde_json::{Value, json};
use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::Path;

/// The field that a unit sends whose system says `os`, on a machine with these files.
fn reported(os: &str, files: &[(&str, &str)]) -> Value {
    let unit = Unit::new();
    unit.maker.bundle(&unit.stick(), &rubbish(1, 500, 0), &[], 1);
    unit.updated(&[]);
    let home = WebServer::serve(&unit.stick(), Behaviour::Good);
    let [config, machine, system] = ["update.toml", "machine", "os-release"].map(|name| unit.path(name));
    fs::write(&system, os).unwrap();
    let device = fs::metadata(unit.path("store")).unwrap().dev();
    for (name, text) in files {
        let path = machine.join(name.replace("DEVICE", &format!("{}:{}", major(device), minor(device))));
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    let report_to = format!("{}/units", home.url());
    let settings = [
        ("machine", machine.display().to_string()),
        ("system", system.display().to_string()),
        ("synchronised", unit.path("synchronised").display().to_string()),
        ("status", "127.0.0.1:1".to_owned()),
        ("report_to", report_to),
    ];
    fs::write(&config, settings.map(|(key, value)| format!("{key} = '{value}'\n")).concat()).unwrap();
    let mut look = unit.update_from(Some(Path::new(&home.url())));
    let said = output(look.arg("--config").arg(&config).arg("--schedule").arg(unit.path("schedule")));
    assert_eq!(said.status.code(), Some(0), "{}", String::from_utf8_lossy(&said.stderr));
    let report: Value = serde_json::from_str(&home.received()[0]).unwrap();
    let mut machine = report["machine"].clone();
    assert!(machine["uptime_s"].take().as_u64().is_some_and(|uptime_s| uptime_s > 0), "{report}");
    machine
}

/// The total and the free bytes of the disk, which this program cannot know.
fn without_bytes(mut machine: Value) -> Value {
    let [total, free] = ["total_bytes", "free_bytes"].map(|key| machine["disk"][key].take().as_u64().unwrap());
    assert!(0 < free && free < total, "{free} of {total}");
    machine
}

/// The machine of a framed unit whose slot has this name.
fn framed(slot: &'static str) -> [(&'static str, &'static str); 7] {
    [
        ("sys/class/block/dm-0/slaves/mmcblk0p2/uevent", slot),
        ("sys/class/thermal/thermal_zone0/temp", "41000\n"),
        ("sys/class/thermal/thermal_zone1/temp", "-274000\n"),
        ("sys/class/hwmon/hwmon0/temp1_input", "47460\n"),
        ("sys/class/hwmon/hwmon0/temp1_crit", "99000\n"),
        ("sys/class/hwmon/hwmon1/name", "rubbish\n"),
        ("sys/dev/block/DEVICE/device/life_time", "0x02 0x04\n"),
    ]
}

const NEW: &str = "ID=dreams\nVERSION_ID=0.2.0\nDREAMS_DATE=2026-01-01T00:00:00Z\n";
const OLD: &str = "ID=dreams\nVERSION_ID=0.1.0\nDREAMS_DATE=2096-01-01T00:00:00Z\n";
const ROLLBACK: (&str, &str) =
    ("var/lib/dreams/mend/rollback", r#"{"from":"0.2.0","why":"System 0.2.0 did not show a hundred frames."}"#);

#[test]
fn a_unit_that_runs_a_new_system_reports_it_with_its_slot_heat_and_disk() {
    let files = [&framed("DEVTYPE=partition\nPARTNAME=dreams_b\n")[..], &[ROLLBACK]].concat();
    let disk = json!({ "total_bytes": null, "free_bytes": null, "worn_percent": 30 });
    let machine = json!({
        "system": "0.2.0", "programs": env!("CARGO_PKG_VERSION"), "slot": "b", "rolled_back": null, "uptime_s": null,
        "temperature_c": 47.5, "disk": disk, "address": "127.0.0.1", "time_known": true,
    });
    assert_eq!(without_bytes(reported(NEW, &files)), machine, "what it has left earlier runs now");
}

#[test]
fn a_unit_that_went_back_reports_from_which_system_and_why() {
    let files = [&framed("PARTNAME=dreams_a\n")[..], &[ROLLBACK]].concat();
    let machine = reported(OLD, &files);
    let left: Value = serde_json::from_str(ROLLBACK.1).unwrap();
    let found = ["system", "slot", "rolled_back", "time_known"].map(|key| machine[key].clone());
    assert_eq!(found, [json!("0.1.0"), json!("a"), left, json!(false)], "{machine}");
    for rubbish in ["", "{\"from\": 7}", r#"{"from":"next","why":""}"#, &"x".repeat(9_000)] {
        let machine = reported(OLD, &[(ROLLBACK.0, rubbish)]);
        assert_eq!((&machine["system"], &machine["rolled_back"]), (&json!("0.1.0"), &Value::Null), "{rubbish}");
    }
}

#[test]
fn a_machine_that_says_nothing_of_itself_is_reported_all_the_same() {
    let disk = json!({ "total_bytes": null, "free_bytes": null, "worn_percent": null });
    let machine = json!({
        "system": null, "programs": env!("CARGO_PKG_VERSION"), "slot": null, "rolled_back": null, "uptime_s": null,
        "temperature_c": null, "disk": disk, "address": "127.0.0.1", "time_known": true,
    });
    let other = "ID=debian\nVERSION_ID=13\nDREAMS_DATE=2026-01-01T00:00:00Z\n";
    assert_eq!(without_bytes(reported(other, &[])), machine);
    let rubbish = [
        ("sys/class/thermal/thermal_zone0/temp", "hot"),
        ("sys/class/hwmon/hwmon0/temp1_input", ""),
        ("sys/dev/block/DEVICE/device/life_time", "0x00 0xff x -1"),
        ROLLBACK,
    ];
    assert_eq!(without_bytes(reported(other, &rubbish)), machine, "another system has left none of ours");
}

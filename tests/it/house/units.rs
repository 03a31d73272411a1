//! What the unit files promise the appliance.
//!
//! Owns the claims about `systemd/`: that systemd understands every line, that little of the machine lies open to the
//! player, and that a restart is tried exactly where it can help. Never starts a service: the image's tests do.
//!
//! Start at [`judge`].

use std::fs;
use std::process::Command;

/// systemd's own measure of what lies open to a service: 0 nothing, 100 everything. It calls up to 19 `OK`.
const EXPOSED_AT_MOST: &str = "15";
/// Keys that systemd knows since 254; Debian 12 has 252, reads over them, and restarts at an even pace.
const YOUNG_KEYS: [&str; 2] = ["RestartSteps", "RestartMaxDelaySec"];

/// What `systemd-analyze` with `arguments` finds wrong with the unit file `text` of the name `name`; empty if nothing.
/// The programs of the unit file need not be installed: `/bin/true` stands in for each.
fn judge(name: &str, text: &str, arguments: &[&str]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    let line = |line: &str| match line.strip_prefix("ExecStart=/usr/bin/dreams-") {
        Some(_) => "ExecStart=/bin/true\n".to_owned(),
        None => format!("{line}\n"),
    };
    fs::write(&path, text.lines().map(line).collect::<String>()).unwrap();
    let output = Command::new("systemd-analyze").args(arguments).arg(&path).output().expect("systemd-analyze starts");
    let is_young = |line: &&str| YOUNG_KEYS.iter().any(|key| line.contains(&format!("Unknown key '{key}'")));
    let said = String::from_utf8(output.stderr).unwrap();
    let mut faults: String = said.lines().filter(|line| !is_young(line)).collect();
    if !output.status.success() {
        faults.push_str(&String::from_utf8(output.stdout).unwrap());
    }
    faults
}

fn player() -> String {
    super::read("systemd/dreams-player.service")
}

#[test]
fn systemd_understands_every_line_of_every_service() {
    for (path, text) in super::files(".service") {
        let name = path.rsplit('/').next().unwrap();
        assert_eq!(judge(name, &text, &["verify", "--man=no"]), "", "`{path}`");
    }
    let misspelt = player().replace("WatchdogSec", "WatchdogSecs");
    assert!(judge("dreams-player.service", &misspelt, &["verify", "--man=no"]).contains("WatchdogSecs"));
}

#[test]
fn a_unit_waits_for_its_display_and_its_page_may_stand_back() {
    let text = player();
    let has = |wanted: &str| text.lines().any(|line| line == wanted);
    assert!(has("ExecStart=/usr/bin/dreams-player --config /etc/dreams/player.toml --screen kms"));
    // `setpriority` is one of `@resources`.
    assert!(!has("SystemCallFilter=~@privileged @resources") || has("SystemCallFilter=setpriority"));
}

#[test]
fn little_of_the_machine_lies_open_to_the_player() {
    let threshold = format!("--threshold={EXPOSED_AT_MOST}");
    let measure = ["security", "--offline=true", "--no-pager", &threshold];
    assert_eq!(judge("dreams-player.service", &player(), &measure), "");
    let open = player().replace("ProtectSystem=strict", "").replace("CapabilityBoundingSet=", "#");
    assert_ne!(judge("dreams-player.service", &open, &measure), "");
}

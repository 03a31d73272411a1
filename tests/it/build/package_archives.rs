//! The archives that a unit's packages come from.
//!
//! Owns the claims on `image-build/archives`: this machine's archives, or snapshots of a time.

use claims::programs::{output, repository};
use std::fs;
use std::process::{Command, Output};
use tempfile::TempDir;

/// A machine with these settings of apt.
struct Machine {
    folder: TempDir,
}

impl Machine {
    fn new(settings: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("apt.conf"), settings).unwrap();
        Self { folder }
    }

    /// Runs `script` of `image-build` with `words`, and with this time, if there is one.
    fn run(&self, script: &str, words: &[&str], snapshot: Option<&str>) -> Output {
        let mut command = Command::new(repository().join("image-build").join(script));
        command.args(words).env("APT_CONFIG", self.folder.path().join("apt.conf")).env_remove("SNAPSHOT");
        output(command.envs(snapshot.map(|time| ("SNAPSHOT", time))).env("SOURCE_DATE_EPOCH", "1754697600"))
    }

    fn archives(&self, words: &[&str], snapshot: Option<&str>) -> Vec<String> {
        let said = self.run("archives", words, snapshot);
        assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
        String::from_utf8(said.stdout).unwrap().lines().map(str::to_owned).collect()
    }
}

const THEN: Option<&str> = Some("20261101T000000Z");

#[test]
fn packages_come_from_this_machines_archives_and_from_the_units_release() {
    let machine = Machine::new("");
    let lines = machine.archives(&[], None);
    let suites: Vec<&str> = lines.iter().map(|line| line.split(' ').nth(2).unwrap()).collect();
    let [release] = &machine.archives(&["release"], None)[..] else { panic!("one word") };
    assert!(suites.contains(&&**release) && suites.contains(&&*format!("{release}-security")), "{lines:?}");
    assert!(lines.iter().all(|line| line.starts_with("deb ") && line.contains(" main ")), "{lines:?}");
    assert_eq!(machine.archives(&["sources"], None).len(), 2 * lines.len(), "and their sources");
}

#[test]
fn a_time_pins_the_archives_to_what_they_held_then() {
    let debian = "deb [check-valid-until=no] https://snapshot.debian.org/archive/debian/20261101T000000Z/ trixie main";
    let lines = Machine::new("").archives(&[], THEN);
    assert!(lines.len() == 3 && lines[0].starts_with(debian), "{lines:?}");
    assert!(lines[2].contains("/archive/debian-security/20261101T000000Z/ trixie-security main"), "{lines:?}");

    let elsewhere = "Acquire::Snapshots::URI::Override::Label::Debian \"http://mirror.test/@SNAPSHOTID@/debian\";";
    let lines = Machine::new(elsewhere).archives(&[], THEN);
    assert!(lines[1].contains(" http://mirror.test/20261101T000000Z/debian trixie-updates "), "{lines:?}");

    let wrong = Machine::new("").run("archives", &[], Some("yesterday"));
    let said = String::from_utf8(wrong.stderr).unwrap();
    assert!(wrong.status.code() == Some(2) && said.contains("found `yesterday`"), "{said}");
}

#[test]
fn a_system_of_a_time_is_not_made_again_whatever_the_archives_hold_today() {
    // No server listens there.
    let machine =
        Machine::new("Acquire::http::Proxy \"http://127.0.0.1:9\"; Acquire::https::Proxy \"http://127.0.0.1:9\";");
    let inputs = |snapshot| {
        let said = machine.run("debian", &["--inputs"], snapshot);
        assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
        said.stdout
    };
    assert_eq!(inputs(THEN), inputs(THEN));
    assert_ne!(inputs(THEN), inputs(Some("20261102T000000Z")));
    assert!(!machine.run("debian", &["--inputs"], None).status.success(), "without a time the archives are asked");
}

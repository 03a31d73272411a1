//! Files of earlier versions can still be read.
//!
//! Owns the claim. `tests/fixtures/format-1` was made by programs of the first format: an artist's keys, statements and
//! outbox; a stick; a unit's store with a flock on trial, a good one, a bad one and a staged system; a saved place; and
//! an owner's settings. It is never made again.
//!
//! Start at [`OldFiles`].

use bundle::{LocalDisk, Sequence, Store, Trust};
use claims::bundle_maker::files_in;
use claims::programs::{self, json, output, repository, succeed};
use serde_json::Value;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

/// The passphrase of the fixture's keys.
const PASSPHRASE: &str = "velvet\n";

/// A copy of the fixture.
struct OldFiles {
    scratch: TempDir,
}

impl OldFiles {
    fn new() -> Self {
        let old_files = Self { scratch: tempfile::tempdir_in(programs::claims_folder()).unwrap() };
        let fixture = repository().join("tests/fixtures/format-1");
        succeed(Command::new("cp").arg("-r").arg(fixture.join(".")).arg(old_files.at("")));
        fs::write(old_files.at("passphrase"), PASSPHRASE).unwrap();
        for secret in ["passphrase", "keys/artist.key", "keys/lost.key", "keys/new.key", "keys/spare.key"] {
            fs::set_permissions(old_files.at(secret), fs::Permissions::from_mode(0o600)).unwrap();
        }
        old_files
    }

    fn at(&self, name: &str) -> PathBuf {
        self.scratch.path().join(name)
    }

    /// `dreams WORDS...`, which must end with `code`; returns its output on both streams.
    fn dreams(&self, code: i32, words: &[&str]) -> String {
        let said = output(Command::new(programs::dreams()).args(words).current_dir(self.at("")));
        let text = [said.stdout, said.stderr].map(|text| String::from_utf8(text).unwrap()).concat();
        assert_eq!(said.status.code(), Some(code), "{words:?}: {text}");
        text
    }

    fn update(&self, words: &[&str]) -> Output {
        let mut update = Command::new(programs::updater());
        update.args(["--json", "--unit", "lobby", "--store", "store", "--keys", "trusted", "--config", "update.toml"]);
        output(update.args(words).current_dir(self.at("")))
    }

    fn updated(&self, words: &[&str]) -> Value {
        let said = self.update(words);
        assert_eq!(said.status.code(), Some(0), "{words:?}: {}", String::from_utf8_lossy(&said.stderr));
        json(&said)
    }
}

/// The numbers of the last good generation and of the one on trial, and the highest number that was accepted.
fn known(store: &Path) -> (Option<u64>, Option<u64>, Option<Sequence>) {
    let trust = Trust::read(&store.join("../trusted")).unwrap();
    let store = Store::open(Box::new(LocalDisk::open(store).unwrap()), trust).unwrap();
    let state = store.state();
    let (good, trial) = (state.good.as_ref(), state.trial.as_ref());
    (good.map(|good| good.number), trial.map(|trial| trial.generation.number), state.floors.values().max().copied())
}

#[test]
fn a_store_of_the_first_format_is_read_with_all_that_it_knows() {
    let old_files = OldFiles::new();
    let playing = || files_in(&old_files.at("store/current")).unwrap();
    let before = playing();
    assert_eq!(known(&old_files.at("store")), (Some(3), Some(4), Some(Sequence(1))));
    let answer = old_files.updated(&["stick", "--scrub"]);
    assert_eq!(
        (&answer["outcome"], &answer["missing"], &answer["flock"]),
        (&"no-news".into(), &0.into(), &"fourth".into())
    );
    assert_eq!(answer["system"], "no-news", "the system that was staged waits to be written");
    assert!(playing() == before && before.len() == 3);
    // The key that was called back is known to be, and so is the number that was played.
    let said = old_files.update(&["lost"]);
    let error = String::from_utf8_lossy(&said.stderr);
    assert!(said.status.code() == Some(1) && error.contains("which was revoked"), "{error}");

    let path = old_files.at("state");
    let options = ["--screen", "virtual:64x64@30", "--clock", "free", "--status", "off", "--clips", "60", "--state"];
    let mut player = Command::new(programs::player());
    player.arg("--flock").arg(old_files.at("store/current")).args(options).arg(&path);
    let said = output(&mut player);
    let error = String::from_utf8_lossy(&said.stderr);
    assert!(said.status.success() && error.contains("resuming the path") && error.contains("faults=0"), "{error}");
    assert_eq!(known(&old_files.at("store")), (Some(4), None, Some(Sequence(3))), "the trial was won");
}

#[test]
fn a_store_of_the_first_format_learns_from_its_seals_that_its_flock_is_its_own() {
    let old_files = OldFiles::new();
    let sends = |unit: &[&str]| {
        let words = ["pack", "flock", "new", "--key", "keys/artist.key", "--passphrase-file", "passphrase"];
        old_files.dreams(0, &[&words, &["--allow-jumps"][..], unit].concat());
        fs::remove_dir_all(old_files.at("stick")).unwrap();
        fs::create_dir(old_files.at("stick")).unwrap();
        old_files.dreams(0, &["publish", "new", "stick", "--trust", "trusted"]);
        fs::remove_dir_all(old_files.at("new")).unwrap();
    };
    sends(&[]);
    let said = old_files.update(&["stick"]);
    let error = String::from_utf8_lossy(&said.stderr);
    assert!(said.status.code() == Some(1) && error.contains("takes only bundles for `lobby`"), "{error}");
    sends(&["--unit", "lobby"]);
    assert_eq!(old_files.updated(&["stick"])["outcome"], "installed");
}

#[test]
fn keys_seals_and_statements_of_the_first_format_are_read_and_what_they_sign_today_is_taken() {
    let old_files = OldFiles::new();
    let said = old_files.dreams(0, &["verify", "stick", "--trust", "trusted"]);
    assert!(said.contains("`fourth` for lobby, sequence 3") && said.contains("system 0.2.0 for every unit"), "{said}");
    let said = old_files.dreams(1, &["verify", "lost", "--trust", "trusted"]);
    assert!(said.contains("signed by key"), "{said}");
    let by = |key, more: &[&str]| {
        let words = ["pack", "flock", "outbox", "--key", key, "--passphrase-file", "passphrase", "--allow-jumps"];
        old_files.dreams(0, &[&words, more].concat())
    };
    let said = by("keys/artist.key", &["--unit", "lobby", "--statement", "keys/new.trusted"]);
    assert!(said.contains("packed `fourth` for lobby: sequence 5"), "{said}");
    old_files.dreams(0, &["publish", "outbox", "stick", "--trust", "trusted", "--unit", "lobby"]);
    assert_eq!(old_files.updated(&["stick"])["sequence"], 5);
    // The key that the artist's took in signs for a unit that knows neither.
    by("keys/new.key", &["--unit", "lobby"]);
    old_files.dreams(0, &["publish", "outbox", "stick", "--trust", "trusted", "--unit", "lobby"]);
    fs::remove_dir_all(old_files.at("store")).unwrap();
    assert_eq!(old_files.updated(&["stick"])["sequence"], 2);
}

#[test]
fn an_owners_settings_of_the_first_format_are_kept_as_they_were() {
    let old_files = OldFiles::new();
    let mut owner = Command::new(programs::owner());
    owner.args(["take-in", "owner", "--keep"]).arg(old_files.at("kept")).arg("--network").arg(old_files.at(""));
    for (option, name) in [("--name", "name"), ("--wifi", "wifi.conf"), ("--notice", "notice")] {
        owner.arg(option).arg(old_files.at(name));
    }
    let said = output(owner.current_dir(old_files.at("")));
    assert_eq!(said.status.code(), Some(0), "{}", String::from_utf8_lossy(&said.stderr));
    let read = |name: &str| fs::read_to_string(old_files.at(name)).unwrap();
    assert_eq!(read("kept"), read("owner/kept"));
    assert!(read("wired.conf").contains("Address=192.0.2.7/24") && read("wifi.conf").contains("psk=\"velvet under\""));
    // The kept settings say which keys are trusted.
    fs::write(old_files.at("update.toml"), "owner = \"owner/kept\"\nreserve_mib = 0\n").unwrap();
    let words =
        ["pack", "flock", "outbox", "--key", "keys/spare.key", "--passphrase-file", "passphrase", "--allow-jumps"];
    old_files.dreams(0, &[&words[..], &["--unit", "lobby"]].concat());
    fs::remove_file(old_files.at("trusted/spare.pub")).unwrap();
    fs::remove_dir_all(old_files.at("store")).unwrap();
    assert_eq!(old_files.updated(&["outbox"])["outcome"], "installed");
}

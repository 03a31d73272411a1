//! Settings that come to a unit on a stick.
//!
//! Owns the claims on the whole way: `dreams settings` signs an owner's file, `dreams-owner` takes it from the stick, makes
//! it the file on the owner's partition, and applies it. Which settings there are is tried in `crates/settings`, the form
//! of the signed file in `crates/bundle/src/settings.rs`.
//!
//! Start at [`Hall`].

use crate::syscall_faults::{at_every_step, broken};
use crate::tools::bundles::Artist;
use bundle::{Addressees, LocalDisk, PublicKey, SecretKey, Sequence, SettingsBody, Statement, Store, Trust, UnitId};
use claims::bundle_maker::rubbish;
use claims::owner::Settings;
use claims::programs::{self, output};
use claims::unit::Unit;
use rustix::fs::{CWD, FileType, Mode, mknodat};
use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Output};
use std::thread;

/// The owner's file before and after.
const OLD: &str = "unit = \"lobby\"\nwifi = \"Home\"\nwifi_password = \"velvet under\"\n";
const NEW: &str = "unit = \"lobby\"\nwifi = \"Hall\"\nwifi_password = \"satin above\"\nclosed = [\"Mon\"]\n";
const IN_USE: &str = "New settings are in use. You may remove the stick.";
const KNOWN: &str = "This frame has had these settings already. You may remove the stick.";
const UNKNOWN_KEY: &str = "These settings are not signed by a key of this frame.";
/// The file on the stick.
const ON_STICK: &str = "stick/settings/lobby.settings";

/// A unit called `lobby` with the settings [`OLD`], and the artist whose key is in its image.
struct Hall {
    artist: Artist,
    unit: Settings,
}

impl Hall {
    fn new() -> Self {
        let hall = Self { artist: Artist::new(), unit: Settings::new() };
        for folder in ["trusted", "stick"] {
            fs::create_dir(hall.artist.at(folder)).unwrap();
        }
        fs::copy(hall.artist.at("artist.pub"), hall.artist.at("trusted/artist.pub")).unwrap();
        fs::create_dir(hall.unit.path("inbox")).unwrap();
        let [keys, store] = [hall.artist.at("trusted"), hall.unit.path("store")];
        let config = format!("keys = '{}'\nstore = '{}'\n", keys.display(), store.display());
        fs::write(hall.unit.path("update.toml"), config).unwrap();
        assert_eq!(hall.unit.set(OLD), (Some(0), String::new()));
        hall
    }

    /// Signs the owner's file `text`; the rest of the command is `more`.
    fn sign(&self, text: &str, more: &[&str]) {
        fs::write(self.artist.at("new.toml"), text).unwrap();
        let words = ["settings", "new.toml", "--passphrase-file", "passphrase", "--out", "stick"];
        self.artist.says(0, &[&words, more].concat());
    }

    /// The same for `lobby`, by the artist's key.
    fn sign_for_lobby(&self, text: &str) {
        self.sign(text, &["--key", "artist.key", "--unit", "lobby"]);
    }

    /// Puts settings on the stick that `dreams settings` would refuse.
    fn forge(&self, text: &str, sequence: u64) {
        let key = SecretKey::read(&self.artist.at("artist.key"), || Ok("velvet".to_owned())).unwrap();
        let addressees = Addressees::of([UnitId::new("lobby").unwrap()]);
        let created = "2026-03-01T12:00:00Z".to_owned();
        let body = SettingsBody { addressees, sequence: Sequence(sequence), created, text: text.to_owned() };
        fs::create_dir_all(self.artist.at("stick/settings")).unwrap();
        fs::write(self.artist.at(ON_STICK), body.sign(&key).unwrap()).unwrap();
    }

    /// `dreams-owner` for the stick in `folder`.
    fn taking_from(&self, folder: &str) -> Command {
        let mut owner = Command::new(programs::owner());
        owner.arg("from-stick").arg(self.artist.at(folder)).arg("--config").arg(self.unit.path("update.toml"));
        owner.arg("--keep").arg(self.unit.path("kept")).arg("--inbox").arg(self.unit.path("inbox"));
        owner.arg("--notice").arg(self.unit.path("notice"));
        owner
    }

    /// `dreams-owner` for the owner's partition.
    fn install(&self) -> Command {
        let mut owner = Command::new(programs::owner());
        owner.arg("install").arg(self.unit.path("partition")).arg("--inbox").arg(self.unit.path("inbox"));
        owner.arg("--notice").arg(self.unit.path("notice"));
        owner
    }

    /// Runs `command`; returns its exit code, what it said, and the notice.
    fn ends(&self, command: &mut Command) -> (Option<i32>, String, Option<String>) {
        let _ = fs::remove_file(self.unit.path("notice"));
        let Output { status, stderr, .. } = output(command);
        let notice = self.unit.read("notice").map(|notice| {
            let notice: serde_json::Value = serde_json::from_str(&notice).unwrap();
            notice["text"].as_str().unwrap().to_owned()
        });
        (status.code(), String::from_utf8(stderr).unwrap(), notice)
    }

    /// Plugs the stick in, which must end with `code` and this notice.
    fn plugs(&self, code: i32, notice: Option<&str>) -> String {
        let (found, error, shown) = self.ends(&mut self.taking_from("stick"));
        assert_eq!((found, shown.as_deref()), (Some(code), notice), "{error}");
        error
    }

    /// Has what has arrived written to the partition, and applied.
    fn applies(&self) {
        let (code, error, notice) = self.ends(&mut self.install());
        assert_eq!((code, notice.as_deref()), (Some(0), Some(IN_USE)), "{error}");
        assert!(output(&mut self.unit.taking()).status.success());
    }

    /// The owner's file and the one before it.
    fn on_partition(&self) -> (Option<String>, Option<String>) {
        (self.unit.read("partition/dreams.toml"), self.unit.read("partition/dreams-before.toml"))
    }

    /// Whether nothing of the stick is used or waits.
    fn is_as_before(&self) -> bool {
        self.on_partition() == (Some(OLD.to_owned()), None) && !self.unit.path("inbox/arrived.json").exists()
    }
}

#[test]
fn signed_settings_on_a_stick_become_the_owners_file() {
    let hall = Hall::new();
    hall.plugs(0, None);
    hall.sign_for_lobby(NEW);
    hall.plugs(0, None);
    hall.applies();
    assert_eq!(hall.on_partition(), (Some(NEW.to_owned()), Some(OLD.to_owned())));
    assert!(hall.unit.read("kept.kept").unwrap().contains("closed = [\"Mon\"]"));
    assert!(hall.unit.read("wifi.conf").unwrap().contains("psk=\"satin above\""));
    // A stick that stays, or comes again, changes nothing, also not what its owner has edited since.
    let edited = NEW.replace("Mon", "Tue");
    assert_eq!(hall.unit.set(&edited), (Some(0), String::new()));
    hall.plugs(0, Some(KNOWN));
    let (code, _, notice) = hall.ends(&mut hall.install());
    assert_eq!((code, notice), (Some(0), None), "nothing waits");
    assert_eq!(hall.on_partition(), (Some(edited.clone()), Some(OLD.to_owned())));
    // The next ones.
    hall.sign_for_lobby(OLD);
    hall.plugs(0, None);
    hall.applies();
    assert_eq!(hall.on_partition(), (Some(OLD.to_owned()), Some(edited)));
}

#[test]
fn settings_for_every_unit_come_after_the_units_own() {
    let hall = Hall::new();
    hall.sign(&NEW.replace("unit = \"lobby\"\n", ""), &["--key", "artist.key"]);
    hall.sign_for_lobby(NEW);
    hall.plugs(0, None);
    hall.applies();
    assert_eq!(hall.on_partition().0.as_deref(), Some(NEW));
    fs::remove_file(hall.artist.at(ON_STICK)).unwrap();
    let older = "These settings are number 1. This frame has already had number 2.";
    let error = hall.plugs(1, Some(older));
    assert!(error.contains("have sequence 1, but this unit has already had 2 of key 7F6F7B501F4A54A9"), "{error}");
    let all = "closed = [\"Sun\"]\n";
    hall.sign(all, &["--key", "artist.key"]);
    hall.plugs(0, None);
    hall.applies();
    assert_eq!(hall.on_partition().0.as_deref(), Some(all));
}

#[test]
fn settings_for_others_or_with_mistakes_change_nothing() {
    let hall = Hall::new();
    hall.sign(&NEW.replace("lobby", "stairs"), &["--key", "artist.key", "--unit", "stairs"]);
    hall.plugs(1, Some("These settings are for stairs. This frame is lobby."));
    fs::rename(hall.artist.at("stick/settings/stairs.settings"), hall.artist.at(ON_STICK)).unwrap();
    let error = hall.plugs(1, Some("These settings are for stairs. This frame is lobby."));
    assert!(error.contains("the bundle is for `stairs`, this unit is `lobby`"), "{error}");

    hall.forge("unit = \"lobby\"\n\nbrightness = 400\n", 7);
    let wrong =
        "dreams.toml line 3: brightness is 1 to 100, or as \"07:00 100, 20:00 40\". The settings before it stay.";
    let error = hall.plugs(2, Some(wrong));
    assert!(error.contains("`dreams.toml` line 3, key `brightness`"), "{error}");
    hall.forge("unit = \"lobby\"\ncolour = 1\n", 7);
    hall.plugs(2, Some("dreams.toml line 2: unknown key colour. The settings before it stay."));
    hall.forge("  \n", 7);
    hall.plugs(2, Some("dreams.toml is empty. The settings before it stay."));

    hall.forge(NEW, 7);
    let mut bytes = fs::read(hall.artist.at(ON_STICK)).unwrap();
    let at = bytes.len() - 4;
    bytes[at] ^= 1;
    fs::write(hall.artist.at(ON_STICK), &bytes).unwrap();
    let error = hall.plugs(1, Some(UNKNOWN_KEY));
    assert!(error.contains("has an invalid signature of key 7F6F7B501F4A54A9"), "{error}");
    fs::write(hall.artist.at(ON_STICK), NEW).unwrap();
    hall.plugs(1, Some(UNKNOWN_KEY));
    fs::write(hall.artist.at(ON_STICK), vec![b'#'; 90_000]).unwrap();
    hall.plugs(1, Some("These settings are damaged, or were made wrongly."));
    assert!(hall.is_as_before());
    hall.forge(NEW, 7);
    hall.plugs(0, None);
}

#[test]
fn unknown_and_revoked_keys_set_nothing() {
    let hall = Hall::new();
    hall.artist.secret("spare.key", include_str!("../../fixtures/format-1/keys/spare.key"));
    let spare = include_str!("../../fixtures/format-1/keys/spare.pub");
    hall.sign(NEW, &["--key", "spare.key", "--unit", "lobby"]);
    let error = hall.plugs(1, Some(UNKNOWN_KEY));
    assert!(error.contains("which is not trusted (trusted: 7F6F7B501F4A54A9)"), "{error}");
    // The owner's file lets it send flocks, and no more.
    let with_key = format!("{OLD}keys = [\"{}\"]\n", spare.lines().nth(1).unwrap());
    assert_eq!(hall.unit.set(&with_key), (Some(0), String::new()));
    hall.plugs(1, Some(UNKNOWN_KEY));
    assert_eq!(hall.unit.set(OLD), (Some(0), String::new()));
    // A key of the image has it trusted, as the store has learned, and revokes it.
    let artist = SecretKey::read(&hall.artist.at("artist.key"), || Ok("velvet".to_owned())).unwrap();
    let spare = PublicKey::parse(spare.lines().nth(1).unwrap()).unwrap();
    let learn = |said: &Statement| {
        let disk = LocalDisk::open(&hall.unit.path("store")).unwrap();
        let mut store = Store::open(Box::new(disk), Trust::of([artist.public()])).unwrap();
        store.learn(&said.sign(&artist).unwrap()).unwrap();
    };
    learn(&Statement::Trust(spare.clone()));
    hall.plugs(0, None);
    fs::remove_file(hall.unit.path("inbox/arrived.json")).unwrap();
    learn(&Statement::Revoke(spare.id()));
    let error = hall.plugs(1, Some(UNKNOWN_KEY));
    assert!(error.contains("which was revoked"), "{error}");
    hall.sign_for_lobby(NEW);
    learn(&Statement::Revoke(artist.public().id()));
    let error = hall.plugs(1, Some(UNKNOWN_KEY));
    assert!(error.contains("key 7F6F7B501F4A54A9, which was revoked"), "{error}");
    for copy in ["store/state.0", "store/state.1"] {
        fs::write(hall.unit.path(copy), "damaged").unwrap();
    }
    let error = hall.plugs(3, Some("The memory of this frame does not take the settings. The picture goes on."));
    assert!(error.contains("cannot read what this unit knows of revoked keys"), "{error}");
    assert!(hall.is_as_before());
}

#[test]
fn a_link_or_pipe_instead_of_a_file_of_settings_is_refused() {
    let hall = Hall::new();
    hall.sign_for_lobby(NEW);
    let file = hall.artist.at(ON_STICK);
    fs::rename(&file, hall.artist.at("elsewhere")).unwrap();
    let again = Some("The stick could not be read to its end. Put it in again.");
    symlink(hall.artist.at("elsewhere"), &file).unwrap();
    hall.plugs(3, again);
    fs::remove_file(&file).unwrap();
    mknodat(CWD, &file, FileType::Fifo, Mode::RUSR, 0).unwrap();
    hall.plugs(3, again);
    fs::remove_dir_all(hall.artist.at("stick/settings")).unwrap();
    fs::write(hall.artist.at("stick/settings"), "a file of somebody").unwrap();
    hall.plugs(0, None);
    fs::remove_file(hall.artist.at("stick/settings")).unwrap();
    fs::create_dir(hall.artist.at("stick/settings")).unwrap();
    fs::write(hall.artist.at("stick/settings/readme.txt"), "holiday").unwrap();
    hall.plugs(0, None);
    assert!(hall.is_as_before());

    // The same on the owner's partition.
    hall.sign_for_lobby(NEW);
    let full = "The owner's partition does not take the new settings. The settings before it stay.";
    for put in [
        |path: &Path| mknodat(CWD, path, FileType::Fifo, Mode::RUSR, 0).unwrap(),
        |path: &Path| {
            fs::create_dir(path).unwrap();
        },
    ] {
        let path = hall.unit.path("partition/dreams.toml");
        fs::remove_file(&path).or_else(|_| fs::remove_dir(&path)).unwrap();
        put(&path);
        hall.plugs(0, None);
        let (code, error, notice) = hall.ends(&mut hall.install());
        assert_eq!((code, notice.as_deref()), (Some(3), Some(full)), "{error}");
        assert!(!path.is_file());
    }
    fs::remove_dir(hall.unit.path("partition/dreams.toml")).unwrap();
    hall.plugs(0, None);
    hall.applies();
    assert_eq!(hall.on_partition(), (Some(NEW.to_owned()), None));
}

#[test]
fn a_fault_at_any_step_leaves_the_old_file_or_the_new_one() {
    let hall = Hall::new();
    hall.sign_for_lobby(NEW);
    let reset = || {
        for name in ["inbox", "partition"] {
            fs::remove_dir_all(hall.unit.path(name)).unwrap();
            fs::create_dir(hall.unit.path(name)).unwrap();
        }
        fs::write(hall.unit.path("partition/dreams.toml"), OLD).unwrap();
    };
    let calls = ["write", "fsync", "rename", "renameat", "unlink", "unlinkat", "copy_file_range"];
    let recovers = |case: &str| {
        let there = hall.on_partition().0;
        assert!([OLD, NEW].iter().any(|text| there.as_deref() == Some(text)), "{case}: {there:?}");
        // The stick is plugged in again, or stays in over the start.
        let (code, error, _) = hall.ends(&mut hall.taking_from("stick"));
        assert_eq!(code, Some(0), "{case}: {error}");
        let (code, error, _) = hall.ends(&mut hall.install());
        assert_eq!(code, Some(0), "{case}: {error}");
        assert_eq!(hall.on_partition(), (Some(NEW.to_owned()), Some(OLD.to_owned())), "{case}");
        assert_eq!(hall.ends(&mut hall.taking_from("stick")).2.as_deref(), Some(KNOWN), "{case}");
    };
    let log = hall.unit.path("strace");
    let prepared = || {
        reset();
        hall.taking_from("stick")
    };
    let arriving = at_every_step(&calls, &log, prepared, |case| recovers(&format!("from-stick, {case}")));
    let prepared = || {
        reset();
        assert!(output(&mut hall.taking_from("stick")).status.success());
        hall.install()
    };
    let installing = at_every_step(&calls, &log, prepared, |case| recovers(&format!("install, {case}")));
    assert!(arriving >= 8 && installing >= 30, "only {arriving} and {installing} faults were seen");
}

#[test]
fn a_full_partition_keeps_its_file_and_says_so() {
    let hall = Hall::new();
    hall.sign_for_lobby(NEW);
    hall.plugs(0, None);
    let _ = fs::remove_file(hall.unit.path("notice"));
    let log = hall.unit.path("strace");
    // The first write is that of the file.
    let said = broken(&hall.install(), &log, "write", "error=ENOSPC", "1+");
    assert_eq!(said.status.code(), Some(3));
    assert!(!hall.unit.path("inbox/arrived.json").exists(), "it is not tried again and again");
    assert_eq!(hall.on_partition().0.as_deref(), Some(OLD));
    hall.plugs(0, None);
    hall.applies();
    assert_eq!(hall.on_partition(), (Some(NEW.to_owned()), Some(OLD.to_owned())));
}

#[test]
fn of_two_sticks_at_once_the_newer_settings_stay() {
    let hall = Hall::new();
    hall.sign_for_lobby(&NEW.replace("Mon", "Tue"));
    fs::rename(hall.artist.at("stick"), hall.artist.at("first")).unwrap();
    hall.sign_for_lobby(NEW);
    for _ in 0..20 {
        fs::remove_dir_all(hall.unit.path("inbox")).unwrap();
        fs::create_dir(hall.unit.path("inbox")).unwrap();
        thread::scope(|scope| {
            for folder in ["first", "stick"] {
                scope.spawn(|| output(&mut hall.taking_from(folder)));
            }
        });
        hall.applies();
        assert_eq!(hall.on_partition().0.as_deref(), Some(NEW));
    }
}

#[test]
fn the_updater_says_nothing_of_a_stick_with_settings_alone() {
    let hall = Hall::new();
    hall.sign_for_lobby(NEW);
    let unit = Unit::new();
    fs::create_dir(unit.stick().join("settings")).unwrap();
    fs::copy(hall.artist.at(ON_STICK), unit.stick().join("settings/lobby.settings")).unwrap();
    let answer = unit.updated(&[]);
    assert_eq!((&answer["outcome"], &answer["astray"]), (&"no-bundle".into(), &serde_json::Value::Null));
    assert_eq!(unit.notice(), None);
    // One stick may have both.
    unit.maker.bundle(&unit.stick(), &rubbish(2, 1_000, 0), &["lobby"], 1);
    assert_eq!(unit.updated(&[])["outcome"], "installed");
}

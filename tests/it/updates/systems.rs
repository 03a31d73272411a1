//! A system is updated like a flock, into the slot that does not run.
//!
//! Owns the claims on `dreams pack --system`, and on `dreams-update` in a unit's own system. Files stand for the slot
//! and for the boot partition; whole machines are in `tests/image/updates`.
//!
//! Start at [`UnitFiles`].

use crate::syscall_faults;
use crate::tools::bundles::Artist;
use claims::programs::{self, json, output};
use claims::systems::make_halves;
use rustix::process::geteuid;
use serde_json::Value;
use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

/// The system calls that change a disk.
const CHANGES: [&str; 6] = ["write", "fsync", "rename", "renameat", "unlink", "unlinkat"];

/// The boot loader's entries, and those of the running system.
const ENTRIES: &str = "boot/loader/entries";
const RUNS: &str = "boot/loader/entries/dreams_0.1.0_1+1.conf";

/// A unit that runs version 0.1.0, an artist, and the images of newer versions.
struct UnitFiles {
    artist: Artist,
}

impl UnitFiles {
    fn new() -> Self {
        let unit_files = Self { artist: Artist::new() };
        unit_files.runs("dreams", "0.1.0");
        fs::create_dir_all(unit_files.at(ENTRIES)).unwrap();
        fs::create_dir_all(unit_files.at("boot/EFI/dreams/0.1.0_1")).unwrap();
        fs::write(unit_files.at(RUNS), "what runs").unwrap();
        fs::write(unit_files.at("slot"), vec![0xee; 100_000]).unwrap();
        let system = unit_files.at("os-release");
        let config = format!("system = \"{}\"\nowner = \"/nowhere\"\nreserve_mib = 0\n", system.display());
        fs::write(unit_files.at("update.toml"), config).unwrap();
        for version in ["0.2.0", "0.3.0"] {
            unit_files.made(version);
        }
        unit_files
    }

    fn at(&self, name: &str) -> PathBuf {
        self.artist.at(name)
    }

    /// The `os-release` of the unit's system.
    fn runs(&self, id: &str, version: &str) {
        fs::write(self.at("os-release"), format!("ID={id}\nVERSION_ID={version}\n")).unwrap();
    }

    /// Writes an image of this version, as `make image` does.
    fn made(&self, version: &str) {
        let folder = self.at(version);
        make_halves(&folder, version);
        fs::create_dir_all(folder.join("keys")).unwrap();
        fs::copy(self.at("artist.pub"), folder.join("keys/artist.pub")).unwrap();
    }

    /// Signs this version, and copies it to the stick.
    fn pack(&self, version: &str, options: &[&str]) -> String {
        let words = ["pack", version, "outbox", "--system", "--key", "artist.key", "--passphrase-file", "passphrase"];
        let said = self.artist.says(0, &[&words, options].concat());
        fs::create_dir_all(self.at("stick")).unwrap();
        self.artist.says(0, &["publish", "outbox", "stick", "--trust", "artist.pub"]);
        said
    }

    /// `dreams-update` with these options.
    fn command(&self, words: &[&str]) -> Command {
        let mut command = Command::new(programs::updater());
        command.args(["--json", "--unit", "lobby", "--config"]).arg(self.at("update.toml")).args(words);
        for (option, name) in [("--store", "store"), ("--notice", "notice"), ("--keys", "artist.pub")] {
            command.arg(option).arg(self.at(name));
        }
        command
    }

    /// Updates from the stick.
    fn update(&self) -> Output {
        output(&mut self.command(&[self.at("stick").to_str().unwrap()]))
    }

    /// The result for the system on the stick.
    fn fetched(&self) -> Value {
        let said = self.update();
        assert_eq!(said.status.code(), Some(0), "{}", String::from_utf8_lossy(&said.stderr));
        json(&said)["system"].clone()
    }

    fn writer(&self) -> Command {
        self.command(&["--slot", self.at("slot").to_str().unwrap(), "--boot", self.at("boot").to_str().unwrap()])
    }

    /// Writes the fetched system to the slot; returns the result.
    fn written(&self) -> Value {
        let said = output(&mut self.writer());
        assert_eq!(said.status.code(), Some(0), "{}", String::from_utf8_lossy(&said.stderr));
        json(&said)["system"].clone()
    }

    /// The entries of the boot loader.
    fn entries(&self) -> Vec<String> {
        let mut entries: Vec<_> = fs::read_dir(self.at(ENTRIES)).unwrap().map(|e| e.unwrap().path()).collect();
        entries.retain(|entry| entry.extension().is_some_and(|ending| ending == "conf"));
        let name = |entry: &PathBuf| entry.file_name().unwrap().to_str().unwrap().to_owned();
        let mut names: Vec<_> = entries.iter().map(name).collect();
        names.sort();
        names
    }

    /// Whether the slot holds this version, and what was behind it before.
    fn slot_is(&self, version: &str) -> bool {
        fs::read(self.at("slot")).unwrap().starts_with(&fs::read(self.at(version).join("root.img")).unwrap())
    }

    fn told(&self) -> String {
        let text = fs::read_to_string(self.at("notice")).unwrap();
        serde_json::from_str::<Value>(&text).unwrap()["text"].as_str().unwrap().to_owned()
    }
}

#[test]
fn a_system_travels_like_a_flock_and_ends_in_the_slot_that_does_not_run() {
    let unit_files = UnitFiles::new();
    let said = unit_files.pack("0.2.0", &[]);
    assert!(said.contains("packed system 0.2.0 for every unit: sequence 1"), "{said}");
    let said = unit_files.artist.says(0, &["verify", "stick", "--trust", "artist.pub"]);
    assert!(said.contains("system 0.2.0 for every unit, sequence 1"), "{said}");
    assert_eq!(unit_files.fetched(), serde_json::json!({ "staged": "0.2.0" }));
    assert!(unit_files.told().starts_with("A new system is here"), "{}", unit_files.told());
    assert_eq!(unit_files.fetched(), "no-news", "it waits to be written");
    assert_eq!(unit_files.entries(), ["dreams_0.1.0_1+1.conf"]);

    assert_eq!(unit_files.written(), serde_json::json!({ "written": "0.2.0" }));
    assert!(unit_files.slot_is("0.2.0"));
    assert_eq!(
        unit_files.entries(),
        ["dreams_0.1.0_1+1.conf", "dreams_0.2.0_1+3.conf"],
        "three tries, then the one before"
    );
    for part in ["linux", "initramfs"] {
        let (there, sent) = (unit_files.at("boot/EFI/dreams/0.2.0_1").join(part), unit_files.at("0.2.0").join(part));
        assert!(fs::read(there).unwrap() == fs::read(sent).unwrap());
    }
    assert_eq!(
        (unit_files.written(), unit_files.fetched()),
        ("none".into(), "no-news".into()),
        "it has its chance, once"
    );

    // It runs, and is good: the next one takes the place of the one before.
    let entry = |name: &str| unit_files.at(ENTRIES).join(name);
    fs::rename(entry("dreams_0.2.0_1+3.conf"), entry("dreams_0.2.0_1+1.conf")).unwrap();
    unit_files.runs("dreams", "0.2.0");
    unit_files.pack("0.3.0", &["--unit", "lobby"]);
    assert_eq!(unit_files.fetched(), serde_json::json!({ "staged": "0.3.0" }));
    unit_files.written();
    assert!(unit_files.slot_is("0.3.0"));
    assert_eq!(unit_files.entries(), ["dreams_0.2.0_1+1.conf", "dreams_0.3.0_1+3.conf"]);
    // What is in the store of a system that was written goes with the next flock.
    assert!(!unit_files.at("store/system/staged").exists());
}

#[test]
fn a_system_that_is_not_newer_or_not_ours_or_not_signed_is_not_taken() {
    let unit_files = UnitFiles::new();
    unit_files.pack("0.2.0", &[]);
    unit_files.runs("debian", "13");
    assert_eq!(unit_files.fetched(), "none", "somebody else looks after that machine");
    for version in ["0.2.0", "0.10.0"] {
        unit_files.runs("dreams", version);
        assert_eq!(unit_files.fetched(), "no-news", "{version} runs");
    }
    unit_files.runs("dreams", "0.1.0");
    // Another system in the place of the signed one, half of it, or none at all.
    let root = unit_files.at("stick").join(object(&unit_files, "0.2.0/root.img"));
    let whole = fs::read(&root).unwrap();
    for spoiled in [[&whole[..100], b"x", &whole[101..]].concat(), whole[..5_000].to_vec()] {
        fs::write(&root, &spoiled).unwrap();
        assert_eq!(unit_files.update().status.code(), Some(3));
        assert!(unit_files.told().starts_with("This stick is damaged"), "{}", unit_files.told());
        let said = unit_files.artist.says(1, &["verify", "stick", "--trust", "artist.pub"]);
        assert!(said.contains("`root`"), "{said}");
    }
    fs::write(&root, &whole).unwrap();
    let seal = unit_files.at("stick/systems/all.seal");
    let text = fs::read_to_string(&seal).unwrap();
    fs::write(&seal, text.replace("version 0.2.0", "version 9.2.0")).unwrap();
    assert_eq!(unit_files.update().status.code(), Some(1));
    assert!(unit_files.told().contains("not signed by anybody"), "{}", unit_files.told());
    // Nothing of that was written.
    assert_eq!((unit_files.written(), unit_files.entries()), ("none".into(), vec!["dreams_0.1.0_1+1.conf".to_owned()]));
    fs::write(&seal, text).unwrap();
    assert_eq!(unit_files.fetched(), serde_json::json!({ "staged": "0.2.0" }));
    // Halves that were not made with each other are no system.
    fs::copy(unit_files.at("0.3.0/root.img"), unit_files.at("0.2.0/root.img")).unwrap();
    let words = ["pack", "0.2.0", "outbox", "--system", "--key", "artist.key", "--passphrase-file", "passphrase"];
    let said = unit_files.artist.says(2, &words);
    assert!(said.contains("is not the root that"), "{said}");
}

#[test]
fn keys_that_the_owner_gives_sign_flocks_and_no_systems() {
    let unit_files = UnitFiles::new();
    unit_files.pack("0.2.0", &[]);
    let artist = fs::read_to_string(unit_files.at("artist.pub")).unwrap();
    fs::write(unit_files.at("owner.toml"), format!("keys = [\"{}\"]\n", artist.lines().nth(1).unwrap())).unwrap();
    fs::create_dir(unit_files.at("keys")).unwrap();
    fs::create_dir(unit_files.at("system-keys")).unwrap();
    let config = |keys: &str| {
        let path = |name: &str| unit_files.at(name).display().to_string();
        let lines = [("system", "os-release"), ("owner", "owner.toml"), ("system_keys", keys)];
        let text = lines.map(|(key, name)| format!("{key} = \"{}\"\n", path(name))).concat();
        fs::write(unit_files.at("update.toml"), text + "reserve_mib = 0\n").unwrap();
    };
    let stick = unit_files.at("stick");
    let update = || {
        let mut command = Command::new(programs::updater());
        command.args(["--json", "--unit", "lobby", "--config"]).arg(unit_files.at("update.toml")).arg(&stick);
        for (option, name) in [("--store", "store"), ("--notice", "notice"), ("--keys", "keys")] {
            command.arg(option).arg(unit_files.at(name));
        }
        output(&mut command)
    };
    // Neither where the unit has a role for systems, nor where it has none.
    for keys in ["system-keys", "no-such-folder"] {
        config(keys);
        let said = update();
        let error = String::from_utf8_lossy(&said.stderr);
        assert!(said.status.code() == Some(1) && error.contains("is signed by key"), "{keys}: {error}");
    }
    unit_files.artist.pack(&["--unit", "lobby"]);
    fs::create_dir(unit_files.at("flocks")).unwrap();
    unit_files.artist.says(0, &["publish", "bundle", "flocks", "--trust", "artist.pub"]);
    let flock = output(Command::new(programs::updater()).args(["--json", "--unit", "lobby", "--config"]).args([
        unit_files.at("update.toml"),
        unit_files.at("flocks"),
        "--store".into(),
        unit_files.at("store"),
        "--keys".into(),
        unit_files.at("keys"),
    ]));
    assert_eq!(json(&flock)["outcome"], "installed", "{}", String::from_utf8_lossy(&flock.stderr));
    // A key with this role signs both.
    fs::copy(unit_files.at("artist.pub"), unit_files.at("system-keys/artist.pub")).unwrap();
    config("system-keys");
    let said = update();
    assert_eq!(
        json(&said)["system"],
        serde_json::json!({ "staged": "0.2.0" }),
        "{}",
        String::from_utf8_lossy(&said.stderr)
    );
}

#[test]
fn a_system_that_does_not_trust_whoever_signs_it_is_packed_only_if_that_is_asked_for() {
    let unit_files = UnitFiles::new();
    let words = ["pack", "0.2.0", "outbox", "--system", "--key", "artist.key", "--passphrase-file", "passphrase"];
    fs::remove_file(unit_files.at("0.2.0/keys/artist.pub")).unwrap();
    let said = unit_files.artist.says(2, &words);
    assert!(said.contains("system `0.2.0` does not trust key") && said.contains("it trusts nobody"), "{said}");
    unit_files.artist.says(0, &["keygen", "other.key", "--passphrase-file", "passphrase"]);
    fs::copy(unit_files.at("other.pub"), unit_files.at("0.2.0/keys/other.pub")).unwrap();
    assert!(!unit_files.artist.says(2, &words).contains("nobody"), "the key that it trusts is named");
    assert!(!unit_files.at("outbox").exists(), "nothing was packed");
    unit_files.artist.says(0, &[&words[..], &["--allow-untrusted"]].concat());
}

#[test]
fn a_slot_written_to_any_step_starts_what_ran_and_the_next_attempt_completes_it() {
    let unit_files = UnitFiles::new();
    unit_files.pack("0.2.0", &[]);
    unit_files.fetched();
    fs::write(unit_files.at(ENTRIES).join("dreams_0.0.9_1+0-3.conf"), "what was tried before").unwrap();
    fs::create_dir_all(unit_files.at("boot/EFI/dreams/0.0.9_1")).unwrap();
    fs::write(unit_files.at("boot/EFI/dreams/0.0.9_1/linux"), "what was tried before").unwrap();
    let kept: Vec<&str> = vec!["store", "boot", "slot"];
    let reset = || {
        for name in &kept {
            let (now, then) = (unit_files.at(name), unit_files.at(&format!("{name}.kept")));
            if now.is_dir() { fs::remove_dir_all(&now) } else { fs::remove_file(&now) }.ok();
            programs::succeed(Command::new("cp").arg("-a").arg(&then).arg(&now));
        }
    };
    for name in &kept {
        fs::rename(unit_files.at(name), unit_files.at(&format!("{name}.kept"))).unwrap();
    }
    let writer = || {
        reset();
        unit_files.writer()
    };
    let broken = syscall_faults::at_every_step(&CHANGES, &unit_files.at("strace"), writer, |case| {
        let entries = unit_files.entries();
        assert!(entries.contains(&"dreams_0.1.0_1+1.conf".to_owned()), "{case}: {entries:?}");
        if entries.contains(&"dreams_0.2.0_1+3.conf".to_owned()) {
            let kernel = fs::read(unit_files.at("boot/EFI/dreams/0.2.0_1/linux")).unwrap();
            let is_whole = unit_files.slot_is("0.2.0") && kernel == fs::read(unit_files.at("0.2.0/linux")).unwrap();
            assert!(is_whole, "{case}: what is started is whole");
        }
        unit_files.fetched();
        unit_files.written();
        assert!(unit_files.slot_is("0.2.0"), "{case}");
        assert_eq!(unit_files.entries(), ["dreams_0.1.0_1+1.conf", "dreams_0.2.0_1+3.conf"], "{case}");
    });
    assert!(broken > 20, "only {broken} steps were seen");
}

#[test]
fn whoever_writes_the_slot_only_reads_the_store_but_for_the_names_of_systems() {
    let unit_files = UnitFiles::new();
    unit_files.pack("0.2.0", &[]);
    unit_files.fetched();
    // As another user of the store's group: the mode of files holds root, too, without its capabilities.
    let store = unit_files.at("store");
    let mode = |change: &str| {
        programs::succeed(Command::new("chmod").args(["--recursive", change]).arg(&store));
        programs::succeed(Command::new("chmod").arg("u+w").arg(store.join("system")));
    };
    let write = || {
        mode("a-w");
        let writer = unit_files.writer();
        let mut bound = Command::new(if geteuid().is_root() { "setpriv" } else { "env" });
        if geteuid().is_root() {
            bound.args(["--bounding-set", "-all"]);
        }
        let said = output(bound.arg(writer.get_program()).args(writer.get_args()));
        mode("u+w");
        said
    };
    // A damaged half is not written. It is fetched again.
    let half = store.join(object(&unit_files, "0.2.0/root.img"));
    fs::remove_file(&half).unwrap();
    fs::write(&half, vec![0; 200_000]).unwrap();
    let said = write();
    assert_eq!(said.status.code(), Some(3), "{}", String::from_utf8_lossy(&said.stdout));
    assert!(!store.join("system/staged").exists(), "it is not tried again");
    assert_eq!(unit_files.entries(), ["dreams_0.1.0_1+1.conf"]);
    assert_eq!(unit_files.fetched(), serde_json::json!({ "staged": "0.2.0" }));
    assert!(!store.join("system/dropped").exists());

    let said = write();
    assert_eq!(said.status.code(), Some(0), "{}", String::from_utf8_lossy(&said.stderr));
    assert_eq!(json(&said)["system"], serde_json::json!({ "written": "0.2.0" }));
    assert!(unit_files.slot_is("0.2.0"));
    assert_eq!(unit_files.fetched(), "no-news", "it has its chance, once");
}

/// The path in a bundle of the content of this file.
fn object(unit_files: &UnitFiles, file: &str) -> String {
    bundle::ObjectId::of(&fs::read(unit_files.at(file)).unwrap()).path()
}

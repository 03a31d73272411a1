//! Damage in what a unit starts from is found, and repaired from a copy.
//!
//! Owns the claims on `dreams-mend`. Files stand for the slots, folders for the boot partitions; `veritysetup` makes
//! the roots, and `image-build/start` what the boot loader starts. Whole machines are in `tests/image/damage`.
//!
//! Start at [`UnitFiles`].

use crate::syscall_faults;
use bundle::{BootFiles, lay_out};
use claims::programs::{self, json, output, repository, succeed};
use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

const BLOCK: usize = 4096;
/// Blocks of a root: its hash tree has two levels.
const BLOCKS: usize = 300;
const SLOT: u64 = 2 << 20;
/// The system calls that change a disk.
const CHANGES: [&str; 5] = ["write", "pwrite64", "fsync", "rename", "unlink"];
const ENTRIES: &str = "loader/entries";
const SYSTEMS: &str = "EFI/dreams";
/// The files that an entry starts.
const PARTS: [&str; 2] = ["linux", "initramfs"];

/// A unit that runs 0.2.0 from slot b; 0.1.0 is in slot a.
struct UnitFiles {
    folder: TempDir,
}

impl UnitFiles {
    fn new() -> Self {
        let unit_files = Self { folder: tempfile::tempdir().unwrap() };
        for (version, slot) in [("0.1.0", "a"), ("0.2.0", "b")] {
            unit_files.make(version, slot);
            for boot in ["boot", "spare"] {
                for copy in [1, 2] {
                    unit_files.lay(version, boot, copy);
                }
            }
        }
        for folder in ["loader/EFI/BOOT", "loader/loader"] {
            fs::create_dir_all(unit_files.at(folder)).unwrap();
        }
        for file in ["EFI/BOOT/BOOTX64.EFI", "EFI/BOOT/grubx64.efi", "loader/loader.conf"] {
            fs::write(unit_files.at("loader").join(file), format!("the loader {file}\n").repeat(1_000)).unwrap();
        }
        let sums = "find . -type f -printf '%P\\n' | sort | xargs sha256sum > ../sums && mv ../sums loader/";
        succeed(Command::new("sh").current_dir(unit_files.at("loader")).args(["-ec", sums]));
        for boot in ["boot", "spare"] {
            succeed(Command::new("cp").arg("-a").arg(unit_files.at("loader/.")).arg(unit_files.at(boot)));
        }
        unit_files
    }

    /// The same, with 0.2.0 in both slots.
    fn out_of_its_box() -> Self {
        let unit_files = Self::new();
        fs::copy(unit_files.at("b"), unit_files.at("a")).unwrap();
        for (boot, copy) in [("boot", 1), ("boot", 2), ("spare", 1), ("spare", 2)] {
            fs::remove_file(unit_files.at(boot).join(ENTRIES).join(format!("dreams_0.1.0_{copy}+1.conf"))).unwrap();
        }
        unit_files.looks("boot", 0);
        unit_files
    }

    fn at(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Copies a system to a boot partition, as this copy.
    fn lay(&self, version: &str, boot: &str, copy: u8) {
        let bytes = fs::read(self.at(version)).unwrap();
        let BootFiles { entry, parts } = lay_out(&bytes, copy).expect("it is whole");
        let name = format!("{ENTRIES}/dreams_{version}_{copy}+1.conf");
        for (path, part) in parts.into_iter().chain([(name, entry.as_bytes())]) {
            let path = self.at(boot).join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, part).unwrap();
        }
    }

    /// Makes a system: its root in a slot, and its start files in the file `version`.
    fn make(&self, version: &str, slot: &str) {
        let root: Vec<u8> =
            (0..BLOCKS * BLOCK).map(|at| (at / 7 * usize::from(version.as_bytes()[2]) % 251) as u8).collect();
        let (slot, size) = (self.at(slot), root.len().to_string());
        fs::write(&slot, root).unwrap();
        let salt = "5a".repeat(32);
        let uuid = format!("00000000-0000-4000-8000-000000000{}", version.replace('.', ""));
        let mut format = Command::new("veritysetup");
        format.args(["format", "--hash-offset", &size, "--data-blocks", &BLOCKS.to_string()]);
        let said = succeed(format.args(["--salt", &salt, "--uuid", &uuid]).args([&slot, &slot]));
        let said = String::from_utf8(said).unwrap();
        let hash = said.lines().find_map(|line| line.strip_prefix("Root hash:")).expect("it has a root").trim();
        fs::File::options().write(true).open(&slot).unwrap().set_len(SLOT).unwrap();
        let name = uuid.replace('-', "");
        for part in PARTS {
            fs::write(self.at(part), format!("{part} of {version}\n").repeat(1_000)).unwrap();
        }
        let words = format!("dreams.version={version} dreams.root={name}:{BLOCKS}:{salt}:{hash} gpt");
        let mut start = Command::new(repository().join("image-build/start"));
        succeed(start.arg(self.at(version)).args([version, &words]).args(PARTS.map(|part| self.at(part))));
    }

    fn command(&self, look: &str) -> Command {
        self.command_of("0.2.0", look)
    }

    /// The check while this version runs.
    fn command_of(&self, running: &str, look: &str) -> Command {
        let mut command = Command::new(programs::mender());
        command.args([look, "--json", "--running", running]);
        for (option, name) in [("--boot", "boot"), ("--spare", "spare"), ("--slot", "a"), ("--slot", "b")] {
            command.arg(option).arg(self.at(name));
        }
        command.arg("--loader").arg(self.at("loader")).arg("--notice").arg(self.at("notice"));
        command
    }

    /// Runs the check, which must end with this status; returns what was repaired, and what is lost.
    fn looks(&self, look: &str, status: i32) -> [Vec<String>; 2] {
        let said = output(&mut self.command(look));
        assert_eq!(said.status.code(), Some(status), "{}", String::from_utf8_lossy(&said.stderr));
        let found = json(&said);
        ["mended", "lost"].map(|key| {
            let names = found[key].as_array().unwrap().iter();
            names.map(|name| self.below(Path::new(name.as_str().unwrap()))).collect()
        })
    }

    fn below(&self, path: &Path) -> String {
        path.strip_prefix(self.folder.path()).unwrap().to_str().unwrap().to_owned()
    }

    /// Overwrites a few bytes of a file.
    fn spoil(&self, name: &str, at: u64) {
        let file = fs::File::options().write(true).open(self.at(name)).unwrap();
        file.write_all_at(b"rubbish", at).unwrap();
    }

    /// Everything that the unit starts from.
    fn all(&self) -> BTreeMap<String, Vec<u8>> {
        let said =
            succeed(Command::new("find").current_dir(&self.folder).args(["a", "b", "boot", "spare", "-type", "f"]));
        let names = String::from_utf8(said).unwrap();
        names.lines().map(|name| (name.to_owned(), fs::read(self.at(name)).unwrap())).collect()
    }
}

/// The name of the running system's entry.
fn entry(boot: &str, copy: u8) -> String {
    format!("{boot}/{ENTRIES}/dreams_0.2.0_{copy}+1.conf")
}

#[test]
fn whatever_is_damaged_once_is_whole_again_and_nothing_else_is_touched() {
    let unit_files = UnitFiles::new();
    let whole = unit_files.all();
    assert_eq!(unit_files.looks("all", 0), [vec![], Vec::<String>::new()]);
    assert!(!unit_files.at("notice").exists(), "nobody is told anything");
    let part = |boot: &str, copy: u8, part: &str| format!("{boot}/{SYSTEMS}/0.2.0_{copy}/{part}");
    // What is damaged, and what is said to be mended.
    let mut cases: Vec<_> = ["boot/EFI/BOOT/BOOTX64.EFI", "spare/EFI/BOOT/grubx64.efi", "boot/loader/loader.conf"]
        .map(|name| (name.to_owned(), name.to_owned()))
        .into();
    for (boot, copy) in [("boot", 1), ("boot", 2), ("spare", 1)] {
        cases.push((entry(boot, copy), entry(boot, copy)));
        cases.extend(PARTS.map(|name| (part(boot, copy, name), entry(boot, copy))));
    }
    for (name, told) in &cases {
        let size = fs::metadata(unit_files.at(name)).unwrap().len();
        for at in [0, 0x90, size / 2, size - 7] {
            unit_files.spoil(name, at);
            assert_eq!(unit_files.looks("boot", 0), [vec![told.clone()], vec![]], "byte {at} of {name}");
            assert!(unit_files.all() == whole, "byte {at} of {name}");
        }
        fs::remove_file(unit_files.at(name)).unwrap();
        unit_files.looks("all", 0);
        assert!(unit_files.all() == whole, "{name} was gone");
    }
    unit_files.spoil("boot/loader/sums", 3);
    unit_files.looks("boot", 0);
    assert!(unit_files.all() == whole, "the sums of the boot loader");
    let notice = fs::read_to_string(unit_files.at("notice")).unwrap();
    assert!(notice.contains("was damaged, and is mended"), "{notice}");
}

#[test]
fn any_block_of_a_slot_that_is_damaged_is_mended_from_the_other_slot_if_that_holds_the_same() {
    let unit_files = UnitFiles::out_of_its_box();
    let whole = unit_files.all();
    assert!(!whole.keys().any(|name| name.contains("0.1.0")), "what no entry starts is gone");
    let block = |number: usize| (number * BLOCK) as u64;
    // The first block and the last, the superblock's name and salt, the top of the tree and its end.
    for at in [0, block(BLOCKS) - 7, block(BLOCKS) + 20, block(BLOCKS) + 90, block(BLOCKS + 1), block(BLOCKS + 4) + 100]
    {
        for slot in ["a", "b"] {
            unit_files.spoil(slot, at);
            assert_eq!(unit_files.looks("all", 0), [vec![slot.to_owned()], vec![]], "byte {at}");
            assert!(unit_files.all() == whole, "byte {at} of {slot}");
        }
    }
}

#[test]
fn a_slot_whose_superblock_can_not_be_read_is_written_again() {
    let unit_files = UnitFiles::out_of_its_box();
    let whole = unit_files.all();
    let slot = unit_files.at("a").display().to_string();
    // Once for each of the four copies whose root may be there.
    let options = ["-P", &slot, "-e", "trace=pread64,pwrite64", "-e", "inject=pread64:error=EIO:when=1..4"];
    let said = syscall_faults::traced(&unit_files.command("all"), &unit_files.at("strace"), &options);
    assert_eq!(said.status.code(), Some(0), "{}", String::from_utf8_lossy(&said.stderr));
    assert_eq!(json(&said)["mended"], serde_json::json!([slot]));
    let log = fs::read_to_string(unit_files.at("strace")).unwrap();
    assert!(log.contains(" pwrite64("), "{log}");
    assert!(unit_files.all() == whole);
}

#[test]
fn a_slot_whose_system_is_lost_takes_in_the_one_that_runs_and_nothing_points_to_the_lost_one() {
    let unit_files = UnitFiles::new();
    unit_files.spoil("a", 5_000);
    let [mended, lost] = unit_files.looks("all", 0);
    assert_eq!((mended, lost), (vec!["a".to_owned()], vec![]));
    assert!(
        fs::read(unit_files.at("a")).unwrap()[..BLOCKS * BLOCK]
            == fs::read(unit_files.at("b")).unwrap()[..BLOCKS * BLOCK]
    );
    let files = unit_files.all();
    assert!(!files.keys().any(|name| name.contains("0.1.0")), "{:?}", files.keys());
    assert_eq!(unit_files.looks("all", 0), [vec![], Vec::<String>::new()]);
}

#[test]
fn what_runs_is_never_overwritten_by_something_else() {
    let unit_files = UnitFiles::new();
    unit_files.spoil("b", 5_000);
    let before = unit_files.all();
    assert_eq!(unit_files.looks("all", 1), [vec![], vec!["b".to_owned()]]);
    assert!(unit_files.all() == before, "the system that runs is damaged, and the other one is another system");
}

#[test]
fn a_system_on_trial_has_no_other_copy_until_it_is_good() {
    let unit_files = UnitFiles::new();
    let name = |boot: &str, name: &str| unit_files.at(boot).join(ENTRIES).join(name);
    for entry in [entry("boot", 2), entry("spare", 1), entry("spare", 2)] {
        fs::remove_file(unit_files.at(&entry)).unwrap();
    }
    let (trial, good) = (name("boot", "dreams_0.2.0_1+2-1.conf"), unit_files.at(&entry("boot", 1)));
    fs::rename(&good, &trial).unwrap();
    unit_files.looks("all", 0);
    assert!(
        !unit_files.at(&entry("boot", 2)).exists() && !unit_files.at(&entry("spare", 1)).exists() && trial.exists()
    );
    fs::rename(&trial, &good).unwrap();
    assert_eq!(unit_files.looks("boot", 0), [vec![], Vec::<String>::new()], "it was not damaged");
    for (boot, copy) in [("boot", 2), ("spare", 1), ("spare", 2)] {
        let text = fs::read_to_string(unit_files.at(&entry(boot, copy))).unwrap();
        assert!(text.contains(&format!("/0.2.0_{copy}/linux")), "{text}");
    }
    // One that gave way is called so everywhere.
    fs::rename(name("boot", "dreams_0.1.0_1+1.conf"), name("boot", "dreams_0.1.0_1+0-1.conf")).unwrap();
    unit_files.looks("boot", 0);
    assert!(!name("spare", "dreams_0.1.0_2+1.conf").exists() && name("spare", "dreams_0.1.0_2+0-1.conf").exists());
}

#[test]
fn a_system_that_was_left_is_remembered_with_the_reason_and_people_are_told_once() {
    let unit_files = UnitFiles::new();
    let (memory, notice) = (unit_files.at("rollback"), unit_files.at("notice"));
    let look = |running: &str| {
        fs::remove_file(&notice).ok();
        let said = output(unit_files.command_of(running, "boot").arg("--rollback").arg(&memory));
        assert_eq!(said.status.code(), Some(0), "{}", String::from_utf8_lossy(&said.stderr));
        let read =
            |path: &Path| fs::read(path).ok().map(|text| serde_json::from_slice::<serde_json::Value>(&text).unwrap());
        (read(&memory), read(&notice).map(|notice| notice["text"].as_str().unwrap().to_owned()))
    };
    let renamed = |from: &str, to: &str| {
        for (boot, copy) in [("boot", 1), ("boot", 2), ("spare", 1), ("spare", 2)] {
            let name = |tries| unit_files.at(boot).join(ENTRIES).join(format!("dreams_0.2.0_{copy}+{tries}.conf"));
            fs::rename(name(from), name(to)).unwrap();
        }
    };
    assert_eq!(look("0.2.0"), (None, None), "the newest system runs");
    assert_eq!(look("0.1.0"), (None, None), "the newer one is to be started");

    renamed("1", "0-3");
    let why = "System 0.2.0 did not show a hundred frames in 3 starts.";
    let left = Some(serde_json::json!({ "from": "0.2.0", "why": why }));
    assert_eq!(look("0.1.0"), (left.clone(), Some(format!("{why} 0.1.0 runs again."))));
    assert_eq!(look("0.1.0"), (left.clone(), None), "people know");
    fs::remove_file(&memory).unwrap();
    fs::create_dir(&memory).unwrap();
    fs::remove_file(&notice).ok();
    let said = output(unit_files.command_of("0.1.0", "boot").arg("--rollback").arg(&memory));
    assert_eq!((said.status.code(), notice.exists()), (Some(0), false), "what cannot be remembered stops nothing");
    fs::remove_dir(&memory).unwrap();

    renamed("0-3", "0-1");
    let (left, told) = look("0.1.0");
    let told = told.expect("it is new to this unit");
    assert!(left.is_some() && told.contains("failed to start") && told.ends_with("0.1.0 runs again."), "{told}");
    renamed("0-1", "1");
    assert_eq!(look("0.1.0"), (left, None), "until it runs");
    assert_eq!(look("0.2.0"), (None, None), "it runs after all");
}

#[test]
fn a_look_that_is_cut_short_at_any_step_leaves_what_runs_whole_and_the_next_one_ends_it() {
    let unit_files = UnitFiles::new();
    let damage = || {
        unit_files.spoil("a", 5_000);
        unit_files.spoil(&format!("boot/{SYSTEMS}/0.2.0_1/linux"), 1_005);
        unit_files.spoil(&entry("boot", 2), 20);
        unit_files.spoil("spare/EFI/BOOT/grubx64.efi", 3_000);
    };
    damage();
    let kept = unit_files.all();
    let reset = || {
        for name in unit_files.all().into_keys().filter(|name| !kept.contains_key(name)) {
            fs::remove_file(unit_files.at(&name)).unwrap();
        }
        for (name, bytes) in &kept {
            fs::create_dir_all(unit_files.at(name).parent().unwrap()).unwrap();
            fs::write(unit_files.at(name), bytes).unwrap();
        }
    };
    let look = || {
        reset();
        unit_files.command("all")
    };
    unit_files.looks("all", 0);
    let whole = unit_files.all();
    let broken = syscall_faults::at_every_step(&CHANGES, &unit_files.at("strace"), look, |case| {
        let cut = unit_files.all();
        let is = |name: &str| cut.get(name) == whole.get(name);
        let copy = |number: u8| {
            is(&entry("spare", number))
                && PARTS.iter().all(|part| is(&format!("spare/{SYSTEMS}/0.2.0_{number}/{part}")))
        };
        assert!(is("b") && copy(1) && copy(2), "{case}");
        unit_files.looks("all", 0);
        assert!(unit_files.all() == whole, "{case}");
    });
    assert!(broken > 40, "only {broken} steps were seen");
}

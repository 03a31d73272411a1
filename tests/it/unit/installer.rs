//! The stick that installs a unit, on a machine whose disks are files.
//!
//! Owns the claims on `dreams-install`: what it writes, when, and what it leaves alone. The pages are those on its standard
//! output; the keys come through a pipe in the place of a keyboard. Real disks are in `tests/image`.
//!
//! Start at [`Computer`].

use claims::programs::{installer, output, succeed};
use claims::wait;
use rustix::fs::{CWD, FileType, Mode, mknodat};
use serde_json::Value;
use sha2::{Digest, Sha256};
use std::fs::{self, File, OpenOptions};
use std::io::{BufReader, Write};
use std::os::unix::fs::{FileExt, symlink};
use std::path::PathBuf;
use std::process::{Child, ChildStdout, Command, Stdio};
use tempfile::TempDir;

const MIB: u64 = 1 << 20;
/// A stick's partitions of a megabyte each, and a unit's where they differ: type, name. Firmware starts from the type `U`.
const STICK: [(u32, &str, &str); 6] = [
    (1, "U", "dreams_install"),
    (2, "L", "dreams_a"),
    (3, "L", "dreams_b"),
    (4, "L", "dreams_owner"),
    (5, "L", "dreams_tries"),
    (7, "L", "dreams_spare"),
];
const EFI_SYSTEM: &str = "C12A7328-F81F-11D2-BA4B-00A0C93EC93B";
/// Where the flocks of a unit begin, and how large a disk is.
const FLOCKS: u64 = 7 * MIB;
const DISK: u64 = 200 * MIB;
/// Keys.
const ENTER: u16 = 28;
const DELETE: u16 = 111;
const SPACE: u16 = 57;
const TWO: u16 = 3;
/// Longer than a page must be visible before Enter counts.
const A_WHILE_S: u32 = 3;

/// A computer that was started from the stick `sdb`, with the disk `nvme0n1`.
struct Computer {
    folder: TempDir,
    sum: String,
}

/// The installer on it.
struct Run {
    child: Child,
    said: BufReader<ChildStdout>,
    keyboard: File,
}

/// Bytes that differ from partition to partition.
fn content(number: u32) -> Vec<u8> {
    let mut bytes = vec![0; MIB as usize];
    blake3::Hasher::new().update(&number.to_le_bytes()).finalize_xof().fill(&mut bytes);
    bytes
}

fn tables(file: &PathBuf, rows: &str) {
    let mut sfdisk =
        Command::new("sfdisk").args(["--quiet", "--wipe", "never"]).arg(file).stdin(Stdio::piped()).spawn().unwrap();
    let script = format!("label: gpt\nfirst-lba: 2048\n{rows}");
    sfdisk.stdin.take().unwrap().write_all(script.as_bytes()).unwrap();
    assert!(wait::ended("sfdisk", 60, &mut sfdisk).success());
}

impl Computer {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let computer = Self { folder, sum: String::new() };
        for path in ["dev/input", "sys/block"] {
            fs::create_dir_all(computer.path(path)).unwrap();
        }
        computer.add("sdb", 16 * MIB, "Stick");
        computer.add("nvme0n1", DISK, "Samsung SSD");
        let stick = computer.path("dev/sdb");
        let rows = STICK.map(|(number, kind, name)| format!("{number} : size=1M, type={kind}, name={name}\n"));
        tables(&stick, &rows.concat());
        let (file, mut sum) = (OpenOptions::new().write(true).open(&stick).unwrap(), Sha256::new());
        for (place, (number, ..)) in (1..).zip(STICK) {
            file.write_all_at(&content(number), place * MIB).unwrap();
        }
        // The unit's first partition is a copy of its last one.
        for number in [7, 2, 3, 5, 7] {
            sum.update(content(number));
        }
        let sum: Vec<_> = sum.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
        mknodat(CWD, computer.path("dev/input/event0"), FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
        Self { sum: sum.concat(), ..computer }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Adds a disk of so many bytes, filled with something.
    fn add(&self, name: &str, bytes: u64, model: &str) {
        let file = File::create(self.path(&format!("dev/{name}"))).unwrap();
        file.set_len(bytes).unwrap();
        for at in (0..bytes).step_by(MIB as usize) {
            file.write_all_at(b"somebody's work", at).unwrap();
        }
        self.list(name, bytes, model);
    }

    /// Has the kernel list a disk.
    fn list(&self, name: &str, bytes: u64, model: &str) {
        let folder = self.path(&format!("sys/block/{name}"));
        for inner in ["queue", "device"] {
            fs::create_dir_all(folder.join(inner)).unwrap();
        }
        let sectors = (bytes / 512).to_string();
        for (file, text) in [
            ("size", &*sectors),
            ("ro", "0"),
            ("removable", "0"),
            ("queue/logical_block_size", "512"),
            ("device/model", model),
        ] {
            fs::write(folder.join(file), format!("{text}\n")).unwrap();
        }
    }

    fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(&format!("dev/{name}"))).unwrap()
    }

    /// The disk's bytes at this megabyte.
    fn megabyte(&self, at: u64) -> Vec<u8> {
        let mut bytes = vec![0; MIB as usize];
        File::open(self.path("dev/nvme0n1")).unwrap().read_exact_at(&mut bytes, at * MIB).unwrap();
        bytes
    }

    fn overwrite(&self, name: &str, at: u64, bytes: &[u8]) {
        let file = OpenOptions::new().write(true).open(self.path(&format!("dev/{name}"))).unwrap();
        file.write_all_at(bytes, at).unwrap();
    }

    /// The partitions of the disk, as `sfdisk` reads them: number, type, name, and the first sector.
    fn partitions(&self) -> Vec<(String, String, String, u64)> {
        let disk = self.path("dev/nvme0n1");
        let said = succeed(Command::new("sfdisk").arg("--json").arg(&disk));
        let table: Value = serde_json::from_slice(&said).unwrap();
        let parts = table["partitiontable"]["partitions"].as_array().unwrap();
        let text = |part: &Value, key: &str| part[key].as_str().unwrap_or_default().to_owned();
        let node = |part: &Value| text(part, "node").rsplit('p').next().unwrap().to_owned();
        let row = |part: &Value| (node(part), text(part, "type"), text(part, "name"), part["start"].as_u64().unwrap());
        parts.iter().map(row).collect()
    }

    /// Checks both copies of the disk's table.
    fn table_is_whole(&self) {
        let said = output(Command::new("sfdisk").arg("--verify").arg(self.path("dev/nvme0n1")));
        let error = String::from_utf8_lossy(&said.stderr);
        assert!(said.status.success() && error.is_empty(), "{error}");
    }

    fn start(&self) -> Run {
        let mut command = Command::new(installer());
        command.args(["--stick", "sdb", "--screen", "virtual", "--sum", &self.sum, "--root"]).arg(self.folder.path());
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let said = BufReader::new(child.stdout.take().unwrap());
        let keyboard = OpenOptions::new().read(true).write(true).open(self.path("dev/input/event0")).unwrap();
        Run { child, said, keyboard }
    }

    /// Installs the unit, with these keys before Enter.
    fn install(&self, keys: &[u16]) {
        let mut run = self.start();
        run.page("Install the picture");
        for key in keys {
            run.press(*key);
            run.page("Install the picture");
        }
        run.wait();
        run.press(ENTER);
        run.page("Installed");
    }
}

impl Run {
    /// The text of the next page that has this title; others may come before it.
    fn page(&mut self, title: &str) -> String {
        loop {
            let line = wait::line(&format!("the page `{title}`"), 60, &mut self.said);
            assert!(!line.is_empty(), "it ended before the page `{title}`");
            if let Some(text) = line.strip_prefix(title).and_then(|rest| rest.strip_prefix(": ")) {
                return text.to_owned();
            }
        }
    }

    /// Waits until Enter counts on the page that is visible.
    fn wait(&mut self) {
        assert!(!wait::ends_within(&self.child, A_WHILE_S), "it goes on");
    }

    fn key(&mut self, code: u16, value: i32) {
        let time = [0; 2 * size_of::<usize>()];
        let event = [&time[..], &1_u16.to_ne_bytes(), &code.to_ne_bytes(), &value.to_ne_bytes()].concat();
        self.keyboard.write_all(&event).unwrap();
    }

    fn press(&mut self, code: u16) {
        for value in [1, 0] {
            self.key(code, value);
        }
    }
}

impl Drop for Run {
    fn drop(&mut self) {
        // It may have ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn without_enter_no_disk_is_written() {
    let computer = Computer::new();
    let before = ["nvme0n1", "sdb"].map(|name| computer.bytes(name));
    let mut run = computer.start();
    let page = run.page("Install the picture");
    assert!(
        page.contains("Samsung SSD, 209 MB (nvme0n1)") && page.contains("Everything on this disk will be lost."),
        "{page}"
    );
    // Too early, as a key that is held since the firmware's menu; then held; then others.
    run.press(ENTER);
    run.key(ENTER, 2);
    run.wait();
    run.key(ENTER, 2);
    for key in [DELETE, SPACE, TWO] {
        run.press(key);
    }
    run.wait();
    drop(run);
    assert!(["nvme0n1", "sdb"].map(|name| computer.bytes(name)) == before, "no byte has changed");
}

#[test]
fn enter_installs_the_unit_of_the_stick_and_its_removal_ends_it() {
    let computer = Computer::new();
    let stick = computer.bytes("sdb");
    let mut run = computer.start();
    run.page("Install the picture");
    run.wait();
    run.press(ENTER);
    assert!(run.page("Installing").contains("Samsung SSD, 209 MB (nvme0n1)"));
    assert!(run.page("Installed").contains("Remove the stick; the picture starts."));
    run.wait();
    let rows = computer.partitions();
    for (place, (number, _, name)) in (1..).zip(STICK) {
        let name = name.replace("dreams_install", "dreams_boot");
        let is_there = |row: &&(String, String, String, u64)| row.0 == number.to_string() && row.2 == name;
        let (_, kind, _, start) = rows.iter().find(is_there).unwrap_or_else(|| panic!("{name} in {rows:?}"));
        assert_eq!(kind == EFI_SYSTEM, ["dreams_boot", "dreams_spare"].contains(&&*name), "{name}");
        assert_eq!(start * 512, place * MIB);
        let content = content(if number == 1 { 7 } else { number });
        assert!(computer.megabyte(place) == content, "{name}");
    }
    assert_eq!(rows.len(), STICK.len());
    computer.table_is_whole();
    let disk = computer.bytes("nvme0n1");
    assert!(disk[..440] == stick[..440], "what a BIOS starts is there, too");
    let flocks = FLOCKS as usize;
    assert!([flocks, flocks + (128 << 20)].iter().all(|at| disk[*at..*at + 4_096].iter().all(|byte| *byte == 0)));
    assert!(disk[flocks + (8 << 20)..].starts_with(b"somebody's work"), "the rest is not written");
    assert!(computer.bytes("sdb") == stick, "the stick stays as it is");
    fs::remove_dir_all(computer.path("sys/block/sdb")).unwrap();
    assert!(wait::ended("the installer", 60, &mut run.child).success());
}

#[test]
fn what_an_earlier_unit_has_stays_unless_delete_is_pressed() {
    let computer = Computer::new();
    computer.install(&[]);
    let disk = computer.path("dev/nvme0n1");
    let mut append = Command::new("sfdisk")
        .args(["--quiet", "--append", "--wipe-partitions", "never"])
        .arg(&disk)
        .stdin(Stdio::piped())
        .spawn()
        .unwrap();
    append.stdin.take().unwrap().write_all(b"6 : start=14336, type=linux, name=dreams_data\n").unwrap();
    assert!(wait::ended("sfdisk", 60, &mut append).success());
    let table = computer.partitions();
    let (flocks, settings) = (b"the flocks of a year".repeat(5_000), b"unit = \"lobby\"\n".repeat(60));
    computer.overwrite("nvme0n1", FLOCKS, &flocks);
    computer.overwrite("nvme0n1", 4 * MIB, &settings);
    computer.overwrite("nvme0n1", 2 * MIB, b"an older system");

    let mut run = computer.start();
    let page = run.page("Install the picture");
    assert!(page.contains("There is a picture on this disk already. Its flocks and settings stay."), "{page}");
    run.wait();
    run.press(ENTER);
    run.page("Installed");
    drop(run);
    assert!(computer.megabyte(2) == content(2), "the new system is there");
    assert!(computer.megabyte(7).starts_with(&flocks) && computer.megabyte(4).starts_with(&settings));
    assert_eq!(computer.partitions(), table);
    computer.table_is_whole();

    computer.install(&[DELETE]);
    assert!(computer.megabyte(4) == content(4), "the settings of the image");
    assert!(computer.megabyte(7).iter().all(|byte| *byte == 0));
    assert!(computer.partitions().iter().all(|row| row.2 != "dreams_data"), "the first start makes it anew");
}

#[test]
fn one_of_several_disks_is_written_and_no_other() {
    let computer = Computer::new();
    computer.add("sda", DISK, "Other");
    computer.add("sdc", 60 * MIB, "Small");
    let before = ["nvme0n1", "sdc"].map(|name| computer.bytes(name));
    let mut run = computer.start();
    let page = run.page("Which disk?");
    assert!(page.contains("1  Samsung SSD, 209 MB (nvme0n1), 2  Other, 209 MB (sda)"), "{page}");
    assert!(!page.contains("Small"), "{page}");
    run.wait();
    // Enter does not count on the page that its number has only just brought.
    for key in [TWO, ENTER] {
        run.press(key);
    }
    assert!(run.page("Install the picture").contains("Other, 209 MB (sda)"));
    run.wait();
    assert!(computer.bytes("sda").starts_with(b"somebody's work"));
    run.press(ENTER);
    run.page("Installed");
    assert!(computer.bytes("sda")[2 * MIB as usize..].starts_with(&content(2)));
    assert!(["nvme0n1", "sdc"].map(|name| computer.bytes(name)) == before, "no other disk has changed");
}

#[test]
fn a_damaged_stick_is_noticed_before_anything_is_written() {
    let computer = Computer::new();
    let before = computer.bytes("nvme0n1");
    computer.overwrite("sdb", 3 * MIB + 77, b"!");
    let mut run = computer.start();
    run.page("Install the picture");
    run.wait();
    run.press(ENTER);
    let page = run.page("Not installed");
    assert!(page.contains("The stick is damaged. Write the image to it again, or to another one."), "{page}");
    assert!(computer.bytes("nvme0n1") == before, "no byte has changed");
}

#[test]
fn a_disk_that_cannot_be_written_or_is_too_small_is_named() {
    let computer = Computer::new();
    fs::remove_file(computer.path("dev/nvme0n1")).unwrap();
    symlink("/dev/full", computer.path("dev/nvme0n1")).unwrap();
    let mut run = computer.start();
    run.page("Install the picture");
    run.wait();
    run.press(ENTER);
    let page = run.page("Not installed");
    assert!(page.contains("The disk cannot be written.") && page.contains("Press Enter to begin again"), "{page}");
    computer.list("nvme0n1", 60 * MIB, "Samsung SSD");
    run.wait();
    run.press(ENTER);
    let page = run.page("No disk");
    assert!(page.contains("Samsung SSD, 62 MB (nvme0n1): too small, by 14 MB."), "{page}");
}

#[test]
fn a_disk_that_is_no_stick_installs_nothing() {
    let computer = Computer::new();
    computer.overwrite("sdb", 0, &[0; 8_192]);
    let mut command = Command::new(installer());
    command
        .args(["--stick", "sdb", "--screen", "virtual", "--sum", &computer.sum, "--root"])
        .arg(computer.folder.path());
    let said = output(&mut command);
    let error = String::from_utf8_lossy(&said.stderr);
    assert_eq!(said.status.code(), Some(2), "{error}");
    assert!(
        error.contains("dev/sdb` is no stick that installs") && error.contains("make image installer=yes"),
        "{error}"
    );
}

//! A unit: its disk, out of the box or after some use.
//!
//! Owns the copies of the image, the owner's files on them, damage to them, and snapshots of units that play, which are
//! resumed within a second. Never looks at the screen.
//!
//! Start at [`Unit::new`], [`Unit::start`] and [`Snapshot`].

pub(crate) mod direct_boot;
pub(crate) mod path;
pub(crate) mod stick;

use crate::machine::Machine;
use crate::machine::disk::Disk;
use crate::machine::hardware::{Hardware, USUAL};
use crate::machine::write_loss;
use claims::programs::{output, repository, succeed};
use rand_chacha::ChaCha8Rng;
use std::fs;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::process::{self, Command};
use std::sync::Once;
use tempfile::TempDir;

/// The size of a unit's disk: larger than the image, which grows to fill it.
const DISK_MIB: u64 = 1_400;

/// The partitions, as `image-build/disk.sfdisk` counts them.
pub(crate) const BOOT: u32 = 1;
pub(crate) const SLOT_A: u32 = 2;
pub(crate) const SLOT_B: u32 = 3;
const OWNER: u32 = 4;
pub(crate) const DATA: u32 = 6;
pub(crate) const SPARE: u32 = 7;

/// A unit that can be started, again and again.
pub(crate) struct Unit {
    folder: TempDir,
    disk: Disk,
    /// A disk with the same partitions, as a raw file.
    table: PathBuf,
}

/// A unit that was stopped while it ran, with its memory.
pub(crate) struct Snapshot {
    unit: Unit,
}

/// The version of the claims' image.
pub(crate) const NOW: &str = env!("CARGO_PKG_VERSION");

/// The claims' image.
pub(crate) fn image() -> PathBuf {
    let image = repository().join("target/image").join(concat!("bench-", env!("CARGO_PKG_VERSION")));
    assert!(image.is_dir(), "`{}` is missing: `make bench-image` makes it", image.display());
    image
}

/// The folder of all units, and the prefix of their folders' names.
fn folders() -> PathBuf {
    repository().join("target/image")
}
const LIFE: &str = "life-";

/// A folder for a unit, with the number of this process in its name.
fn folder() -> TempDir {
    static CLEARED: Once = Once::new();
    CLEARED.call_once(clear_folders);
    tempfile::Builder::new().prefix(&format!("{LIFE}{}-", process::id())).tempdir_in(folders()).unwrap()
}

/// Removes the units of processes that have ended: statics with snapshots are never dropped.
fn clear_folders() {
    for entry in fs::read_dir(folders()).unwrap().flatten() {
        let name = entry.file_name();
        let owner = name.to_str().and_then(|name| name.strip_prefix(LIFE)).and_then(|rest| rest.split('-').next());
        if owner.is_some_and(|owner| !Path::new("/proc").join(owner).exists()) {
            fs::remove_dir_all(entry.path()).unwrap();
        }
    }
}

/// Random bytes, the same in every run.
pub(crate) fn rubbish(length: usize) -> Vec<u8> {
    let mut bytes = vec![0; length];
    blake3::Hasher::new().update(b"rubbish").finalize_xof().fill(&mut bytes);
    bytes
}

/// A disk that is backed by `disk`, and keeps changes in `file`.
fn over(disk: &Path, file: &Path) -> Disk {
    succeed(Command::new("qemu-img").args(["create", "-q", "-f", "qcow2", "-F", "raw", "-b"]).args([disk, file]));
    Disk::new(file.to_owned(), "qcow2")
}

impl Unit {
    /// A unit out of its box.
    pub(crate) fn new() -> Self {
        Self::of_size(DISK_MIB)
    }

    /// A computer with an empty disk.
    pub(crate) fn blank() -> Self {
        let folder = folder();
        let disk = folder.path().join("disk.img");
        fs::File::create(&disk).unwrap().set_len(DISK_MIB << 20).unwrap();
        fs::copy(USUAL.firmware.variables(), folder.path().join("variables")).unwrap();
        Self { folder, table: disk.clone(), disk: Disk::new(disk, "raw") }
    }

    /// One of the image in this folder.
    pub(crate) fn of(image: &Path) -> Self {
        Self::of_image(image, DISK_MIB)
    }

    /// One with a disk of `disk_mib` MiB.
    pub(crate) fn of_size(disk_mib: u64) -> Self {
        Self::of_image(&image(), disk_mib)
    }

    fn of_image(image: &Path, disk_mib: u64) -> Self {
        let unit = Self::with(&image.join("disk.img"), USUAL.firmware.variables());
        fs::File::options().write(true).open(&unit.disk.file).unwrap().set_len(disk_mib << 20).unwrap();
        unit
    }

    /// One with copies of these files.
    fn with(disk: &Path, variables: &Path) -> Self {
        let folder = folder();
        let copy = folder.path().join("disk.img");
        succeed(Command::new("cp").arg("--sparse=always").args([disk, &copy]));
        fs::copy(variables, folder.path().join("variables")).unwrap();
        Self { folder, table: copy.clone(), disk: Disk::new(copy, "raw") }
    }

    /// A path beside its disk.
    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Where the partition `number` of its disk begins, in bytes; `None` if there is none yet.
    fn find(&self, number: u32) -> Option<u64> {
        let said = output(Command::new("sfdisk").arg("--json").arg(&self.table));
        let table: serde_json::Value = serde_json::from_slice(&said.stdout).unwrap();
        let partitions = table["partitiontable"]["partitions"].as_array().unwrap();
        let name = format!("disk.img{number}");
        let found = partitions.iter().find(|part| part["node"].as_str().unwrap().ends_with(&name));
        found.map(|part| part["start"].as_u64().unwrap() * 512)
    }

    /// Copies `file` to the owner's partition, as any computer would.
    pub(crate) fn lay_for_owner(&self, file: &Path) {
        let partition = format!("{}@@{}", self.table.display(), self.find(OWNER).unwrap());
        succeed(Command::new("mcopy").args(["-o", "-i", &partition]).arg(file).arg("::"));
    }

    /// Writes `bytes` over its partition `number`, from `at` on.
    pub(crate) fn spoil(&self, number: u32, at: u64, bytes: &[u8]) {
        let disk = fs::File::options().write(true).open(&self.disk.file).unwrap();
        disk.write_all_at(bytes, self.find(number).unwrap() + at).unwrap();
    }

    /// Writes `bytes` over a file of a boot partition, from `at` on.
    pub(crate) fn spoil_file(&self, number: u32, file: &str, at: u64, bytes: &[u8]) {
        let partition = format!("{}@@{}", self.disk.file.display(), self.find(number).unwrap());
        let (copy, there) = (self.path("spoilt"), format!("::{file}"));
        succeed(Command::new("mcopy").args(["-n", "-o", "-i", &partition, &there]).arg(&copy));
        fs::File::options().write(true).open(&copy).unwrap().write_all_at(bytes, at).unwrap();
        succeed(Command::new("mcopy").args(["-n", "-o", "-i", &partition]).arg(&copy).arg(&there));
    }

    /// Deletes the entry of a partition from the table, and leaves its content.
    pub(crate) fn lose_entry(&self, number: u32) {
        let disk = self.disk.file.to_str().unwrap();
        succeed(Command::new("sfdisk").args(["--quiet", "--delete", disk, &number.to_string()]));
    }

    /// The raw file of its disk.
    pub(crate) fn disk(&self) -> &Path {
        &self.disk.file
    }

    /// A copy of it. It must be off, with a raw disk.
    pub(crate) fn copy(&self) -> Self {
        Self::with(&self.disk.file, &self.path("variables"))
    }

    /// Starts it.
    pub(crate) fn start(&self) -> Machine {
        self.start_with(&[])
    }

    /// The same, with more options of QEMU.
    pub(crate) fn start_with(&self, more: &[String]) -> Machine {
        self.start_as(USUAL, more)
    }

    /// The same, on this hardware.
    pub(crate) fn start_as(&self, hardware: Hardware, more: &[String]) -> Machine {
        Machine::start(self.folder.path(), &self.disk, hardware, more)
    }

    /// Copies the firmware's variables of another unit.
    pub(crate) fn take_variables(&self, other: &Self) {
        fs::copy(other.path("variables"), self.path("variables")).unwrap();
    }

    /// The size of a file of a boot partition.
    pub(crate) fn size_of(&self, number: u32, file: &str) -> u64 {
        let partition = format!("{}@@{}", self.disk.file.display(), self.find(number).unwrap());
        let copy = self.path("measured");
        succeed(Command::new("mcopy").args(["-n", "-o", "-i", &partition]).arg(format!("::{file}")).arg(&copy));
        fs::metadata(copy).unwrap().len()
    }

    /// Sets the firmware's variables to this file.
    pub(crate) fn know(&self, variables: &Path) {
        fs::copy(variables, self.path("variables")).unwrap();
    }

    /// Starts it with new variables of the firmware.
    pub(crate) fn start_forgetful(&self) -> Machine {
        self.know(USUAL.firmware.variables());
        self.start()
    }

    /// Resumes it from `snapshot`, which has the same disk.
    pub(crate) fn wake(&self, snapshot: &Snapshot) -> Machine {
        Machine::wake(self.folder.path(), &self.disk, &snapshot.state())
    }

    /// Starts it, or resumes it from `snapshot`, which has the same disk. Writes are recorded, and the disk itself does
    /// not change until [`Unit::lose`].
    pub(crate) fn record(&self, snapshot: Option<&Snapshot>) -> Machine {
        let log = self.path("log");
        fs::write(&log, []).unwrap();
        let disk = Disk { log: Some(log), ..over(&self.disk.file, &self.path("record.qcow2")) };
        match snapshot {
            Some(snapshot) => Machine::wake(self.folder.path(), &disk, &snapshot.state()),
            None => Machine::start(self.folder.path(), &disk, USUAL, &[]),
        }
    }

    /// Applies to its disk what a power cut may leave of the record: see [`write_loss::cut`].
    pub(crate) fn lose(&self, random: &mut ChaCha8Rng) -> [usize; 3] {
        write_loss::cut(&self.path("log"), &self.disk.file, self.find(DATA), random)
    }

    /// Stops `machine`, which is this unit's, and keeps its state.
    pub(crate) fn freeze(self, machine: Machine) -> Snapshot {
        machine.freeze(&self.path("state"));
        Snapshot { unit: self }
    }
}

impl Snapshot {
    /// The unit as if its power had been cut at the snapshot.
    fn off(&self) -> Unit {
        let folder = folder();
        let disk = over(&self.unit.disk.file, &folder.path().join("disk.qcow2"));
        fs::copy(self.unit.path("variables"), folder.path().join("variables")).unwrap();
        Unit { folder, disk, table: self.unit.table.clone() }
    }

    /// The same, with a disk of its own.
    pub(crate) fn copy(&self) -> Unit {
        self.unit.copy()
    }

    fn state(&self) -> PathBuf {
        self.unit.path("state")
    }

    /// The unit, resumed.
    pub(crate) fn wake(&self) -> (Unit, Machine) {
        let unit = self.off();
        let machine = unit.wake(self);
        (unit, machine)
    }
}

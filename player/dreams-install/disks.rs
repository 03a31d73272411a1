//! The disks of this machine, as the kernel lists them.
//!
//! Owns the search: which of them a unit can be installed on, which is too small, and which has a unit already. Reads the
//! table of each, and nothing else of it. Never writes.
//!
//! Start at [`Machine::disks`].

use crate::plan;
use crate::table::{LENGTH, SECTOR, Table};
use rustix::fs::OFlags;
use std::fs::{self, File, OpenOptions};
use std::io;
use std::os::unix::fs::{FileExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

/// Bytes of an attribute that are read, at most.
const LONGEST: u64 = 4_096;
/// How the names of devices begin that are no disks: memory, files, disks of other disks, optical drives, tapes.
const NO_DISKS: [&str; 9] = ["dm-", "fd", "loop", "md", "nbd", "ram", "sr", "zd", "zram"];
/// How the names of parts of an eMMC end that firmware keeps for itself.
const PARTS: [&str; 4] = ["boot0", "boot1", "rpmb", "gp0"];
/// Letters of a model that are shown, at most.
const MODEL: usize = 20;

/// A machine, by where its `/sys` and `/dev` are.
#[derive(Clone, Debug)]
pub(crate) struct Machine {
    pub(crate) root: PathBuf,
    /// The kernel's name of the stick.
    pub(crate) stick: String,
}

/// A disk inside this machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Disk {
    /// The kernel's name of it.
    pub(crate) name: String,
    /// What its maker calls it; may be empty.
    pub(crate) model: String,
    pub(crate) bytes: u64,
    pub(crate) fitness: Fitness,
}

/// Whether a unit can be installed on a disk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fitness {
    /// Yes, and what is on it will be lost.
    Fits,
    /// Yes, and there is a unit whose flocks and settings can stay.
    HasUnit,
    /// Its sectors are not of 512 bytes.
    OtherSectors,
    TooSmall,
}

impl Machine {
    /// The disks that are neither the stick nor on USB, in the order of their names. What cannot be read is no disk.
    pub(crate) fn disks(&self, stick: &Table) -> Vec<Disk> {
        let entries = fs::read_dir(self.root.join("sys/block")).into_iter().flatten().flatten();
        let mut names: Vec<String> = entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
        names.sort_unstable();
        names.into_iter().filter_map(|name| self.disk(name, stick)).collect()
    }

    fn disk(&self, name: String, stick: &Table) -> Option<Disk> {
        let folder = self.root.join("sys/block").join(&name);
        let is_none = name == self.stick
            || NO_DISKS.iter().any(|kind| name.starts_with(kind))
            || PARTS.iter().any(|part| name.ends_with(part));
        let is_outside = fs::canonicalize(&folder).ok()?.to_string_lossy().contains("/usb");
        let number = |file: &str| attribute(&folder.join(file))?.parse::<u64>().ok();
        let bytes = number("size")?.checked_mul(SECTOR)?;
        if is_none || is_outside || bytes == 0 || number("ro") != Some(0) || number("removable") == Some(1) {
            return None;
        }
        let model = ["device/model", "device/name"].iter().find_map(|file| attribute(&folder.join(file)));
        let model: String = model.unwrap_or_default().chars().filter(|c| matches!(c, ' '..='~')).take(MODEL).collect();
        let model = model.trim_end().to_owned();
        let fitness = if number("queue/logical_block_size").is_some_and(|size| size != SECTOR) {
            Fitness::OtherSectors
        } else if plan::needed(stick).is_none_or(|needed| bytes < needed) {
            Fitness::TooSmall
        } else if self.table(&name).is_ok_and(|table| table.is_some_and(|table| plan::has_unit(&table, stick))) {
            Fitness::HasUnit
        } else {
            Fitness::Fits
        };
        Some(Disk { name, model, bytes, fitness })
    }

    /// The table of the device `name`; `None` if it has none that is whole.
    pub(crate) fn table(&self, name: &str) -> io::Result<Option<Table>> {
        let mut bytes = vec![0; LENGTH];
        File::open(self.device(name))?.read_exact_at(&mut bytes, 0)?;
        Ok(Table::parse(&bytes))
    }

    /// The disk of this name, to be written by nobody else: the kernel refuses one that is mounted.
    pub(crate) fn open(&self, name: &str) -> io::Result<File> {
        let flags = OFlags::EXCL.bits().cast_signed();
        OpenOptions::new().read(true).write(true).custom_flags(flags).open(self.device(name))
    }

    pub(crate) fn device(&self, name: &str) -> PathBuf {
        self.root.join("dev").join(name)
    }

    /// Whether the stick is plugged in.
    pub(crate) fn has_stick(&self) -> bool {
        self.root.join("sys/block").join(&self.stick).exists()
    }
}

/// The text of an attribute of the kernel, without blanks around it.
fn attribute(path: &Path) -> Option<String> {
    let bytes = durable::read_plain(path, LONGEST).ok()?;
    Some(String::from_utf8_lossy(&bytes).trim().to_owned())
}

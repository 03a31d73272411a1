//! Which disk is a unit's own, where several have partitions of the same names.
//!
//! Owns the claim on `own-disk`, tried on folders that stand for the `/sys` of machines, and that the udev rules call
//! it. A unit beside a copy of its own disk is tried on a whole machine, in `image/starts/usb_disk.rs`.

use claims::programs::{self, output, repository};
use std::fs;
use std::os::unix::fs::symlink;
use std::path::PathBuf;
use std::process::Command;
use tempfile::TempDir;

/// A disk in the machine, one on USB, and a third whose name begins with the first one's.
const WITHIN: &str = "pci0000:00/0000:00:1f.2/ata1/host0/target0:0:0/0:0:0:0/block/sda";
const ON_USB: &str = "pci0000:00/0000:00:14.0/usb2/2-1/2-1:1.0/host6/target6:0:0/6:0:0:0/block/sdb";
const BESIDE: &str = "pci0000:00/0000:00:1f.2/ata1/host0/target0:0:0/0:0:0:0/block/sdaa";
/// Devices on top of others: the verified root, and an encrypted disk.
const VERIFIED: &str = "virtual/block/dm-0";
const ENCRYPTED: &str = "virtual/block/dm-1";
/// The device number of a root that is no block device.
const IN_MEMORY: &str = "0:25";

/// The disks of a machine in `/sys`.
struct Machine {
    root: TempDir,
}

impl Machine {
    /// One with three disks of five partitions each, and its root on the device with this `number`.
    fn started_from(number: &str) -> Self {
        let machine = Self { root: tempfile::tempdir().unwrap() };
        for (major, disk) in [(8, WITHIN), (9, ON_USB), (10, BESIDE)] {
            machine.has(disk, &format!("{major}:0"));
            for part in 1..=5 {
                let path = partition(disk, part);
                machine.has(&path, &format!("{major}:{part}"));
                fs::write(machine.devices().join(path).join("partition"), format!("{part}\n")).unwrap();
            }
        }
        let (bin, words) = (machine.root.path().join("bin"), format!("#!/bin/sh\necho {number}\n"));
        fs::create_dir(&bin).unwrap();
        programs::write_script(&bin.join("mountpoint"), &words);
        machine
    }

    fn devices(&self) -> PathBuf {
        self.root.path().join("sys/devices")
    }

    fn has(&self, path: &str, number: &str) {
        let (device, sys) = (self.devices().join(path), self.root.path().join("sys"));
        fs::create_dir_all(&device).unwrap();
        for (folder, name) in [("class/block", path.rsplit('/').next().unwrap()), ("dev/block", number)] {
            fs::create_dir_all(sys.join(folder)).unwrap();
            symlink(&device, sys.join(folder).join(name)).unwrap();
        }
    }

    /// Puts the device `path`, with this `number`, on top of the device `below`.
    fn lays(self, path: &str, number: &str, below: &str) -> Self {
        self.has(path, number);
        let slaves = self.devices().join(path).join("slaves");
        fs::create_dir(&slaves).unwrap();
        symlink(self.devices().join(below), slaves.join(below.rsplit('/').next().unwrap())).unwrap();
        self
    }

    /// The devices that count as parts of the unit's own disk.
    fn own(&self) -> Vec<&'static str> {
        let path = format!("{}:{}", self.root.path().join("bin").display(), std::env::var("PATH").unwrap());
        let is_own = |name: &&str| {
            let mut command = Command::new(repository().join("systemd/own-disk"));
            let said = output(command.arg(name).arg(self.root.path()).env("PATH", &path));
            assert!(said.stderr.is_empty(), "{}", String::from_utf8_lossy(&said.stderr));
            said.status.success()
        };
        ["sda", "sda5", "sdb", "sdb5", "sdaa", "sdaa5"].into_iter().filter(is_own).collect()
    }
}

fn partition(disk: &str, number: u32) -> String {
    format!("{disk}/{}{number}", disk.rsplit('/').next().unwrap())
}

#[test]
fn a_partition_is_a_units_own_only_on_the_disk_that_it_runs_from() {
    let (within, on_usb) = (["sda", "sda5"], ["sdb", "sdb5"]);
    let verified = |below: &str| Machine::started_from("254:0").lays(VERIFIED, "254:0", below);
    assert_eq!(verified(&partition(WITHIN, 2)).own(), within);
    assert_eq!(verified(&partition(ON_USB, 3)).own(), on_usb, "the disk within is somebody else's");
    let both = verified(ENCRYPTED).lays(ENCRYPTED, "254:1", &partition(ON_USB, 1));
    assert_eq!(both.own(), on_usb);
    assert_eq!(Machine::started_from("8:1").own(), within, "a root without verity");
    // Where the root tells no disk, a removable disk is not the unit's own.
    assert_eq!(Machine::started_from(IN_MEMORY).own(), ["sda", "sda5", "sdaa", "sdaa5"]);
    // The root was taken from another disk.
    let elsewhere = verified(&partition(WITHIN, 2));
    fs::create_dir(elsewhere.root.path().join("run")).unwrap();
    fs::write(elsewhere.root.path().join("run/dreams-elsewhere"), "").unwrap();
    assert_eq!(elsewhere.own(), [""; 0]);
}

#[test]
fn an_owners_partition_is_taken_from_the_units_own_disk_and_a_stick_is_another() {
    let rules = |name: &str| fs::read_to_string(repository().join("systemd").join(name)).unwrap();
    for (name, asks, service) in [
        ("80-dreams-owner.rules", "PROGRAM==\"/usr/lib/dreams/own-disk %k\", ", "dreams-owner@%k.service"),
        ("80-dreams-update.rules", "PROGRAM!=\"/usr/lib/dreams/own-disk %k\", ", "dreams-update@%k.service"),
    ] {
        let text = rules(name);
        let starts: Vec<&str> = text.lines().filter(|line| line.contains(service)).collect();
        assert!(matches!(starts[..], [line] if line.contains(asks)), "`{name}` starts `{service}` so: {starts:?}");
    }
}

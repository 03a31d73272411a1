//! The partition of the flocks is not made anew if it can be mounted or repaired.
//!
//! Owns the cases in which it seems lost: a kernel without ext4, a missing entry in the partition table, a sound file
//! system that cannot be mounted. Damage to the partition itself is in `flocks_disk.rs`.

use crate::machine::picture::only_art;
use crate::machine::{Machine, PAUSE};
use crate::starts::first_start::{MOVES, OFTEN, PlayingUnit, playing_unit};
use crate::unit::direct_boot::parts;
use crate::unit::path::Path;
use crate::unit::{DATA, Unit};
use claims::programs::{repository, succeed};
use std::fs;
use std::process::Command;

/// The owner's settings that the unit has applied.
const KEPT: &str = "cat /var/lib/dreams/owner/dreams.toml";

/// Starts it until it shows its picture; with `path`, the walk continues where it was.
fn shows_its_art(machine: &mut Machine, path: Option<&mut Path>) {
    let mut looks = machine.await_shell();
    looks.extend(machine.watch_move(PAUSE, MOVES));
    only_art(&looks, OFTEN);
    assert!(path.is_none_or(|path| path.came_back_with(&looks)), "the path goes on");
}

/// Waits until the log has these words. The log moves to the partition of the flocks after the first picture.
fn is_told(machine: &mut Machine, words: &str) {
    machine.watch_while(PAUSE, &format!("until journalctl --boot --output=cat | grep -q '{words}'; do sleep 1; done"));
}

#[test]
fn a_system_that_cannot_read_the_flocks_leaves_them_as_they_are() {
    let PlayingUnit { snapshot, path, .. } = playing_unit();
    let mut path = path.clone();
    let unit = snapshot.copy();
    let folder = tempfile::tempdir_in(repository().join("target/image")).unwrap();
    let mut words = parts(folder.path());
    words.last_mut().expect("the kernel's command line").push_str(" module_blacklist=ext4");
    let mut machine = unit.start_with(&words);
    shows_its_art(&mut machine, None);
    assert_ne!(machine.serial.run("mountpoint --quiet /var/lib/dreams").1, 0);
    is_told(&mut machine, "stays as it is");
    drop(machine);
    let mut machine = unit.start();
    shows_its_art(&mut machine, Some(&mut path));
    machine.run(KEPT);
}

#[test]
fn a_disk_of_the_flocks_that_is_lost_from_the_table_is_found_again() {
    let PlayingUnit { snapshot, path, .. } = playing_unit();
    let mut path = path.clone();
    let unit = snapshot.copy();
    unit.lose_entry(DATA);
    let mut machine = unit.start();
    shows_its_art(&mut machine, Some(&mut path));
    machine.run(KEPT);
    is_told(&mut machine, "is found again");
    machine.is_well();
    drop(machine);
    let mut machine = unit.start();
    shows_its_art(&mut machine, Some(&mut path));
    assert_ne!(machine.serial.run("journalctl --boot --output=cat | grep -q 'is found again'").1, 0, "once is enough");
}

#[test]
fn a_disk_of_the_flocks_that_is_well_and_cannot_be_mounted_is_left_as_it_is() {
    let PlayingUnit { snapshot, .. } = playing_unit();
    let unit: Unit = snapshot.copy();
    // Blocks larger than this kernel can mount, and than `e2fsck` minds.
    let (large, folder) = (unit.path("large.img"), unit.path("large"));
    fs::create_dir(&folder).unwrap();
    fs::write(folder.join("flock"), "somebody's work").unwrap();
    let mut make = Command::new("mke2fs");
    make.args(["-q", "-F", "-t", "ext4", "-b", "65536", "-L", "dreams", "-E", "nodiscard", "-d"]);
    succeed(make.args([&folder, &large]).arg("300M"));
    unit.spoil(DATA, 0, &fs::read(&large).unwrap());
    let mut machine = unit.start();
    shows_its_art(&mut machine, None);
    is_told(&mut machine, "is well, and can.t be mounted");
    machine.run("grep -q \"somebody's work\" /dev/vda6");
}

//! A unit whose own disk is on USB, beside another disk with the same partition names.
//!
//! Owns the claim that it uses its own partitions, whichever disk is found first.

use crate::machine::PAUSE;
use crate::machine::hardware::{Bus, Hardware, USUAL};
use crate::machine::picture::only_art;
use crate::starts::first_start::{MOVES, OFTEN, PROVEN, PlayingUnit, playing_unit};
use crate::unit::{SLOT_A, SLOT_B, Unit, rubbish};
use std::fs;

/// For the unit's shell: the disk of the root, and of the flocks.
const OF_ROOT: &str = "basename $(readlink -f /sys/class/block/dm-0/slaves/*/..)";
const OF_FLOCKS: &str = "findmnt --noheadings --output SOURCE /var/lib/dreams | sed 's|/dev/||; s/[0-9]*$//'";

#[test]
fn a_unit_on_usb_knows_its_own_disk_from_a_copy_of_the_image_on_a_stick() {
    let PlayingUnit { snapshot, path, .. } = playing_unit();
    let mut path = path.clone();
    let unit = snapshot.copy();
    let stick = Unit::new();
    // The stick's settings have another name for the unit.
    let theirs = stick.path("dreams.toml");
    fs::write(&theirs, "unit = \"nobody\"\n").unwrap();
    stick.lay_for_owner(&theirs);
    let hardware = Hardware { bus: Bus::UsbStorage, ..USUAL };
    let other = format!("file={},if=none,id=other,format=raw", stick.disk().display());
    let device = |port: u32| format!("usb-storage,bus=xhci.0,drive=other,port={port}");
    for port in [1, 3] {
        let words = ["-drive", &other, "-device", &device(port)].map(str::to_owned);
        let mut machine = unit.start_as(hardware, &words);
        let mut looks = machine.await_shell();
        looks.extend(machine.watch_move(PAUSE, MOVES));
        looks.extend(machine.watch_while(PAUSE, PROVEN));
        looks.extend(machine.watch_while(PAUSE, "udevadm settle -t 240"));
        only_art(&looks, OFTEN);
        assert!(path.came_back_with(&looks), "the path goes on");
        let (root, flocks) = (machine.run(OF_ROOT), machine.run(OF_FLOCKS));
        assert_eq!(root, flocks);
        machine.run("! grep -q nobody /var/lib/dreams/owner/dreams.toml");
        // No update runs for its own partitions; one may run for the other disk's.
        machine.run(&format!("! systemctl list-units --all --plain --no-legend 'dreams-update@{root}*' | grep ."));
        machine.run("systemctl list-units --all --plain --no-legend 'dreams-update@sd*' 'dreams-owner@*'");
        machine.is_well();
    }
}

#[test]
fn a_root_that_has_to_be_taken_from_another_disk_brings_neither_its_flocks_nor_its_owners_settings() {
    let PlayingUnit { snapshot, .. } = playing_unit();
    let unit = snapshot.copy();
    for slot in [SLOT_A, SLOT_B] {
        unit.spoil(slot, 0, &rubbish(1 << 20));
    }
    let stick = snapshot.copy();
    let theirs = stick.path("dreams.toml");
    fs::write(&theirs, "unit = \"nobody\"\n").unwrap();
    stick.lay_for_owner(&theirs);
    let other = format!("file={},if=none,id=other,format=raw", stick.disk().display());
    let words = ["-drive", &other, "-device", "usb-storage,bus=xhci.0,drive=other,port=1"].map(str::to_owned);
    let mut machine = unit.start_with(&words);
    let mut looks = machine.await_shell();
    looks.extend(machine.watch_move(PAUSE, MOVES));
    looks.extend(machine.watch_while(PAUSE, PROVEN));
    only_art(&looks, OFTEN);
    assert!(machine.run(OF_ROOT).trim().starts_with("sd"), "the root is the stick's");
    machine.run("udevadm settle -t 240");
    machine.run("[ -e /run/dreams-elsewhere ]");
    assert_eq!(
        machine.run("findmnt --noheadings --output SOURCE,FSTYPE /var/lib/dreams; true"),
        "",
        "no disk of flocks"
    );
    machine.run("! grep -qs nobody /var/lib/dreams/owner/dreams.toml /proc/sys/kernel/hostname");
}

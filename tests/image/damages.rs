//! Each thing that a unit starts from, damaged in each way: see `redundant.rs`, which has the cheapest of these claims.

use crate::redundant::{FAT, KIB, is_whole_again, shows_its_art, slot};
use crate::system::{Coming, NOW, coming, kept, version};
use crate::unit::{BOOT, SLOT_A, SLOT_B, SPARE, Unit, image, rubbish};
use std::fs;

const START: &str = concat!("EFI/Linux/dreams_", env!("CARGO_PKG_VERSION"), ".efi");

#[test]
fn a_unit_whose_first_boot_partition_and_first_slot_are_damaged_mends_both() {
    let unit = Unit::new();
    unit.spoil(BOOT, FAT, &vec![0; 64 * KIB]);
    unit.spoil(SLOT_A, 0, &rubbish(1024 * KIB));
    let mut machine = shows_its_art(&unit);
    assert_eq!(slot(&mut machine), 3, "the second slot runs");
    is_whole_again(&mut machine);
    drop(machine);
    let mut machine = shows_its_art(&unit);
    assert_eq!(slot(&mut machine), 2, "the first one is whole again");
}

#[test]
fn four_kib_of_a_start_file_damaged_anywhere_cost_nothing() {
    let size = fs::metadata(image().join("dreams.efi")).unwrap().len();
    // Its head, the kernel, the initramfs and the command line at its end.
    for at in [0, size / 3, size - 1_500_000, size - 4_096] {
        let unit = Unit::new();
        unit.spoil_file(BOOT, START, at, &rubbish(4 * KIB));
        let mut machine = shows_its_art(&unit);
        machine.run("until systemctl show -P ActiveState dreams-mend@boot | grep -q inactive; do sleep 1; done");
        drop(machine);
        // Then the other one, when the first is whole again.
        unit.spoil_file(SPARE, START, at, &rubbish(4 * KIB));
        shows_its_art(&unit);
    }
}

#[test]
fn a_new_system_whose_start_file_is_damaged_is_left_and_the_one_before_goes_on() {
    let Coming { written, kept: before, .. } = coming();
    let unit = written.copy();
    unit.spoil_file(BOOT, "EFI/Linux/dreams_9.0.0+3.efi", 5_000_000, &rubbish(4 * KIB));
    let mut machine = unit.start_forgetful();
    machine.hang(crate::starting::playing().stick.gallery);
    machine.await_word("BENCH");
    assert_eq!(version(&mut machine), NOW);
    machine.run(crate::starting::PROVEN);
    assert_eq!(&kept(&mut machine), before);
}

#[test]
fn a_boot_loader_that_is_damaged_or_gone_costs_nothing() {
    for file in ["EFI/BOOT/BOOTX64.EFI", "EFI/systemd/systemd-bootx64.efi"] {
        let unit = Unit::new();
        unit.spoil_file(BOOT, file, 0, &rubbish(4 * KIB));
        let mut machine = shows_its_art(&unit);
        machine.run("until journalctl --output=cat --unit=dreams-mend@boot | grep -q 'is mended'; do sleep 1; done");
        machine.is_well();
    }
}

#[test]
fn a_start_file_and_the_other_boot_partition_damaged_at_once_still_end_in_art() {
    let unit = Unit::new();
    unit.spoil_file(BOOT, "EFI/systemd/systemd-bootx64.efi", 1_000, &rubbish(4 * KIB));
    unit.spoil_file(SPARE, START, 9_000, &rubbish(4 * KIB));
    shows_its_art(&unit).is_well();
}

#[test]
fn a_slot_damaged_where_a_start_meets_it_late_gives_way_to_the_other_slot() {
    for (damaged, other) in [(SLOT_A, SLOT_B), (SLOT_B, SLOT_A)] {
        let unit = Unit::new();
        unit.spoil(damaged, 40 << 20, &rubbish(60 << 20));
        let mut machine = shows_its_art(&unit);
        assert_eq!(slot(&mut machine), other);
        if damaged == SLOT_A {
            is_whole_again(&mut machine);
        }
    }
}

#[test]
fn a_spare_boot_partition_that_is_lost_is_made_anew() {
    let unit = Unit::new();
    unit.spoil(SPARE, 0, &rubbish(1 << 20));
    unit.spoil(SPARE, FAT, &vec![0; 64 * KIB]);
    let mut machine = shows_its_art(&unit);
    machine.run("until journalctl --output=cat --unit=dreams-mend@boot | grep -q 'spare copy'; do sleep 1; done");
    machine.is_well();
}

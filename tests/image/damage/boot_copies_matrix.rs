//! Damage in each part that a unit starts from, in each way. `boot_copies.rs` has the fastest of these claims.

use crate::damage::boot_copies::{FAT, KIB, LOOKED, is_whole_again, shows_its_art, slot};
use crate::machine::{Machine, PAUSE};
use crate::unit::{BOOT, NOW, SLOT_A, SLOT_B, SPARE, Unit, rubbish};
use crate::updates::next_system::{UpdatingUnit, kept, updating_unit, version};
use std::sync::LazyLock;

/// A file that an entry starts, and the entry; the second copy is started first.
fn part(copy: u8, name: &str) -> String {
    format!("EFI/dreams/{NOW}_{copy}/{name}")
}

fn entry(copy: u8) -> String {
    format!("loader/entries/dreams_{NOW}_{copy}+1.conf")
}

/// Waits for the end of this start's check, which has repaired what the boot loader starts.
fn mends_what_is_started(machine: &mut Machine) {
    machine.watch_while(PAUSE, LOOKED);
    machine.run("journalctl --boot --output=cat --identifier=dreams-mend | grep 'repaired a damaged'");
}

/// A unit that was started once: it knows that Secure Boot is off.
fn started() -> &'static Unit {
    static STARTED: LazyLock<Unit> = LazyLock::new(|| {
        let unit = Unit::new();
        shows_its_art(&unit).run("sync");
        unit
    });
    &STARTED
}

#[test]
fn a_unit_whose_first_boot_partition_and_first_slot_are_damaged_mends_both() {
    let unit = Unit::new();
    unit.spoil(BOOT, FAT, &vec![0; 64 * KIB]);
    unit.spoil(SLOT_A, 0, &rubbish(1024 * KIB));
    let mut machine = shows_its_art(&unit);
    assert_eq!(slot(&mut machine), 3, "the second slot runs");
    machine.watch_while(PAUSE, LOOKED);
    drop(machine);
    let mut machine = shows_its_art(&unit);
    assert_eq!(slot(&mut machine), 2, "the first one is whole again");
    // What `init` could not repair at the first start is repaired at this one.
    is_whole_again(&mut machine);
}

#[test]
fn four_kib_damaged_in_anything_that_is_started_cost_nothing() {
    // The head of the kernel, its inside, the initramfs, the entry.
    for (file, at) in
        [(part(2, "linux"), 0), (part(2, "linux"), 6_000_000), (part(2, "initramfs"), 1_000_000), (entry(2), 0)]
    {
        let unit = started().copy();
        unit.spoil_file(BOOT, &file, at, &rubbish(4 * KIB));
        let mut machine = shows_its_art(&unit);
        mends_what_is_started(&mut machine);
        machine.is_well();
    }
}

#[test]
fn both_copies_on_a_boot_partition_damaged_cost_nothing() {
    let unit = started().copy();
    for copy in [1, 2] {
        unit.spoil_file(BOOT, &part(copy, "linux"), 6_000_000, &rubbish(4 * KIB));
    }
    let mut machine = shows_its_art(&unit);
    mends_what_is_started(&mut machine);
}

#[test]
fn a_new_system_whose_kernel_is_damaged_is_left_and_the_one_before_goes_on() {
    let UpdatingUnit { written, kept: before, .. } = updating_unit();
    let unit = written.copy();
    unit.spoil_file(BOOT, "EFI/dreams/9.0.0_1/linux", 5_000_000, &rubbish(4 * KIB));
    let mut machine = unit.start_forgetful();
    machine.also_expect(crate::starts::first_start::playing_unit().stick.reference);
    machine.await_word("BENCH");
    assert_eq!(version(&mut machine), NOW);
    machine.run(crate::starts::first_start::PROVEN);
    assert_eq!(&kept(&mut machine), before);
}

#[test]
fn a_first_program_that_is_damaged_costs_nothing() {
    let unit = Unit::new();
    unit.spoil_file(BOOT, "EFI/BOOT/BOOTX64.EFI", 0, &rubbish(4 * KIB));
    let mut machine = shows_its_art(&unit);
    mends_what_is_started(&mut machine);
    machine.is_well();
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
    machine
        .run("until journalctl --output=cat --identifier=dreams-mend | grep -q 'has another copy'; do sleep 1; done");
    machine.is_well();
}

//! Machines with Secure Boot.
//!
//! Owns the claims on a unit out of its box under Microsoft's keys, on one that is signed with a key of its own, and on
//! changed files, which neither starts.

use crate::machine::hardware::{Firmware, Hardware, USUAL};
use crate::machine::picture::only_art;
use crate::machine::{Machine, PAUSE, light_flock};
use crate::starts::first_start::{MOVES, OFTEN, PROVEN};
use crate::starts::hardware_sample::IS_SECURE;
use crate::unit::{BOOT, NOW, SPARE, Unit};
use claims::programs::{repository, succeed};
use std::process::Command;
use std::sync::LazyLock;

const SECURE: Hardware = Hardware { firmware: Firmware::Secure, ..USUAL };
/// For the unit's shell: the boot loader entry that was started.
const ENTRY: &str =
    "tr -d '\\0' < /sys/firmware/efi/efivars/LoaderEntrySelected-4a67b082-0a4c-41cf-b6c7-440b29bb8c4f | cut -c 2-";

/// The kernel of a copy, in which a byte is changed.
fn kernel(copy: u8) -> String {
    format!("EFI/dreams/{NOW}_{copy}/linux")
}

/// Starts `unit` with Secure Boot until it shows its picture.
fn shows_its_art(unit: &Unit) -> Machine {
    let mut machine = unit.start_as(SECURE, &[]);
    let mut looks = machine.await_shell();
    looks.extend(machine.watch_move(PAUSE, MOVES));
    looks.extend(machine.watch_while(PAUSE, PROVEN));
    only_art(&looks, OFTEN);
    machine.run(IS_SECURE);
    machine
}

/// A unit that is signed with a key of its own, which its firmware has taken; it has shown its picture.
fn signed() -> &'static Unit {
    static SIGNED: LazyLock<Unit> = LazyLock::new(|| {
        let target = repository().join("target/image");
        let keys = tempfile::tempdir_in(&target).unwrap();
        let keys = keys.path().join("keys");
        succeed(Command::new(repository().join("image-build/keys")).arg(&keys));
        let mut build = Command::new(repository().join("image-build/build"));
        succeed(build.arg(&target).args(["--profile", "bench", "--sign"]).arg(&keys).arg("--flock").arg(light_flock()));
        let unit = Unit::of(&target.join(concat!("bench-", env!("CARGO_PKG_VERSION"), "-signed")));
        // In setup mode: it has no keys, and accepts new ones.
        unit.know(USUAL.firmware.variables());
        shows_its_art(&unit).run("sync");
        unit
    });
    &SIGNED
}

#[test]
fn a_unit_out_of_its_box_shows_its_art_under_microsofts_keys() {
    let unit = Unit::new();
    unit.know(SECURE.firmware.variables());
    shows_its_art(&unit).is_well();
}

#[test]
fn a_kernel_that_was_changed_is_refused_and_the_other_copy_started_and_the_first_is_mended() {
    let unit = Unit::new();
    unit.know(SECURE.firmware.variables());
    unit.spoil_file(BOOT, &kernel(2), 6_000_000, b"!");
    let mut machine = unit.start_as(SECURE, &[]);
    machine.await_word("Security violation");
    let mut looks = machine.await_shell();
    assert_eq!(machine.run(ENTRY).trim(), format!("dreams_{NOW}_1.conf"));
    looks.extend(machine.watch_while(PAUSE, PROVEN));
    only_art(&looks, OFTEN);
    machine.run(
        "until journalctl --boot --output=cat --identifier=dreams-mend | grep -q 'repaired a damaged'; do sleep 1; done; sync",
    );
    drop(machine);
    let mut machine = shows_its_art(&unit);
    assert_eq!(machine.run(ENTRY).trim(), format!("dreams_{NOW}_2.conf"), "it is whole again");
}

#[test]
fn a_unit_signed_with_a_key_of_its_own_gives_the_key_to_its_firmware_and_shows_its_art() {
    shows_its_art(signed()).is_well();
}

#[test]
fn what_was_changed_in_a_signed_unit_is_refused_the_initramfs_and_the_command_line_included() {
    // The initramfs is the last of what the signature covers.
    for from_the_end in [6_000_000, 1_000_000] {
        let unit = signed().copy();
        let size = unit.size_of(BOOT, &kernel(2));
        unit.spoil_file(BOOT, &kernel(2), size - from_the_end, b"!");
        let mut machine = unit.start_as(SECURE, &[]);
        machine.await_word("Error loading");
        machine.await_word("BENCH");
        assert_eq!(machine.run(ENTRY).trim(), format!("dreams_{NOW}_1.conf"));
    }
}

#[test]
fn a_firmware_with_a_key_of_its_own_starts_nothing_that_debian_has_signed() {
    let unit = Unit::new();
    unit.take_variables(signed());
    let mut machine = unit.start_as(SECURE, &[]);
    machine.await_word("Access Denied");
    assert!(unit.size_of(SPARE, "EFI/BOOT/BOOTX64.EFI") > 0, "the other partition has it, too");
    // The firmware's own shell is refused, too.
    machine.await_word("No bootable option or device was found");
}

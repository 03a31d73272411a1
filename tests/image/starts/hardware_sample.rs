//! A unit on other hardware: buses, displays, memory.
//!
//! Owns the claim that it shows its picture, and the machine for `make check-all`. QEMU 7.2 cannot emulate eMMC, UFS and
//! Intel's VMD.

use crate::machine::hardware::{Bus, Display, Firmware, Hardware, USUAL};
use crate::machine::picture::only_art;
use crate::machine::{Machine, PAUSE};
use crate::starts::first_start::{MOVES, OFTEN};
use crate::unit::Unit;
use crate::unit::direct_boot::parts;
use claims::programs::repository;

/// For the unit's shell: firmware and kernel say that Secure Boot is on, and no module was refused.
pub(crate) const IS_SECURE: &str = "od -An -j4 -tu1 /sys/firmware/efi/efivars/SecureBoot-* | grep -qw 1 && \
                                    grep -qF '[integrity]' /sys/kernel/security/lockdown && \
                                    ! dmesg | grep -E 'Lockdown: (systemd-)?modprobe|module verification failed'";

/// Starts a unit out of its box on this hardware; it shows its picture.
pub(crate) fn shows_its_art(hardware: Hardware) {
    let unit = hardware.bus.disk_mib().map_or_else(Unit::new, Unit::of_size);
    unit.know(hardware.firmware.variables());
    let folder = tempfile::tempdir_in(repository().join("target/image")).unwrap();
    // What the firmware can't read, QEMU starts in its place.
    let words = if hardware.bus.is_read_by_firmware() { Vec::new() } else { parts(folder.path()) };
    let mut machine: Machine = unit.start_as(hardware, &words);
    let mut looks = machine.await_shell();
    looks.extend(machine.watch_move(PAUSE, MOVES));
    only_art(&looks, OFTEN);
    let disk = machine.run("basename $(readlink -f /sys/class/block/dm-0/slaves/*/..)");
    assert!(hardware.bus.is_called(&disk), "it runs from {disk} on {hardware:?}");
    if hardware.firmware == Firmware::Secure {
        machine.run(IS_SECURE);
    }
    machine.is_well();
}

#[test]
fn a_unit_on_nvme_and_a_bochs_display_shows_its_art_with_secure_boot_on() {
    shows_its_art(Hardware { bus: Bus::Nvme, display: Display::Bochs, firmware: Firmware::Secure, ..USUAL });
}

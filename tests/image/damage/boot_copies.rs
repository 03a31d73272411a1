//! Every part that a unit starts from exists twice.
//!
//! Owns the claims that a unit shows its picture at the very start at which a part is damaged, and that the part is
//! repaired afterwards. The firmware's variables are reset before each start. The details of `dreams-mend` are in
//! `tests/it/unit/boot_repair.rs`.

use crate::machine::picture::only_art;
use crate::machine::{Machine, PAUSE};
use crate::starts::first_start::{MOVES, OFTEN, PROVEN};
use crate::unit::{BOOT, SLOT_A, Unit, rubbish};

pub(crate) const KIB: usize = 1024;
/// Where the first FAT of a boot partition begins, after its reserved sectors.
pub(crate) const FAT: u64 = 32 * 512;
/// For the unit's shell: waits for the end of this start's check of the parts.
pub(crate) const LOOKED: &str = "until journalctl --boot --output=cat --unit=dreams-mend@boot --unit=dreams-mend@all | grep '^Finished'; do sleep 1; done";
/// For the unit's shell: both slots are equal, and so are both boot partitions.
const IS_WHOLE: &str = "cmp -n 140000000 /dev/vda2 /dev/vda3 && mkdir -p /run/one /run/two && mount -o ro /dev/vda1 /run/one && \
                        mount -o ro /dev/vda7 /run/two && diff -r /run/one /run/two && umount /run/one /run/two";

/// Starts it until it shows its picture and has proved its system good.
pub(crate) fn shows_its_art(unit: &Unit) -> Machine {
    let mut machine = unit.start_forgetful();
    let mut looks = machine.await_shell();
    looks.extend(machine.watch_move(PAUSE, MOVES));
    // This machine is slower than any unit: with the usual weight the player would use all of it.
    machine.run("systemctl set-property --runtime dreams.slice CPUWeight=20");
    looks.extend(machine.watch_while(PAUSE, PROVEN));
    only_art(&looks, OFTEN);
    machine
}

/// The number of the partition that the root is read from.
pub(crate) fn slot(machine: &mut Machine) -> u32 {
    machine.run("cat /sys/class/block/dm-0/slaves/*/partition").trim().parse().unwrap()
}

/// Waits until everything was checked, and is whole.
pub(crate) fn is_whole_again(machine: &mut Machine) {
    machine.watch_while(PAUSE, LOOKED);
    machine.run(IS_WHOLE);
    machine.is_well();
}

#[test]
fn a_unit_whose_first_boot_partition_and_first_slot_are_damaged_shows_its_art() {
    let unit = Unit::new();
    unit.spoil(BOOT, FAT, &vec![0; 64 * KIB]);
    unit.spoil(SLOT_A, 0, &rubbish(1024 * KIB));
    let mut machine = unit.start_forgetful();
    let mut looks = machine.await_shell();
    looks.extend(machine.watch_move(PAUSE, MOVES));
    only_art(&looks, OFTEN);
    assert_eq!(slot(&mut machine), 3, "the second slot runs");
}

//! The partition of the flocks is damaged, and is repaired or made anew.
//!
//! Owns the damage, done while the machine is off, and what must be there after the next start without any help.

use crate::machine::picture::{Look, only_art};
use crate::machine::{Machine, PAUSE};
use crate::starts::first_start::{MOVES, OFTEN, PROVEN, PlayingUnit, playing_unit};
use crate::unit::{DATA, Unit, rubbish};

const MIB: usize = 1 << 20;
/// The owner's settings that the unit has applied.
const KEPT: &str = "/var/lib/dreams/owner/dreams.toml";

/// Starts it until it shows its picture, with a writable partition of the flocks.
fn heals(unit: &Unit) -> (Machine, Vec<Look>) {
    let mut machine = unit.start();
    let mut looks = machine.await_shell();
    looks.extend(machine.watch_move(PAUSE, MOVES));
    only_art(&looks, OFTEN);
    // The art does not wait for this disk, and to make one anew takes a while.
    let mounted = "until mountpoint --quiet /var/lib/dreams; do sleep 1; done";
    let mount = machine.run(&format!("{mounted}; findmnt --noheadings --output FSTYPE,OPTIONS /var/lib/dreams"));
    assert!(mount.starts_with("ext4") && mount.contains("rw,"), "{mount}");
    machine.run("touch /var/lib/dreams/written && sync && [ -d /var/lib/dreams/state ]");
    machine.is_well();
    (machine, looks)
}

#[test]
fn a_disk_of_the_flocks_that_lost_its_superblock_keeps_all_else() {
    let PlayingUnit { snapshot, path, .. } = playing_unit();
    let unit = snapshot.copy();
    unit.spoil(DATA, 0, &rubbish(4096));
    let (mut machine, looks) = heals(&unit);
    assert!(path.clone().came_back_with(&looks), "the path goes on");
    machine.run(&format!("[ -s {KEPT} ]"));
}

#[test]
fn a_disk_of_the_flocks_that_lost_its_folders_or_nearly_all_heals() {
    for lost in [MIB, 300 * MIB] {
        let unit = playing_unit().snapshot.copy();
        unit.spoil(DATA, 0, &rubbish(lost));
        heals(&unit);
    }
}

#[test]
fn what_was_learned_comes_back_to_a_disk_of_the_flocks_that_is_mended_or_made_anew() {
    let unit = Unit::new();
    let mut machine = unit.start();
    machine.await_shell();
    machine.run(PROVEN);
    // As the store writes it, once from below and once from beside.
    let learned = "cd /var/lib/dreams/store && for slot in 1 0 1; do \
        echo 'dreams-state-1 1 learned' > new && echo '{}' >> new && mv new state.$slot; done";
    machine.run(learned);
    let kept = "until grep -qa learned \"$(partition dreams_tries)\"; do sleep 1; done; sync";
    machine.run(&format!(". /usr/lib/dreams/disk; {kept}"));
    let size = machine.run(". /usr/lib/dreams/disk; blockdev --getsize64 \"$(flocks)\"");
    drop(machine);
    // Of the first there are copies of the superblock behind the damage; of the second nothing is left.
    for (lost, mend) in [(300 * MIB, "is mended"), (size.trim().parse().unwrap(), "is made anew")] {
        unit.spoil(DATA, 0, &rubbish(lost));
        let (mut machine, _) = heals(&unit);
        machine.run(&format!("journalctl --boot --output=cat | grep -q '{mend}'"));
        machine.run("grep -q learned /var/lib/dreams/store/state.0");
    }
}

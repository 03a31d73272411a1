//! A unit changes to its next system, and returns from one that shows nothing or is damaged.
//!
//! Owns the claims on the two slots: which one runs after which start, the boot loader's entries, and that flock and
//! settings stay as they are. How the system was installed is in `next_system.rs`.

use crate::machine::picture::{Look, only_art};
use crate::machine::{Machine, PAUSE};
use crate::starts::first_start::{MOVES, OFTEN, PROVEN, playing_unit};
use crate::unit::{NOW, SLOT_B, Unit, rubbish};
use crate::updates::next_system::{FETCH, NEXT, UpdatingUnit, kept, updating_unit, version};

/// For the unit's shell: waits for the check of what the boot loader starts.
const LOOKED: &str =
    "until journalctl --boot --output=cat --unit=dreams-mend@boot | grep -q Finished; do sleep 1; done";
/// How often the boot loader tries a system that is not known to be good.
const TRIES: usize = 3;

/// Starts `unit`, which may show the flock of the stick.
fn start(unit: &Unit) -> Machine {
    let mut machine = unit.start();
    machine.also_expect(playing_unit().stick.reference);
    machine
}

/// Plays until this start has proved its system good, with the flock and settings of before; `looks` are those so far.
fn proves_good(machine: &mut Machine, mut looks: Vec<Look>) {
    let UpdatingUnit { path, kept: before, .. } = updating_unit();
    looks.extend(machine.watch_move(PAUSE, MOVES));
    looks.extend(machine.watch_while(PAUSE, PROVEN));
    only_art(&looks, OFTEN);
    assert!(path.clone().came_back_with(&looks), "the path goes on");
    assert_eq!(&kept(machine), before, "the flock and the settings are as they were");
    machine.is_well();
}

/// The boot loader's entries.
fn entries(machine: &mut Machine) -> String {
    let look = "mkdir -p /run/look && mount -o ro /dev/vda1 /run/look && ls /run/look/loader/entries | grep dreams_; umount /run/look";
    machine.run(look).split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The same of both systems, when the next one is good or was given up.
fn all(next: &str) -> String {
    format!("dreams_{NOW}_1+1.conf dreams_{NOW}_2+1.conf dreams_{NEXT}_1{next}.conf dreams_{NEXT}_2{next}.conf")
}

#[test]
fn a_system_that_never_shows_a_picture_is_left_again_and_the_flock_is_untouched() {
    let unit = updating_unit().written.copy();
    let mut machine = start(&unit);
    for left in (0..TRIES).rev() {
        machine.await_word("BENCH");
        assert_eq!(version(&mut machine), NEXT);
        let trial = format!("dreams_{NEXT}_1+{left}-{}.conf", TRIES - left);
        assert_eq!(entries(&mut machine), format!("dreams_{NOW}_1+1.conf dreams_{NOW}_2+1.conf {trial}"));
        // Before it can have shown a hundred frames.
        machine.reset();
    }
    let looks = machine.await_shell();
    assert_eq!(version(&mut machine), NOW, "the other one never showed a picture");
    proves_good(&mut machine, looks);
    machine.run(&format!("{FETCH} && [ ! -e /var/lib/dreams/store/system/staged ]"));
}

#[test]
fn a_new_system_that_shows_its_picture_stays_until_its_root_is_damaged() {
    let unit = updating_unit().written.copy();
    let mut machine = start(&unit);
    let looks = machine.await_shell();
    assert_eq!(version(&mut machine), NEXT);
    proves_good(&mut machine, looks);
    machine.run(LOOKED);
    assert_eq!(entries(&mut machine), all("+1"), "it is good");
    let starts = machine.run("journalctl --directory=/var/lib/dreams/journal --list-boots --quiet --no-pager | wc -l");
    assert!(starts.trim().parse::<u32>().unwrap() >= 2, "the log still knows of the start before, found {starts}");
    drop(machine);

    // The beginning, which every start reads; and the middle, which a start may not read at all.
    for (at, length) in [(0, 1 << 20), (40 << 20, 60 << 20)] {
        let unit = unit.copy();
        unit.spoil(SLOT_B, at, &rubbish(length));
        let mut machine = start(&unit);
        let looks = machine.await_shell();
        assert_eq!(version(&mut machine), NOW, "a damaged system gives way");
        proves_good(&mut machine, looks);
        assert_eq!(entries(&mut machine), all("+0-1"), "it is not asked again");
    }
}

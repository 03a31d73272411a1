//! A unit that starts without a display.
//!
//! Owns the claims that it comes up all the same, shows the picture when a display is plugged in, and does not count
//! such a start against its system.

use crate::damage::boot_copies::LOOKED;
use crate::machine::PAUSE;
use crate::machine::hardware::{Display, Hardware, USUAL};
use crate::machine::picture::{Look, only_art};
use crate::starts::boot_time::seconds;
use crate::starts::first_start::{MOVES, OFTEN, PROVEN, UP, playing_unit};
use crate::unit::direct_boot::parts;
use crate::unit::{NOW, Unit};
use crate::updates::next_system::{NEXT, updating_unit, version};
use claims::programs::repository;

/// A kernel parameter: the connector counts as unplugged.
const UNPLUGGED: &str = " video=Virtual-1:d";
/// For the unit's shell: the log says that this start is not counted.
const EXCUSED: &str =
    "until journalctl --boot --unit=dreams-good --output=cat | grep -q 'not counted'; do sleep 1; done";
const PLUG: &str = "echo on > /sys/class/drm/card0-Virtual-1/status";

#[test]
fn a_unit_without_a_display_comes_up_all_the_same_and_lights_one_that_is_plugged_in_later() {
    let folder = tempfile::tempdir_in(repository().join("target/image")).unwrap();
    let mut words = parts(folder.path());
    words.last_mut().expect("the kernel's command line").push_str(UNPLUGGED);
    let unit = Unit::new();
    let mut machine = unit.start_with(&words);
    let mut looks = machine.await_shell();
    machine.run(UP);
    let up = seconds(&mut machine, "ActiveEnterTimestampMonotonic multi-user.target");
    println!("up after {up:.1} s without a display");
    assert_eq!(machine.run("systemctl show -P ActiveState dreams-player"), "activating", "it waits for a display");
    machine.is_well();
    looks.extend(machine.look());
    assert!(!looks.iter().any(Look::is_art), "there is no display");

    machine.run(PLUG);
    only_art(&machine.watch_move(PAUSE, MOVES), OFTEN);
    assert_eq!(machine.run("systemctl show -P ActiveState dreams-player"), "active");
    machine.is_well();
}

/// Starts it six times without a display; none is counted.
fn start_unseen(unit: &Unit, what: &str) {
    for _ in 0..6 {
        let mut machine = unit.start_as(Hardware { display: Display::None, ..USUAL }, &[]);
        machine.await_word("BENCH");
        assert_eq!(version(&mut machine), NEXT, "{what}");
        machine.run(EXCUSED);
    }
}

#[test]
fn six_starts_without_a_display_are_not_held_against_a_system_good_or_on_trial() {
    let unit = updating_unit().written.copy();
    start_unseen(&unit, "on trial");
    let mut machine = unit.start();
    machine.also_expect(playing_unit().stick.reference);
    let mut looks = machine.await_shell();
    looks.extend(machine.watch_while(PAUSE, PROVEN));
    // Until then it has one copy, and a machine that resets in it, whyever, starts the system before it.
    looks.extend(machine.watch_while(PAUSE, LOOKED));
    only_art(&looks, OFTEN);
    assert_eq!(version(&mut machine), NEXT);
    drop(machine);
    start_unseen(&unit, "a good one");
    let mut machine = unit.start();
    machine.also_expect(playing_unit().stick.reference);
    let mut looks = machine.await_shell();
    looks.extend(machine.watch_move(PAUSE, MOVES));
    only_art(&looks, OFTEN);
    assert_eq!(version(&mut machine), NEXT, "{NOW} is not asked");
}

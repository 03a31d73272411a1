//! A display that is not there when its unit starts.
//!
//! Owns the claim that the unit comes up all the same, and lights the display when it is plugged in.

use crate::machine::PAUSE;
use crate::picture::{Look, only_art};
use crate::programs::repository;
use crate::soon::{parts, seconds};
use crate::starting::{MOVES, OFTEN, UP};
use crate::unit::Unit;

/// What the kernel is told of the socket: nothing is plugged in, whatever it says.
const UNPLUGGED: &str = " video=Virtual-1:d";
const PLUG: &str = "echo on > /sys/class/drm/card0-Virtual-1/status";

#[test]
fn a_unit_without_a_display_comes_up_all_the_same_and_lights_one_that_is_plugged_in_later() {
    let folder = tempfile::tempdir_in(repository().join("target/image")).unwrap();
    let mut words = parts(folder.path()).0;
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

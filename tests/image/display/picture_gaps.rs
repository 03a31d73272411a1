//! Looks so close to each other that nothing comes between them.
//!
//! Owns the claims on every moment of a start and of an update. The machine stands still while it is looked at, so that its
//! own clock says how close the looks are.

use crate::machine::picture::only_art;
use crate::starts::first_start::{MOVES, PROVEN, PlayingUnit, UP, playing_unit};
use crate::unit::Unit;
use crate::updates::flock_from_stick::is_autumn;
use std::time::Duration;

/// Between two looks.
const PAUSE: Duration = Duration::from_millis(30);

#[test]
fn twenty_looks_a_second_at_an_update_show_art_and_nothing_else() {
    let PlayingUnit { snapshot, stick, .. } = playing_unit();
    let (_unit, mut machine) = snapshot.wake();
    machine.also_expect(stick.reference);
    machine.stands_still = true;
    machine.plug(&stick.disk);
    let mut looks = machine.watch_for(PAUSE, "the flock of the stick", is_autumn);
    looks.extend(machine.watch_move(PAUSE, MOVES));
    only_art(&looks, 20.0);
}

#[test]
fn ten_looks_a_second_at_a_start_show_art_and_nothing_else() {
    let unit = Unit::new();
    let mut machine = unit.start();
    machine.stands_still = true;
    let mut looks = machine.watch(2 * PAUSE, "its shell", |line| line.contains("BENCH"));
    looks.extend(machine.watch_while(2 * PAUSE, PROVEN));
    looks.extend(machine.watch_while(2 * PAUSE, UP));
    only_art(&looks, 10.0);
}

//! Looks at the screen so close to each other that no gap in the picture is missed.
//!
//! Owns the claims on a whole start and a whole update. The machine is stopped during each look, so that the interval
//! is short in its own time.

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

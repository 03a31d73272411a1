//! A stick is put in, and its flock plays.
//!
//! Owns what is on the glass from then on: the picture, the placard on it, the new picture.

use crate::machine::PAUSE;
use crate::picture::{Look, only_art};
use crate::starting::{MOVES, OFTEN, Playing, playing};
use crate::stick::AUTUMN;

/// Whether the glass shows the flock of the stick, and nothing over it.
pub(crate) fn is_autumn(look: &Look) -> bool {
    look.place.as_ref().is_some_and(|place| &*place.flock == AUTUMN && !place.has_placard)
}

#[test]
fn a_stick_brings_a_flock_and_says_so_on_the_running_picture() {
    let Playing { frozen, stick, .. } = playing();
    let (_unit, mut machine) = frozen.wake();
    machine.hang(stick.gallery);
    machine.plug(&stick.disk);
    let looks = machine.watch_for(PAUSE, is_autumn);
    let since = only_art(&looks, OFTEN);
    let places = || since.iter().filter_map(|look| look.place.as_ref());
    assert!(places().any(|place| place.has_placard && &*place.flock == "demo"), "the card is on the running picture");
    machine.pull();
    only_art(&machine.watch_move(PAUSE, MOVES), OFTEN);
    machine.run("[ -L /var/lib/dreams/store/current ]");
    machine.run("[ -z \"$(systemctl --failed --no-legend --plain)\" ]");
}

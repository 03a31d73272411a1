//! Looks so close to each other that nothing comes between them.
//!
//! Owns the claim on every moment of an update. The machine stands still while it is looked at, so that its own clock says
//! how close the looks are.

use crate::arriving::is_autumn;
use crate::picture::only_art;
use crate::starting::{MOVES, Playing, playing};
use std::time::Duration;

/// Between two looks.
const PAUSE: Duration = Duration::from_millis(30);

#[test]
fn twenty_looks_a_second_at_an_update_show_art_and_nothing_else() {
    let Playing { frozen, stick, .. } = playing();
    let (_unit, mut machine) = frozen.wake();
    machine.hang(stick.gallery);
    machine.stands_still = true;
    machine.plug(&stick.disk);
    let mut looks = machine.watch_for(PAUSE, is_autumn);
    looks.extend(machine.watch_move(PAUSE, MOVES));
    only_art(&looks, 20.0);
}

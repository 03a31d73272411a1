//! The player falls, and systemd brings it back.
//!
//! Owns what is on the glass meanwhile: the last frame, held.

use crate::machine::PAUSE;
use crate::picture::only_art;
use crate::starting::{MOVES, OFTEN, playing};

#[test]
fn a_player_that_falls_comes_back_and_its_last_frame_is_held_meanwhile() {
    let (_unit, mut machine) = playing().frozen.wake();
    let player = "systemctl show --value --property=MainPID dreams-player";
    let before = machine.run(player);
    let fall =
        format!("systemctl kill --signal=KILL dreams-player; until [ $({player}) != {before} ]; do sleep 1; done");
    let mut looks = machine.watch_while(PAUSE, &fall);
    looks.extend(machine.watch_move(PAUSE, MOVES));
    only_art(&looks, OFTEN);
}

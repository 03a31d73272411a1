//! The player is killed, and systemd starts it again.
//!
//! Owns the claims that the last frame stays on the screen, and that the walk continues. A player that stops or hangs
//! is in `watchdog.rs`, which takes longer.

use crate::machine::picture::only_art;
use crate::machine::{Machine, PAUSE};
use crate::starts::first_start::{MOVES, OFTEN, PlayingUnit, playing_unit};
use crate::unit::path::Path;

/// Prints its process id.
const PROCESS: &str = "systemctl show --value --property=MainPID dreams-player";

/// `command` ends the player, which comes back.
pub(crate) fn ends_and_comes_back(machine: &mut Machine, path: &mut Path, command: &str) {
    let before = machine.run(PROCESS);
    machine.watch_move(PAUSE, 1).iter().for_each(|look| path.saw(look));
    let gone = format!("{command}; until [ $({PROCESS}) != {before} ]; do sleep 1; done");
    let mut looks = machine.watch_while(PAUSE, &gone);
    let held = looks.last().and_then(|look| look.place.clone());
    let first = looks.iter().position(|look| look.place == held).unwrap_or(0);
    looks[..first].iter().for_each(|look| path.saw(look));
    let back = machine.watch_move(PAUSE, MOVES);
    let moved = back.iter().position(|look| look.place != held).expect("it moves on");
    assert!(path.came_back_with(&back[moved..]), "the path goes on");
    looks.extend(back);
    println!("`{command}`: back at {path}");
    only_art(&looks, OFTEN);
}

#[test]
fn a_player_that_falls_comes_back_and_its_last_frame_is_held_meanwhile() {
    let PlayingUnit { snapshot, path, .. } = playing_unit();
    let (_unit, mut machine) = snapshot.wake();
    ends_and_comes_back(&mut machine, &mut path.clone(), "systemctl kill --signal=KILL dreams-player");
}

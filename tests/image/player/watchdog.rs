//! The player stops or hangs, and the watchdog makes systemd start it again.
//!
//! Owns the two ways to hang. The watchdog is fed by flips only.

use crate::player::restart::ends_and_comes_back;
use crate::starts::first_start::{PlayingUnit, playing_unit};

/// Freezes its processes, so that they cannot even end.
const FREEZE: &str = "echo 1 > /sys/fs/cgroup/$(systemctl show -P ControlGroup dreams-player)/cgroup.freeze";

#[test]
fn a_player_that_stops_or_hangs_is_brought_back_by_the_watchdog() {
    let PlayingUnit { snapshot, path, .. } = playing_unit();
    let (_unit, mut machine) = snapshot.wake();
    let mut path = path.clone();
    for (times, command) in ["systemctl kill --signal=STOP dreams-player", FREEZE].into_iter().enumerate() {
        ends_and_comes_back(&mut machine, &mut path, command);
        let told = machine.run("journalctl --unit=dreams-player --output=cat | grep -c 'Watchdog timeout'");
        assert_eq!(told, (times + 1).to_string(), "the watchdog has seen `{command}`");
    }
}

//! A unit that plays day and night restarts into its next system.
//!
//! Owns the claim that it does so by itself at the set hour, and not before. The hours are tried in
//! `crates/settings/src/hours.rs`, what delays the restart in `it/unit/owner_settings.rs`.

use crate::machine::PAUSE;
use crate::machine::clock::now;
use crate::starts::first_start::{MOVES, UP, playing_unit};
use crate::unit::NOW;
use crate::updates::next_system::{NEXT, RESTART, until_written, updating_unit, version};

/// For the unit's shell: the restart waits for its hour.
const WAITS: &str = "[ \"$(systemctl show -P SubState dreams-restart)\" = start ]";

#[test]
fn a_unit_restarts_into_its_next_system_at_four_and_at_no_other_hour() {
    let (_unit, mut machine) = updating_unit().writing.snapshot.wake();
    machine.also_expect(playing_unit().stick.reference);
    machine.run(&format!("date -u -s '2047-03-01 05:00:00' && systemctl unmask --runtime {RESTART}"));
    machine.run(&until_written());
    machine.run(&format!("until {WAITS}; do sleep 1; done; date -u -s '2047-03-02 03:59:30'"));
    machine.watch_move(PAUSE, MOVES);
    machine.run(WAITS);
    assert_eq!(version(&mut machine), NOW);
    machine.is_well();
    let (at, hour) = (now(), machine.run("date -u +%H:%M:%S"));
    machine.await_shell();
    println!("it had {hour}, and was there again {:.1?} later", now().saturating_sub(at));
    assert_eq!(version(&mut machine), NEXT);
    machine.run(UP);
    machine.watch_move(PAUSE, MOVES);
    machine.is_well();
}

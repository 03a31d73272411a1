//! A flock on trial before a display that is not there.
//!
//! Owns the claim that nothing counts then. All other claims on a trial are in `it/player/flock_switch.rs`.

use crate::display::hot_plug::{CARD, HANDS};
use crate::guest::{script, shell_words, succeed_in_virtual_time};
use claims::editions::{edition, state, unit_with};
use claims::flocks::SMALL;
use claims::player_run::PlayerRun;
use serde_json::Value;

#[test]
fn a_trial_counts_nothing_that_was_decoded_for_a_display_that_is_not_plugged_in() {
    let flock = SMALL.flock();
    let (unit, _) = unit_with(&flock);
    unit.maker.bundle(&unit.stick(), &edition(&flock, "two"), &[], 2);
    unit.updated(&[]);
    let playing = PlayerRun::of(&unit.path("store/current")).with(&["--screen", "kms:/dev/dri/$card"]);
    let play = shell_words(&playing.command());
    let start = format!("{play} &\nplayer=$!\nsleep 30; kill -KILL $player; wait $player || true\n");
    let text = format!("{CARD}{HANDS}pull\n{}", start.repeat(4));
    succeed_in_virtual_time(120, &script(&text));
    let trial = &state(&unit)["trial"];
    assert_eq!(
        (&trial["generation"]["number"], &trial["starts"], &trial["joins"]),
        (&2.into(), &0.into(), &Value::Null)
    );
}

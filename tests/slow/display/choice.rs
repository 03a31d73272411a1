//! Which screen the player takes by itself.
//!
//! Owns the claim that it takes a display where there is one, and says which.

use crate::guest::{script, shell_words, succeed_in_virtual_time};
use claims::flocks::SMALL;
use claims::player_run::PlayerRun;

#[test]
fn a_display_is_lit_where_there_is_one_and_the_virtual_screen_where_there_is_none() {
    let flock = SMALL.flock();
    for (prepare, screen) in [("true", "kms:/dev/dri/card1 "), ("rm -r /dev/dri", "virtual")] {
        let playing = PlayerRun::of(&flock.folder).with(&["--clips", "2", "--seed", "1"]);
        succeed_in_virtual_time(60, &script(&format!("{prepare}; {}", shell_words(&playing.command()))));
        let [start] = &playing.trace().starts[..] else { panic!("one start") };
        assert!(start.screen.starts_with(screen), "after `{prepare}`, `{}` is lit", start.screen);
    }
}

//! The first picture, shown before the player starts.
//!
//! Owns the claims that the prelude shows it, that it stays, and that the player begins with the same picture, also
//! where no place was saved yet. `tests/image/starts/boot_time.rs` shows that it comes before systemd.

use crate::display::scanout::scanned_out_while;
use crate::guest::{shell_words, word};
use claims::flocks::JOINS;
use claims::player_run::{PlayerRun, VKMS};
use claims::programs;
use std::process::Command;

/// Vblanks observed, from before the player's start until after its first frames.
const LOOKS: usize = 150;

#[test]
fn a_first_picture_is_held_until_the_player_goes_on_from_it() {
    let flock = JOINS.flock();
    let playing = PlayerRun::of(&flock.folder).with(&["--screen", VKMS, "--clips", "8"]);
    let said = playing.path("said");
    let mut prelude = Command::new(programs::player());
    prelude.args(["--prelude", "--screen", VKMS, "--flock"]).arg(&flock.folder);
    prelude.arg("--state").arg(playing.path("state"));
    let (prelude, player, said) = (shell_words(&prelude), shell_words(&playing.command()), word(&said));
    let before = format!(
        "mount -t tmpfs run /run; mkdir /run/dreams-prelude; {prelude} > {said} & first=$!; \
         until [ \"$(cat {said})\" = lit ]; do sleep 0.1; done"
    );
    let glass = scanned_out_while(&playing, LOOKS, &before, &format!("sleep 1; {player}; wait $first"));

    let trace = playing.trace();
    let (first, second) = (&trace.flips[0], &trace.flips[1]);
    assert_eq!((first.frame, trace.faults.len()), (0, 0));
    let mut looks: Vec<_> = glass.iter().collect();
    looks.sort();
    assert!(looks.windows(2).all(|pair| pair[1].0 - pair[0].0 == 1), "the display is never off: {looks:?}");
    let (held, played): (Vec<_>, Vec<_>) = looks.into_iter().partition(|(vblank, _)| **vblank < second.vblank);
    let before = held.iter().filter(|(vblank, _)| **vblank < first.vblank).count();
    assert!(before > 20 && held.len() > before && played.len() > 20, "{before} of {} before the player", held.len());
    assert!(held.iter().all(|(_, picture)| *picture == held[0].1), "one picture until the player's second: {held:?}");
    assert!(played.iter().any(|(_, picture)| *picture != held[0].1), "and then the others");
}

//! For how many vblanks frames stay lit on a 60 Hz display.
//!
//! Owns the five rates of film and video. The arithmetic they are held to stands in `joins.rs`, written afresh.

use crate::flocks::Plan;
use crate::guest::succeed_in_virtual_time;
use crate::joins::on_the_beat;
use crate::playing::{Playing, VKMS};

/// Plays 24 clips of 7 to 13 frames on the exact 60 Hz mode of 1280x720 and holds every flip to the beat.
/// Returns for how many vblanks the first frames were lit.
fn first_holds(name: &'static str, fps: (u32, u32)) -> Vec<u32> {
    let flock = Plan { name, size: (1280, 720), fps, sheep: 3, frames: 7 }.flock();
    let playing = Playing::of(&flock.folder).with(&["--screen", VKMS, "--seed", "3", "--clips", "24"]);
    succeed_in_virtual_time(120, &playing.command());
    let trace = playing.trace();
    assert_eq!(trace.refresh(), (60, 1), "the mode lit is exactly 60 Hz");
    assert_eq!(trace.joins.len(), 23);
    on_the_beat(&trace, (fps.0.into(), fps.1.into()));
    trace.flips.windows(2).take(8).map(|pair| pair[1].vblank.wrapping_sub(pair[0].vblank)).collect()
}

#[test]
fn twenty_a_second_is_lit_three_three_three() {
    assert_eq!(first_holds("fps20", (20, 1)), [3, 3, 3, 3, 3, 3, 3, 3]);
}

#[test]
fn film_slowed_for_ntsc_is_lit_two_three_with_a_step_now_and_then() {
    assert_eq!(first_holds("fps23976", (24_000, 1_001)), [3, 2, 3, 2, 3, 2, 3, 2]);
}

#[test]
fn film_is_lit_two_three_two_three() {
    assert_eq!(first_holds("fps24", (24, 1)), [2, 3, 2, 3, 2, 3, 2, 3]);
}

#[test]
fn pal_is_lit_two_three_two_three_two() {
    assert_eq!(first_holds("fps25", (25, 1)), [2, 3, 2, 3, 2, 2, 3, 2]);
}

#[test]
fn thirty_a_second_is_lit_two_two_two() {
    assert_eq!(first_holds("fps30", (30, 1)), [2, 2, 2, 2, 2, 2, 2, 2]);
}

//! For how many vblanks frames are shown on a display of 60 Hz, and of 59.81 Hz.
//!
//! Owns the five rates of film and video. The expected values are calculated independently in `joins.rs`.

use crate::display::joins::on_the_beat;
use crate::guest::succeed_in_virtual_time;
use claims::flocks::Plan;
use claims::player_run::{PlayerRun, VKMS};
use claims::trace::Trace;
use std::fs;

/// Plays 24 clips of 7 to 13 frames in the exact 60 Hz mode of 1280x720 and checks the vblank of every flip. Returns
/// for how many vblanks the first frames were shown.
fn first_holds(name: &'static str, fps: (u32, u32)) -> Vec<u32> {
    let trace = played(&Plan { name, size: (1280, 720), fps, sheep: 3, frames: 7 }, "1280x720@60");
    assert_eq!(trace.refresh(), (60, 1), "the mode lit is exactly 60 Hz");
    trace.flips.windows(2).take(8).map(|pair| pair[1].vblank.wrapping_sub(pair[0].vblank)).collect()
}

/// Plays 24 clips of a flock in the mode that the owner has set, and checks the vblank of every flip.
fn played(plan: &Plan, mode: &str) -> Trace {
    let flock = plan.flock();
    let playing = PlayerRun::of(&flock.folder).with(&["--screen", VKMS, "--seed", "3", "--clips", "24"]);
    let owner = playing.path("dreams.toml");
    fs::write(&owner, format!("mode = \"{mode}\"\n")).unwrap();
    let playing = playing.with(&["--owner", owner.to_str().unwrap()]);
    succeed_in_virtual_time(120, &playing.command());
    let trace = playing.trace();
    assert_eq!(trace.joins.len(), 23);
    on_the_beat(&trace, (plan.fps.0.into(), plan.fps.1.into()));
    trace
}

#[test]
fn every_frame_is_lit_equally_long_where_the_display_is_a_little_slow() {
    // 240 frames: by the clock alone, one in 160 would be lit for a vblank less.
    let plan = Plan { name: "slow-display", size: (640, 400), fps: (30, 1), sheep: 3, frames: 7 };
    let trace = played(&plan, "1280x800@59.81");
    let (refresh, per) = trace.refresh();
    assert_eq!(refresh * 100 / per, 5_981, "vkms has a mode of 1280x800 at 59.81 Hz");
    assert!(trace.flips.len() > 200);
    assert!(trace.flips.windows(2).all(|pair| pair[1].vblank.wrapping_sub(pair[0].vblank) == 2));
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

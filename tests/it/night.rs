//! The night, and how bright the day is, on a real display driver.
//!
//! Owns the claims on the hours and the brightness of a unit; which light it is at what time is decided in the player's
//! `hours.rs`, and tried there.

use crate::flocks::SMALL;
use crate::glass::{SHORT, scanned_out};
use crate::guest::{script, shell_words, succeed_in_virtual_time};
use crate::playing::{Playing, VKMS};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;

/// A seed like any other.
const SEED: &str = "3";
/// Vblanks looked at, for each brightness.
const LOOKS: usize = 60;

#[test]
fn the_display_sleeps_at_night_and_the_path_goes_on_where_it_was() {
    let flock = SMALL.flock();
    let hours = ["--hours", "08:00-23:00", "--timezone", "UTC", "--brightness", "22:00 60, 08:00 100"];
    let playing = Playing::of(&flock.folder).with(&["--screen", VKMS, "--seed", SEED, "--hash"]).with(&hours);
    let seen = playing.path("seen");
    let text = format!(
        "state() {{ sed -n 's/^\\tactive=//p' /sys/kernel/debug/dri/vkms/state; }}
        exec 3> {seen}
        date -u -s '2026-07-01 22:59:50' > /dev/null; {player} & player=$!
        sleep 5; state >&3; sleep 10; state >&3
        date -u -s '2026-07-02 07:59:50' > /dev/null; sleep 5; state >&3; sleep 15; state >&3
        date -u -s '1970-01-01 00:01:00' > /dev/null; sleep 20; state >&3
        kill $player; wait $player",
        seen = seen.display(),
        player = shell_words(&playing.command())
    );
    succeed_in_virtual_time(180, &script(&text));
    let lights = fs::read_to_string(seen).unwrap();
    assert_eq!(
        lights.split_whitespace().collect::<Vec<_>>(),
        ["1", "0", "0", "1", "1"],
        "day, night, night, day, no date"
    );

    let trace = playing.trace();
    assert!(trace.faults.is_empty(), "{:?}", trace.faults);
    let end = trace.end.as_ref().unwrap();
    assert_eq!(
        (end.late, end.repeated, end.skipped),
        (0, 1, 0),
        "the last frame of the evening is the morning's first"
    );
    let mut flips: Vec<_> =
        trace.flips.iter().map(|flip| (flip.clip.as_str(), flip.frame, flip.hash.as_deref())).collect();
    flips.dedup();
    let walk = flock.walk(SEED, trace.joins.len() + 1);
    let due: Vec<_> = flock.frames(&walk).into_iter().map(|(clip, frame, hash)| (clip, frame, Some(hash))).collect();
    assert_eq!(flips, due[..flips.len()], "every frame is lit, in order");
    let longest = trace.flips.windows(2).map(|pair| pair[1].t_ns - pair[0].t_ns).max().unwrap() / 1_000_000_000;
    assert!((10..=18).contains(&longest), "dark for {longest} s of some 14");
}

/// The checksum on the glass of every frame, by its hash, at this brightness.
fn looks(percent: &str) -> BTreeMap<String, String> {
    let options = ["--screen", VKMS, "--seed", SEED, "--hash", "--clips", "40", "--brightness", percent];
    let playing = Playing::of(&SHORT.flock().folder).with(&options);
    let glass = scanned_out(&playing, LOOKS);
    let look = |flip: &crate::trace::Flip| Some((flip.hash.clone()?, glass.get(&flip.vblank)?.clone()));
    playing.trace().flips.iter().filter_map(look).collect()
}

#[test]
fn a_display_that_is_dimmed_shows_the_same_frames_and_each_otherwise() {
    let [full, half] = ["100", "50"].map(looks);
    let both: Vec<_> = full.iter().filter_map(|(hash, look)| Some((look, half.get(hash)?))).collect();
    assert!(both.len() >= 10, "{} frames are seen at either brightness", both.len());
    assert!(both.iter().all(|(full, half)| full != half), "every frame looks otherwise");
    let different = |looks: &BTreeMap<String, String>| looks.values().collect::<BTreeSet<_>>().len();
    assert_eq!(different(&half), half.len(), "and still like no other frame");
}

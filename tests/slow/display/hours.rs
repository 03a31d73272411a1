//! Hours and brightness on a real display driver.
//!
//! Owns the claims on the run of an evening, a night and a morning; `crates/settings/src/hours.rs` decides what is shown
//! when, and is tried there.

use crate::display::scanout::{SHORT, scanned_out};
use crate::guest::{script, shell_words, succeed_in_virtual_time, word};
use claims::flocks::{Flock, SMALL};
use claims::player_run::{PlayerRun, VKMS};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;

/// A seed like any other.
const SEED: &str = "3";
/// The checksum by vkms of a black display of 1024x768: CRC-32 of pixels of four 16-bit numbers, alpha first.
const BLACK: &str = "0x4c4126bf";
/// Vblanks observed, for each brightness.
const LOOKS: usize = 60;

#[test]
fn the_display_sleeps_at_night_and_the_path_goes_on_where_it_was() {
    let flock = SMALL.flock();
    let hours = ["--hours", "08:00-23:00", "--timezone", "UTC", "--brightness", "22:00 60, 08:00 100"];
    let playing = PlayerRun::of(&flock.folder).with(&["--screen", VKMS, "--seed", SEED, "--hash"]).with(&hours);
    let lights = over_a_night(&playing);
    assert_eq!(lights, ["1", "0", "0", "1", "1"], "day, night, night, day, no date");
    goes_on(&playing, &flock);
}

#[test]
fn a_night_in_black_leaves_the_display_on_and_the_path_goes_on_where_it_was() {
    let flock = SMALL.flock();
    let hours = ["--hours", "08:00-23:00", "--timezone", "UTC", "--night", "black"];
    let playing = PlayerRun::of(&flock.folder).with(&["--screen", VKMS, "--seed", SEED, "--hash"]).with(&hours);
    let lights = over_a_night(&playing);
    assert_eq!(lights, ["1", "1", "1", "1", "1"]);
    goes_on(&playing, &flock);
    let glasses = fs::read_to_string(playing.path("glass")).unwrap();
    let glasses: Vec<BTreeSet<&str>> = glasses.split("--").map(|looks| looks.split_whitespace().collect()).collect();
    let [evening, night, later, morning, no_date, _] = &glasses[..] else { panic!("{glasses:?}") };
    assert!([evening, morning, no_date].iter().all(|looks| looks.len() > 2), "the picture moves: {glasses:?}");
    assert_eq!((night.len(), night), (1, later), "nothing moves at night");
    assert!([evening, morning, no_date].iter().all(|looks| looks.is_disjoint(night)), "nor is it a frame: {glasses:?}");
    assert_eq!(night.first(), Some(&BLACK), "it is black");
}

#[test]
fn a_display_that_cannot_be_asked_to_switch_off_sleeps_and_wakes_all_the_same() {
    let flock = SMALL.flock();
    for night in ["ddc", "cec"] {
        let hours = ["--hours", "08:00-23:00", "--timezone", "UTC", "--night", night];
        let playing = PlayerRun::of(&flock.folder).with(&["--screen", VKMS, "--seed", SEED, "--hash"]).with(&hours);
        let lights = over_a_night(&playing);
        assert_eq!(lights, ["1", "0", "0", "1", "1"], "{night}: vkms has neither an I2C bus nor a CEC adapter");
        goes_on(&playing, &flock);
    }
}

/// Whether the display was on over an evening, a night and a morning, and when the clock was lost. What was shown is
/// written to `glass`.
fn over_a_night(playing: &PlayerRun) -> Vec<String> {
    let seen = playing.path("seen");
    let text = format!(
        "crc=/sys/kernel/debug/dri/vkms/crtc-0/crc
        state() {{
            sed -n 's/^\\tactive=//p' /sys/kernel/debug/dri/vkms/state >&3
            [ $(tail -c 2 {seen}) = 0 ] || {{ echo auto > $crc/control; head -n 20 $crc/data | cut -d ' ' -f 2 >&4; }}
            echo -- >&4
        }}
        exec 3> {seen} 4> {glass}
        date -u -s '2046-07-01 22:59:50' > /dev/null; {player} & player=$!
        sleep 5; state; sleep 10; state
        date -u -s '2046-07-02 07:59:50' > /dev/null; sleep 5; state; sleep 15; state
        date -u -s '1970-01-01 00:01:00' > /dev/null; sleep 20; state
        kill $player; wait $player",
        seen = word(&seen),
        glass = word(&playing.path("glass")),
        player = shell_words(&playing.command())
    );
    succeed_in_virtual_time(180, &script(&text));
    let lights = fs::read_to_string(seen).unwrap();
    lights.split_whitespace().map(str::to_owned).collect()
}

/// Checks the run over that night: no frame is lost, repeated or late.
fn goes_on(playing: &PlayerRun, flock: &Flock) {
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

/// The checksum of every frame at this brightness, by the frame's hash.
fn looks(percent: &str) -> BTreeMap<String, String> {
    let options = ["--screen", VKMS, "--seed", SEED, "--hash", "--clips", "40", "--brightness", percent];
    let playing = PlayerRun::of(&SHORT.flock().folder).with(&options);
    let glass = scanned_out(&playing, LOOKS);
    let look = |flip: &claims::trace::Flip| Some((flip.hash.clone()?, glass.get(&flip.vblank)?.clone()));
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

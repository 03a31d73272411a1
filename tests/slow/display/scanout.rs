//! The frames that the display scans out.
//!
//! Owns the claim that they are the frames in the trace: vkms composes every frame that it scans out, and reports its
//! checksum with the number of its vblank.

use crate::guest::{script, shell_words, succeed_in_virtual_time, word};
use claims::flocks::Plan;
use claims::player_run::{PlayerRun, VKMS};
use std::collections::HashMap;
use std::fs;

/// Clips so short that most are repeated within the observed vblanks.
pub(crate) const SHORT: Plan = Plan { name: "short", size: (640, 480), fps: (30, 1), sheep: 3, frames: 2 };

/// Vblanks observed: the guest takes a tenth of a second to compose each.
const LOOKS: usize = 150;

/// Plays while another process reads the checksums of so many vblanks; returns the checksums.
pub(crate) fn scanned_out(playing: &PlayerRun, looks: usize) -> HashMap<u32, String> {
    let player = shell_words(&playing.command());
    scanned_out_while(playing, looks, &format!("{player} & player=$!; sleep 1"), "wait $player")
}

/// The same with a script: what it does before the first reading, and during the readings.
pub(crate) fn scanned_out_while(playing: &PlayerRun, looks: usize, before: &str, beside: &str) -> HashMap<u32, String> {
    let list = playing.path("scanned-out");
    let crc = "/sys/kernel/debug/dri/vkms/crtc-0/crc";
    let read = format!("head -n {looks} {crc}/data > {}", word(&list));
    let text = format!("{before}; echo auto > {crc}/control; {read} & looks=$!; {beside}; wait $looks");
    succeed_in_virtual_time(120, &script(&text));
    let text = fs::read_to_string(list).unwrap();
    let line = |line: &str| {
        // The kernel ends each line with a zero byte besides.
        let (vblank, checksum) = line.trim_matches(char::from(0)).split_once(' ')?;
        Some((u32::from_str_radix(vblank.strip_prefix("0x")?, 16).ok()?, checksum.to_owned()))
    };
    text.lines().filter_map(line).collect()
}

#[test]
fn every_frame_of_the_trace_is_on_the_glass_for_all_its_vblanks() {
    let flock = SHORT.flock();
    let playing = PlayerRun::of(&flock.folder).with(&["--screen", VKMS, "--seed", "3", "--hash", "--clips", "40"]);
    let glass = scanned_out(&playing, LOOKS);
    let trace = playing.trace();
    let mut looks: HashMap<&str, &str> = HashMap::new();
    let mut frames: HashMap<&str, &str> = HashMap::new();
    let mut seen = 0;
    for pair in trace.flips.windows(2) {
        let hash = pair[0].hash.as_deref().unwrap();
        let lit = pair[1].vblank.wrapping_sub(pair[0].vblank);
        for vblank in (0..lit).map(|n| pair[0].vblank.wrapping_add(n)) {
            let Some(checksum) = glass.get(&vblank) else { continue };
            seen += 1;
            let (clip, frame) = (&pair[0].clip, pair[0].frame);
            assert_eq!(*looks.entry(hash).or_insert(checksum), checksum, "{clip} {frame} looks the same every time");
            assert_eq!(*frames.entry(checksum).or_insert(hash), hash, "{clip} {frame} looks like no other frame");
        }
    }
    let different = looks.len();
    assert!(seen > 140 && (20..=seen / 3).contains(&different), "{seen} vblanks showed {different} different frames");
}

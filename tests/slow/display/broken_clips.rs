//! Broken clips on a display.
//!
//! Owns the claim that they cost no black frame and are named once. What `dreams check` finds of them is in
//! `it/player/bad_clips.rs`.

use crate::guest::succeed_in_virtual_time;
use claims::broken_clips::{BROKEN, SOUND, broken_flock};
use claims::player_run::{PlayerRun, VKMS};
use claims::programs;
use std::collections::{HashMap, HashSet};
use std::process::Command;

#[test]
fn broken_clips_at_play_time_cost_no_black_frame_and_are_named_once() {
    let names: Vec<_> = BROKEN.iter().map(|(name, ..)| *name).collect();
    for hashed in [true, false] {
        let (_scratch, flock) = broken_flock(&names, hashed);
        let playing = PlayerRun::of(&flock.folder).with(&["--screen", VKMS, "--seed", "2", "--hash", "--clips", "150"]);
        succeed_in_virtual_time(120, &playing.command());
        let trace = playing.trace();

        let mut named: HashMap<&str, u32> = HashMap::new();
        for (_, message) in &trace.faults {
            let clip = BROKEN.iter().find(|(_, clip, ..)| message.contains(clip));
            let (_, clip, ..) = clip.unwrap_or_else(|| panic!("a fault names its clip: {message}"));
            *named.entry(clip).or_default() += 1;
        }
        let once: HashMap<&str, u32> = BROKEN.iter().map(|(_, clip, ..)| (*clip, 1)).collect();
        assert_eq!(named, once, "every broken clip is named once: {:?}", trace.faults);

        let broken: HashSet<_> = BROKEN.iter().map(|(_, clip, ..)| *clip).collect();
        for flip in trace.flips.iter().filter(|flip| !broken.contains(flip.clip.as_str())) {
            let place = usize::try_from(flip.frame).unwrap();
            assert_eq!(flip.hash.as_ref(), flock.shows[&flip.clip].get(place), "{} {}", flip.clip, flip.frame);
        }
        let black = Some(black_frame());
        assert!(trace.flips.iter().all(|flip| flip.hash.is_some() && flip.hash != black), "no frame is black");
        let longest = trace.flips.windows(2).map(|pair| pair[1].t_ns - pair[0].t_ns).max();
        assert!(longest <= Some(500_000_000), "the picture stands still for {longest:?} ns at a bad clip");
    }
}

/// The hash of a black frame of the sound flock's size.
fn black_frame() -> String {
    let (width, height) = SOUND.size;
    let input = format!("color=black:size={width}x{height},format=yuv420p");
    let mut ffmpeg = Command::new("ffmpeg");
    ffmpeg.args(["-v", "error", "-nostdin", "-f", "lavfi", "-i", &input, "-frames:v", "1", "-f", "framemd5", "-"]);
    let list = String::from_utf8(programs::succeed(&mut ffmpeg)).unwrap();
    list.lines().last().and_then(|line| line.rsplit(',').next()).unwrap().trim().to_owned()
}

//! Clips that are damaged in every way that a disk or an artist may damage them.
//!
//! Owns the claims that the tools report each of them, and that a player leaves them out, reports each once, and never
//! shows black.

use crate::clips::Encode;
use crate::flocks::{Flock, Plan};
use crate::guest::succeed_in_virtual_time;
use crate::player_run::{PlayerRun, VKMS};
use crate::programs::{self, claims_folder, output};
use crate::tools::command_line::json;
use std::collections::{HashMap, HashSet};
use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

/// A sound flock with clips to break.
const SOUND: Plan = Plan { name: "sound", size: (640, 480), fps: (30, 1), sheep: 6, frames: 12 };

/// Breaks the clip at a path.
type Break = fn(&Path);

/// Every kind of damage, the clip that has it, and the kind of fault that `dreams check` reports. The damaged
/// transitions are the chords of the ring: the walk reaches all of them again and again.
const BROKEN: [(&str, &str, &str, Break); 9] = [
    ("a flipped byte", "s0=s2.mp4", "damaged-clip", flip_a_byte),
    ("half the file", "s1=s3.mp4", "damaged-clip", halve),
    ("empty", "s2=s4.mp4", "damaged-clip", empty),
    ("another codec", "s3=s5.mp4", "wrong-clip", another_codec),
    ("another size", "s4=s0.mp4", "wrong-clip", another_size),
    ("missing", "s5=s1.mp4", "missing-clip", remove),
    ("a directory", "s2.mp4", "missing-clip", directory),
    ("unreadable", "s0.mp4", "missing-clip", unreadable),
    ("a frame too few", "s3.mp4", "wrong-clip", a_frame_less),
];

/// Flips the first byte after the middle that breaks decoding: some only change a colour, which only the hash shows.
fn flip_a_byte(clip: &Path) {
    let sound = fs::read(clip).unwrap();
    for place in sound.len() / 2..sound.len() {
        let mut bytes = sound.clone();
        bytes[place] ^= 0x55;
        fs::write(clip, bytes).unwrap();
        let mut ffmpeg = Command::new("ffmpeg");
        ffmpeg.args(["-v", "error", "-nostdin", "-i"]).arg(clip).args(["-f", "null", "-"]);
        if !output(&mut ffmpeg).stderr.is_empty() {
            return;
        }
    }
    panic!("no flipped byte of `{}` disturbs a decoder", clip.display());
}

fn halve(clip: &Path) {
    let bytes = fs::read(clip).unwrap();
    fs::write(clip, &bytes[..bytes.len() / 2]).unwrap();
}

fn empty(clip: &Path) {
    fs::write(clip, []).unwrap();
}

fn another_codec(clip: &Path) {
    Encode { size: SOUND.size, fps: SOUND.fps, frames: 12, number: 90 }.make_as("mpeg4", clip);
}

fn another_size(clip: &Path) {
    Encode { size: (320, 240), fps: SOUND.fps, frames: 12, number: 91 }.make(clip);
}

fn a_frame_less(clip: &Path) {
    Encode { size: SOUND.size, fps: SOUND.fps, frames: 11, number: 92 }.make(clip);
}

fn remove(clip: &Path) {
    fs::remove_file(clip).unwrap();
}

fn directory(clip: &Path) {
    remove(clip);
    fs::create_dir(clip).unwrap();
}

/// A link to itself, which even root cannot open.
fn unreadable(clip: &Path) {
    remove(clip);
    symlink(clip, clip).unwrap();
}

/// A copy of the sound flock in a scratch folder, with the damage of [`BROKEN`] that `done` names. With `hashed` the
/// manifest has the hashes of the sound clips, otherwise none.
fn broken_flock(done: &[&str], hashed: bool) -> (tempfile::TempDir, Flock) {
    let sound = SOUND.flock();
    let scratch = tempfile::tempdir_in(claims_folder()).unwrap();
    for entry in fs::read_dir(&sound.folder).unwrap() {
        let entry = entry.unwrap();
        fs::copy(entry.path(), scratch.path().join(entry.file_name())).unwrap();
    }
    for (_, clip, _, spoil) in BROKEN.iter().filter(|(name, ..)| done.contains(name)) {
        spoil(&scratch.path().join(clip));
    }
    if !hashed {
        let manifest = fs::read_to_string(scratch.path().join("flock.toml")).unwrap();
        let kept: String = manifest.split_inclusive('\n').filter(|line| !line.starts_with("hash")).collect();
        fs::write(scratch.path().join("flock.toml"), kept).unwrap();
    }
    let flock = Flock { folder: scratch.path().to_owned(), shows: sound.shows };
    (scratch, flock)
}

/// The faults that `dreams check` finds in `flock`, as kind and clip, with its exit code.
fn faults(flock: &Flock) -> (Option<i32>, Vec<(String, String)>) {
    let said = output(Command::new(programs::dreams()).arg("check").arg(&flock.folder).arg("--json"));
    let answer = json(&said);
    let text = |value: &serde_json::Value| value.as_str().unwrap_or_default().to_owned();
    let faults = answer["faults"].as_array().unwrap().iter();
    (said.status.code(), faults.map(|fault| (text(&fault["kind"]), text(&fault["clip"]))).collect())
}

#[test]
fn every_broken_clip_is_named_with_its_fault_kind() {
    for (name, clip, kind, _) in BROKEN {
        for hashed in [true, false] {
            let (_scratch, flock) = broken_flock(&[name], hashed);
            let (code, faults) = faults(&flock);
            assert_eq!(code, Some(1), "{name}, hashed {hashed}");
            assert!(!faults.is_empty() && faults.iter().all(|(_, named)| named == clip), "{name}: {faults:?}");
            // A clip in another form also differs from the hash of the one it replaced.
            let kinds: HashSet<_> = faults.iter().map(|(kind, _)| kind.as_str()).collect();
            assert!(kinds.contains(kind), "{name}, hashed {hashed}: wanted `{kind}`, found {faults:?}");
        }
    }
}

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

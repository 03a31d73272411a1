//! Flocks with broken clips.
//!
//! Owns the ways to break a clip, and the kind of fault that each is.
//!
//! Start at [`BROKEN`] and [`broken_flock`].

use crate::clips::Encode;
use crate::flocks::{Flock, Plan};
use crate::programs::{claims_folder, output};
use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

/// A sound flock with clips to break.
pub const SOUND: Plan = Plan { name: "sound", size: (640, 480), fps: (30, 1), sheep: 6, frames: 12 };

/// Breaks the clip at a path.
pub type Break = fn(&Path);

/// Every kind of damage, the clip that has it, and the kind of fault that `dreams check` reports. The damaged
/// transitions are the chords of the ring: the walk reaches all of them again and again.
pub const BROKEN: [(&str, &str, &str, Break); 9] = [
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
pub fn broken_flock(done: &[&str], hashed: bool) -> (tempfile::TempDir, Flock) {
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

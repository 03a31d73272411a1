//! Bad clips: refused with the cause, or played as far as they go and told of, and never to the harm of the next clip.

use crate::clips::{SIZE, clip, form, framemd5, hash, made, play};
use std::fs;
use std::num::NonZero;
use std::path::{Path, PathBuf};
use tempfile::TempDir;
use timing::{FrameCount, Rate};
use video::{Clip, ClipError, Damage, Form, Poll, ProbeError, Session, decode_whole, probe};

const FRAMES: FrameCount = FrameCount(30);
const HOW: &str = "-preset fast -crf 18 -g 10";

fn refusal(path: &Path) -> ClipError {
    Clip::open(path, &form(), FRAMES).err().expect("a bad clip is refused")
}

/// The probe's error, which [`Clip::open`] must give too.
fn unprobed(path: &Path) -> ProbeError {
    let error = probe(path).unwrap_err();
    assert_eq!(refusal(path).to_string(), error.to_string());
    assert!(error.to_string().contains(&format!("`{}`", path.display())), "{error} names the path");
    error
}

/// A good clip with three bytes changed in the middle of its slice data.
fn flipped(folder: &Path) -> PathBuf {
    let path = clip(folder, "flipped.mp4", FRAMES.0, HOW);
    let mut bytes = fs::read(&path).unwrap();
    let data = bytes.windows(4).position(|name| name == b"mdat").unwrap();
    let place = data + (bytes.len() - data) / 2;
    for byte in &mut bytes[place..place + 3] {
        *byte ^= 0xff;
    }
    fs::write(&path, bytes).unwrap();
    path
}

#[test]
fn what_is_no_whole_video_is_refused_with_its_cause() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    assert!(matches!(unprobed(&at("missing.mp4")), ProbeError::Open { .. }));
    assert!(matches!(unprobed(folder.path()), ProbeError::NotAFile { found: "folder", .. }));
    fs::write(at("empty.mp4"), []).unwrap();
    assert!(matches!(unprobed(&at("empty.mp4")), ProbeError::Empty { .. }));
    fs::write(at("text.mp4"), "no video at all, just some words in a file").unwrap();
    assert!(matches!(unprobed(&at("text.mp4")), ProbeError::NotAVideo { .. }));
    // A link to itself cannot be read by anybody, root included.
    std::os::unix::fs::symlink(at("loop.mp4"), at("loop.mp4")).unwrap();
    assert!(matches!(unprobed(&at("loop.mp4")), ProbeError::Open { .. }));
    let whole = clip(folder.path(), "whole.mp4", FRAMES.0, HOW);
    let bytes = fs::read(whole).unwrap();
    fs::write(at("half.mp4"), &bytes[..bytes.len() / 2]).unwrap();
    let error = unprobed(&at("half.mp4"));
    let cut = format!("is cut short: {} bytes (expected at least ", bytes.len() / 2);
    assert!(error.to_string().contains(&cut), "{error}");
}

/// A damaged count makes ffmpeg ask for more memory than there is, which no later attempt would get.
#[test]
fn no_flipped_bit_in_the_index_looks_like_a_machine_that_is_short_of_memory() {
    let folder = TempDir::new().unwrap();
    let path = clip(folder.path(), "whole.mp4", 12, HOW);
    let whole = fs::read(&path).unwrap();
    let name = whole.windows(4).position(|name| name == b"moov").unwrap();
    let bytes = u32::from_be_bytes(whole[name - 4..name].try_into().unwrap()) as usize;
    let (mut refused, mut counts) = (0, 0);
    for bit in 0..8 * bytes {
        let (at, mut damaged) = (name - 4 + bit / 8, whole.clone());
        damaged[at] ^= 1 << (bit % 8);
        fs::write(&path, &damaged).unwrap();
        if let Err(error) = Clip::open(&path, &form(), FrameCount(12)) {
            assert!(!error.is_shortage(), "bit {bit}: {error}");
            refused += 1;
            counts += u32::from(error.to_string().contains(" counts "));
        }
    }
    assert!(refused > counts && counts > 100, "{refused} refused, {counts} for a count");
}

#[test]
fn what_is_not_in_the_form_is_refused_with_both_values() {
    let folder = TempDir::new().unwrap();
    let good = |name, how: &str| clip(folder.path(), name, 12, how);
    let source = "testsrc2=size=128x100:rate=30";
    let with = |path: &Path, text: &str, form: &Form, frames: u32| {
        let told = Clip::open(path, form, FrameCount(frames)).err().map(|error| error.to_string());
        let told = told.unwrap_or_default();
        assert!(told.contains(text) && told.contains(&format!("`{}`", path.display())), "`{told}` says `{text}`");
        let full = probe(path).unwrap().differences(form, FrameCount(frames));
        assert!(full.iter().any(|difference| difference.to_string() == text), "{full:?} has `{text}`");
    };
    let wide = Form { size: (256, 100), ..form() };
    let film = Form { fps: Rate::new(24_000, 1_001).unwrap(), ..form() };
    let plain = good("plain.mp4", "");
    with(&plain, "size is `128x100` (expected `256x100`)", &wide, 12);
    with(&plain, "frame rate is `30` (expected `24000/1001`)", &film, 12);
    with(&plain, "frame count is `12` (expected `13`)", &form(), 13);
    let mpeg4 = made(folder.path(), "mpeg4.mp4", source, 12, "-c:v mpeg4");
    with(&mpeg4, "codec is `mpeg4` (expected `h264`)", &form(), 12);
    let untold = made(folder.path(), "untold.mp4", source, 12, "-c:v libx264 -pix_fmt yuv420p");
    with(&untold, "colour is `untold untold untold limited` (expected `bt709 bt709 bt709 limited`)", &form(), 12);
    with(&untold, "parameter sets in band is `no` (expected `yes`)", &form(), 12);
    let full = good("full.mp4", "-color_range pc");
    with(&full, "colour is `bt709 bt709 bt709 full` (expected `bt709 bt709 bt709 limited`)", &form(), 12);
    let deep = good("deep.mp4", "-pix_fmt yuv420p10le");
    with(&deep, "pixel format is `4:2:0 10 bit` (expected `yuv420p`)", &form(), 12);
    with(&deep, "profile is `profile 110` (expected `High`)", &form(), 12);
    let interlaced = good("interlaced.mp4", "-flags +ilme+ildct");
    with(&interlaced, "progressive is `no` (expected `yes`)", &form(), 12);
    let oblong = good("oblong.mp4", "-aspect 16/9");
    with(&oblong, "square pixels is `no` (expected `yes`)", &form(), 12);
    let uneven = good("uneven.mp4", "-vf setpts=N*N*0.01/TB -vsync vfr");
    with(&uneven, "frame rate is `uneven` (expected `30`)", &form(), 12);
}

#[test]
fn a_clip_of_one_frame_is_in_the_form_and_plays() {
    let folder = TempDir::new().unwrap();
    let one = clip(folder.path(), "one.mp4", 1, HOW);
    let good = clip(folder.path(), "good.mp4", FRAMES.0, HOW);
    assert_eq!(probe(&one).unwrap().differences(&form(), FrameCount(1)), []);
    assert_eq!(decode_whole(&one, NonZero::<usize>::MIN), Ok(FrameCount(1)));
    let still = || Clip::open(&one, &form(), FrameCount(1)).unwrap();
    let played = play([still(), still(), Clip::open(&good, &form(), FRAMES).unwrap(), still()], 2);
    for (clip, path) in [(0, &one), (1, &one), (2, &good), (3, &one)] {
        assert_eq!(played.hashes(clip), framemd5(path), "clip {clip}");
        assert_eq!(played.ends[clip as usize].2, [], "clip {clip}");
    }
}

#[test]
fn an_open_gop_is_told_by_the_probe() {
    let folder = TempDir::new().unwrap();
    let how = "-g 10 -bf 3 -x264-params repeat-headers=1:open-gop=1";
    let open = probe(&clip(folder.path(), "open.mp4", 40, how)).unwrap().differences(&form(), FrameCount(40));
    assert_eq!(open.iter().map(ToString::to_string).collect::<Vec<_>>(), ["closed GOP is `no` (expected `yes`)"]);
}

#[test]
fn a_flipped_byte_is_told_and_the_clips_around_it_are_unharmed() {
    let folder = TempDir::new().unwrap();
    let (bad, good) = (flipped(folder.path()), clip(folder.path(), "good.mp4", FRAMES.0, "-preset slow -bf 4"));
    assert!(decode_whole(&bad, NonZero::<usize>::MIN).is_err());
    let expected = framemd5(&good);
    for threads in [1, 2, 4] {
        let clips = [&good, &bad, &good, &bad, &bad, &good].map(|path| Clip::open(path, &form(), FRAMES).unwrap());
        let played = play(clips, threads);
        for (clip, frames, damage) in &played.ends {
            let is_good = [0, 2, 5].contains(&clip.0);
            assert_eq!(damage.is_empty(), is_good, "{threads} threads, clip {}: {damage:?}", clip.0);
            assert!(!is_good || *frames == FRAMES && played.hashes(clip.0) == expected, "clip {}", clip.0);
        }
        assert_eq!(played.ends.len(), 6);
    }
}

#[test]
fn a_clip_cut_short_while_it_waits_ends_early_and_the_next_one_plays() {
    let folder = TempDir::new().unwrap();
    let good = clip(folder.path(), "good.mp4", FRAMES.0, "-preset medium -bf 2");
    let expected = framemd5(&good);
    for threads in [1, 3] {
        let bad = clip(folder.path(), "cut.mp4", FRAMES.0, HOW);
        let open = |path: &Path| Clip::open(path, &form(), FRAMES).unwrap();
        let clips = [open(&good), open(&bad), open(&good)];
        let bytes = fs::metadata(&bad).unwrap().len();
        fs::OpenOptions::new().write(true).open(&bad).unwrap().set_len(bytes * 2 / 3).unwrap();
        let played = play(clips, threads);
        assert_eq!(played.ends.len(), 3);
        let (_, frames, damage) = &played.ends[1];
        assert!(frames.0 < FRAMES.0 && frames.0 > 5, "{threads} threads: {} frames", frames.0);
        let too_few = Damage::TooFew { expected: FRAMES, found: *frames };
        assert_eq!(damage.last(), Some(&too_few), "{threads} threads: {damage:?}");
        for clip in [0, 2] {
            assert_eq!(played.hashes(clip), expected, "{threads} threads, clip {clip}");
        }
    }
}

#[test]
fn a_clip_of_noise_under_a_good_header_never_stalls_the_session() {
    let folder = TempDir::new().unwrap();
    let good = clip(folder.path(), "good.mp4", FRAMES.0, "-preset medium -bf 2");
    let noise = clip(folder.path(), "noise.mp4", FRAMES.0, HOW);
    let mut bytes = fs::read(&noise).unwrap();
    // Noise from behind the first access unit's parameter sets and the header of its first slice.
    let idr = bytes.windows(2).position(|header| header == [0x65, 0x88]).unwrap();
    let data = idr + 64;
    let mut state = 1u32;
    for byte in &mut bytes[data..] {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        *byte = (state >> 24) as u8;
    }
    fs::write(&noise, bytes).unwrap();
    for threads in [1, 2, 5] {
        let clips = [&good, &noise, &noise, &good].map(|path| Clip::open(path, &form(), FRAMES).unwrap());
        let played = play(clips, threads);
        assert_eq!(played.ends.len(), 4);
        assert!(!played.ends[1].2.is_empty() && !played.ends[2].2.is_empty());
        assert_eq!(played.hashes(0), framemd5(&good), "{threads} threads");
        assert_eq!(played.hashes(3), framemd5(&good), "{threads} threads");
        assert!(played.ends[3].2.is_empty(), "{threads} threads: {:?}", played.ends[3].2);
    }
}

#[test]
fn frames_outlive_their_session_and_cross_threads() {
    let folder = TempDir::new().unwrap();
    let path = clip(folder.path(), "good.mp4", FRAMES.0, "");
    let mut session = Session::new(NonZero::<usize>::MIN).unwrap();
    session.push(Clip::open(&path, &form(), FRAMES).unwrap());
    session.finish();
    let frames = std::thread::spawn(move || {
        let mut frames = Vec::new();
        while let Poll::Frame(frame) = session.poll() {
            frames.push(frame);
        }
        frames
    });
    let frames = frames.join().unwrap();
    assert_eq!(frames.iter().map(hash).collect::<Vec<_>>(), framemd5(&path));
    assert!(frames.iter().all(|frame| frame.size() == SIZE && !frame.is_damaged()));
    assert_eq!(frames.iter().position(video::Frame::last), Some(frames.len() - 1));
}

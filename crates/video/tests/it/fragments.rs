//! Copies of clips for browsers: what a browser gets shows the frames of the clip, and each at its place.
//!
//! Owns a reader of fragmented MP4 that trusts none of ffmpeg's arithmetic: it adds up the tables itself, as a browser does.

use crate::clips::{SIZE, clip, form, framemd5};
use std::collections::BTreeSet;
use std::fs;
use std::num::NonZero;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;
use timing::{FrameCount, Rate};
use video::{Encoder, Form, FragmentError, Quality, Tuning, Yuv420p, fragment, packets};

/// The samples of a fragmented file.
#[derive(Debug, Default)]
struct Samples {
    /// Ticks in a second.
    scale: u32,
    /// When each is shown, in ticks, in decoding order.
    shown: Vec<i64>,
    /// How long each lasts.
    lasts: Vec<u32>,
    /// The decoding time of each fragment, as it is told and as the durations before it add up.
    starts: Vec<(u64, u64)>,
    /// Whether there is an edit list.
    is_edited: bool,
}

/// How many frames an encoder without delay may hold back.
const LAG: u32 = 1;

fn number(bytes: &[u8], at: usize) -> u32 {
    u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap())
}

/// Reads the boxes in `bytes`, those inside others too, into `samples`. `usual` is what `tfhd` told of all samples.
fn read(mut bytes: &[u8], samples: &mut Samples, usual: &mut u32) {
    while bytes.len() >= 8 {
        let (length, kind) = (number(bytes, 0) as usize, &bytes[4..8]);
        let inside = &bytes[8..length.min(bytes.len())];
        match kind {
            b"moov" | b"trak" | b"mdia" | b"moof" | b"traf" | b"edts" => read(inside, samples, usual),
            b"elst" => samples.is_edited = true,
            b"mdhd" => samples.scale = number(inside, if inside[0] == 0 { 12 } else { 20 }),
            b"tfhd" => {
                let flags = number(inside, 0) & 0x00ff_ffff;
                assert_eq!(flags & 0x2_0009, 0x2_0008, "default-base-is-moof, no base offset, a usual duration");
                *usual = number(inside, 8);
            }
            b"tfdt" => {
                assert_eq!(inside[0], 1);
                let told = u64::from_be_bytes(inside[4..12].try_into().unwrap());
                samples.starts.push((told, samples.lasts.iter().copied().map(u64::from).sum()));
            }
            b"trun" => runs(inside, samples, *usual),
            _ => (),
        }
        bytes = &bytes[length.min(bytes.len())..];
    }
}

fn runs(run: &[u8], samples: &mut Samples, usual: u32) {
    let (flags, count) = (number(run, 0) & 0x00ff_ffff, number(run, 4));
    assert!(run[0] == 1, "offsets have a sign");
    let mut at = 8 + 4 * [0x1, 0x4].into_iter().filter(|flag| flags & flag != 0).count();
    for _ in 0..count {
        let mut field = |flag: u32| {
            let found = (flags & flag != 0).then(|| number(run, at));
            at += 4 * usize::from(found.is_some());
            found
        };
        let (lasts, _, _, offset) = (field(0x100).unwrap_or(usual), field(0x200), field(0x400), field(0x800));
        let decoded: i64 = samples.lasts.iter().copied().map(i64::from).sum();
        samples.shown.push(decoded + i64::from(offset.unwrap_or(0).cast_signed()));
        samples.lasts.push(lasts);
    }
}

/// Checks that the fragmented file at `path` fills `frames` frames of `rate` from 0, without a hole. Returns the number of its
/// fragments.
fn check(path: &Path, frames: u32, rate: Rate) -> usize {
    let mut samples = Samples::default();
    read(&fs::read(path).unwrap(), &mut samples, &mut 0);
    let step = i64::from(samples.scale) * i64::from(rate.den()) / i64::from(rate.num());
    assert_eq!(step * i64::from(rate.num()), i64::from(samples.scale) * i64::from(rate.den()), "whole ticks");
    let places: BTreeSet<i64> = samples.shown.iter().copied().collect();
    assert_eq!(places, (0..i64::from(frames)).map(|frame| frame * step).collect());
    assert_eq!(samples.shown.len(), frames as usize);
    assert!(samples.lasts.iter().all(|lasts| i64::from(*lasts) == step), "{:?}", samples.lasts);
    assert!(samples.starts.iter().all(|(told, added)| told == added), "{:?}", samples.starts);
    assert!(!samples.is_edited);
    samples.starts.len()
}

#[test]
fn a_fragmented_copy_fills_exactly_its_frames_whatever_is_reordered() {
    let folder = TempDir::new().unwrap();
    let copy = folder.path().join("copy.mp4");
    for (frames, settings, fragments) in
        [(61, "-bf 3 -b_strategy 0", 1), (48, "-g 12 -bf 2 -flags +cgop", 4), (30, "-bf 0", 1), (1, "", 1)]
    {
        let path = clip(folder.path(), "clip.mp4", frames, settings);
        let told = fragment(&path, &copy).unwrap();
        assert_eq!(told.frames, FrameCount(frames));
        assert!(told.codec.starts_with("avc1.6400"), "{}", told.codec);
        assert_eq!(check(&copy, frames, form().fps), fragments, "{settings}");
        assert_eq!(framemd5(&copy), framemd5(&path), "{settings}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "nothing else is left");
    }
}

#[test]
fn a_copy_of_our_own_clips_keeps_any_rate_exact() {
    let folder = TempDir::new().unwrap();
    let (path, copy) = (folder.path().join("clip.mp4"), folder.path().join("copy.mp4"));
    for (num, den) in [(30, 1), (24_000, 1_001), (20, 1), (25, 2), (120, 1)] {
        let form = Form { fps: Rate::new(num, den).unwrap(), ..form() };
        let mut encoder = Encoder::create(&path, &form, quality("medium")).unwrap();
        (0..31).for_each(|frame| encoder.push(&picture(frame)).unwrap());
        encoder.finish().unwrap();
        fragment(&path, &copy).unwrap();
        check(&copy, 31, form.fps);
    }
}

#[test]
fn what_is_no_whole_clip_leaves_the_copy_that_was_there() {
    let folder = TempDir::new().unwrap();
    let (path, copy) = (clip(folder.path(), "clip.mp4", 9, "-bf 2"), folder.path().join("copy.mp4"));
    fs::write(&copy, "before").unwrap();
    let whole = fs::read(&path).unwrap();
    fs::write(&path, &whole[..whole.len() - 40]).unwrap();
    assert!(matches!(fragment(&path, &copy), Err(FragmentError::Probe(_))));
    fs::write(&path, "no clip").unwrap();
    assert!(matches!(fragment(&path, &copy), Err(FragmentError::Probe(_))));
    assert_eq!(fs::read(&copy).unwrap(), b"before");
    fs::write(&path, whole).unwrap();
    let nowhere = fragment(&path, &folder.path().join("no/copy.mp4")).unwrap_err();
    assert!(matches!(nowhere, FragmentError::Write { .. }), "{nowhere}");
}

#[test]
fn a_decoder_outside_shows_the_frames_of_excerpts_in_a_row_bit_for_bit() {
    let folder = TempDir::new().unwrap();
    let clips = [
        (clip(folder.path(), "a.mp4", 60, "-bf 3 -b_strategy 0 -g 25 -flags +cgop"), 48..60),
        (clip(folder.path(), "b.mp4", 40, "-bf 2"), 0..12),
        (clip(folder.path(), "c.mp4", 31, "-bf 0"), 9..11),
        (clip(folder.path(), "d.mp4", 20, "-bf 3"), 0..99),
    ];
    let (mut stream, mut expected) = (Vec::new(), Vec::new());
    let (mut shown, mut before) = (Vec::new(), 0);
    for (path, part) in &clips {
        let found = packets(path, part.clone()).unwrap();
        assert_eq!(found.packets.iter().map(|packet| packet.bytes).sum::<usize>(), found.bytes.len());
        assert!(found.packets[0].is_key && found.packets[0].frame <= part.start);
        assert_eq!(found.size, SIZE);
        let mut frames: Vec<_> = found.packets.iter().map(|packet| (packet.frame, packet.is_shown)).collect();
        frames.sort_unstable();
        frames.dedup();
        assert_eq!(frames.len(), found.packets.len());
        shown.extend((before..).zip(&frames).filter(|(_, (_, is_shown))| *is_shown).map(|(at, _)| at));
        before += frames.len();
        let all = framemd5(path);
        expected.extend(all[part.start as usize..all.len().min(part.end as usize)].to_vec());
        stream.extend(start_codes(&found.bytes));
    }
    let path = folder.path().join("stream.h264");
    fs::write(&path, stream).unwrap();
    let decoded = framemd5(&path);
    assert_eq!(decoded.len(), before);
    assert_eq!(shown.iter().map(|at| decoded[*at].clone()).collect::<Vec<_>>(), expected);
}

#[test]
fn a_packets_place_counts_those_that_an_excerpt_leaves_out() {
    let folder = TempDir::new().unwrap();
    let path = clip(
        folder.path(),
        "a.mp4",
        60,
        "-bf 2 -b_strategy 0 -g 20 -flags +cgop -x264-params repeat-headers=1:b-pyramid=none",
    );
    let whole = packets(&path, 0..60).unwrap();
    assert_eq!(whole.packets.iter().map(|packet| packet.place).collect::<Vec<_>>(), (0..60).collect::<Vec<_>>());
    let some = packets(&path, 50..52).unwrap();
    let key = whole.packets.iter().rfind(|packet| packet.is_key && packet.frame <= 50).unwrap();
    assert_eq!((some.packets[0].place, some.packets[0].frame), (key.frame, key.frame));
    assert!(some.packets.len() < 51 - key.frame as usize, "{:?}", some.packets);
    let same = |packet: &&video::ClipPacket| whole.packets[packet.place as usize].frame == packet.frame;
    assert_eq!(some.packets.iter().filter(same).count(), some.packets.len());
    assert_eq!(some.packets.iter().filter(|packet| packet.is_shown).count(), 2);
}

#[test]
fn a_growing_clip_is_read_to_its_last_whole_group_while_it_is_written() {
    let folder = TempDir::new().unwrap();
    let (path, part) = (folder.path().join("clip.mp4"), folder.path().join("clip.mp4.part"));
    let mut encoder = Encoder::create_growing(&path, &form(), quality("veryfast"), NonZero::new(6).unwrap()).unwrap();
    for frame in 0..20 {
        encoder.push(&picture(frame)).unwrap();
        let mut samples = Samples::default();
        read(&fs::read(&part).unwrap(), &mut samples, &mut 0);
        let least = frame.saturating_sub(LAG) / 6 * 6;
        assert!((least..=frame).contains(&(samples.shown.len() as u32)), "{} after {frame}", samples.shown.len());
    }
    let so_far = fs::read(&part).unwrap();
    assert_eq!(encoder.finish().unwrap(), FrameCount(20));
    assert!(fs::read(&path).unwrap().starts_with(&so_far), "what was read stays true");
    assert_eq!(check(&path, 20, form().fps), 4);
    assert_eq!(framemd5(&path).len(), 20);
    let probed = Command::new("ffprobe")
        .args(["-v", "error", "-show_entries", "stream=profile,pix_fmt,color_space", "-of", "csv=p=0"])
        .arg(&path)
        .output()
        .unwrap();
    assert_eq!(String::from_utf8(probed.stdout).unwrap().trim(), "High,yuv420p,bt709");
}

/// Packets with lengths before their units as a stream with start codes.
fn start_codes(mut bytes: &[u8]) -> Vec<u8> {
    let mut stream = Vec::new();
    while !bytes.is_empty() {
        let end = 4 + number(bytes, 0) as usize;
        stream.extend([0, 0, 0, 1]);
        stream.extend(&bytes[4..end]);
        bytes = &bytes[end..];
    }
    stream
}

fn quality(preset: &str) -> Quality<'_> {
    Quality { crf: 22.0, preset, tuning: Tuning::Gradients, max_bits_per_second: None }
}

fn picture(frame: u32) -> Yuv420p {
    let (width, height) = SIZE;
    let level = |x: u32, y: u32| [500 * x + 900 * frame, 500 * y, 300 * (x + y)].map(|level| (level % 65536) as u16);
    let rgb: Vec<u16> = (0..height).flat_map(|y| (0..width).flat_map(move |x| level(x, y))).collect();
    Yuv420p::from_rgb16_dithered(width, height, &rgb).unwrap()
}

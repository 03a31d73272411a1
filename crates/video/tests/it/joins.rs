//! Every frame of every clip, once, in order, bit for bit, whatever made the clips.

use crate::clips::{clip, form, framemd5, play};
use std::path::PathBuf;
use tempfile::TempDir;
use timing::FrameCount;
use video::{Clip, decode_whole};

/// Names, lengths and encoder settings that differ in everything a decoder keeps between pictures.
const KINDS: [(&str, u32, &str); 9] = [
    ("b-pyramid.mp4", 31, "-preset medium -bf 3 -refs 5 -crf 20"),
    ("no-b.mp4", 17, "-preset veryfast -bf 0 -crf 30"),
    ("cavlc.mp4", 13, "-preset ultrafast -crf 26"),
    ("slices.mp4", 16, "-preset fast -x264-params repeat-headers=1:slices=4:cabac=0 -crf 23"),
    ("many-refs.mp4", 29, "-preset slow -refs 12 -bf 8 -b_strategy 2 -crf 16"),
    ("main.mp4", 11, "-profile:v main -preset fast -bf 1 -crf 33"),
    ("short-gop.mp4", 37, "-g 5 -preset fast -bf 2 -crf 22"),
    ("one-b.mp4", 2, "-preset medium -bf 1"),
    ("lossy.mp4", 24, "-preset placebo -crf 48 -x264-params repeat-headers=1:weightp=2:b-adapt=2:rc-lookahead=10"),
];

/// A, B, A, C, B, D, ...: every kind after several others, and twice in a row.
fn tour() -> Vec<usize> {
    let there = (0..KINDS.len()).flat_map(|kind| [kind, (kind + 1) % KINDS.len(), kind]);
    there.chain((0..KINDS.len()).rev()).collect()
}

#[test]
fn every_frame_of_every_clip_comes_once_in_order_and_bit_exact() {
    let folder = TempDir::new().unwrap();
    let made: Vec<PathBuf> = KINDS.iter().map(|(name, frames, how)| clip(folder.path(), name, *frames, how)).collect();
    let hashes: Vec<Vec<String>> = made.iter().map(|path| framemd5(path)).collect();
    let expected: Vec<&String> = tour().iter().flat_map(|kind| &hashes[*kind]).collect();
    for threads in [1, 2, 3, 5] {
        let open = |kind: &usize| Clip::open(&made[*kind], &form(), FrameCount(KINDS[*kind].1)).unwrap();
        let played = play(tour().iter().map(open).collect::<Vec<_>>(), threads);
        let found: Vec<&String> = played.frames.iter().map(|frame| &frame.2).collect();
        assert!(found == expected, "{threads} threads: {} frames (expected {})", found.len(), expected.len());
        for ((clip, frames, damage), kind) in played.ends.iter().zip(tour()) {
            assert_eq!(*damage, [], "{threads} threads, clip {} ({})", clip.0, KINDS[kind].0);
            assert_eq!(frames.0, KINDS[kind].1, "{}", KINDS[kind].0);
        }
        assert_eq!(played.ends.len(), tour().len());
    }
}

#[test]
fn an_excerpt_shows_just_its_frames_whatever_stands_before_and_after_it() {
    let folder = TempDir::new().unwrap();
    let made: Vec<PathBuf> = KINDS.iter().map(|(name, frames, how)| clip(folder.path(), name, *frames, how)).collect();
    let hashes: Vec<Vec<String>> = made.iter().map(|path| framemd5(path)).collect();
    // Tails and heads as at a join, middles, single frames; the last clip's keyframes are five frames apart.
    let part = |frames: u32| [(frames - 1, frames), (0, 2), (frames / 2, frames / 2 + 1), (2, frames + 9), (0, frames)];
    let whole = (0..KINDS.len()).flat_map(|kind| part(KINDS[kind].1).map(|(from, to)| (kind, from..to)));
    let short_gop = (0..37).map(|from| (6, from..from + 3));
    let parts: Vec<(usize, std::ops::Range<u32>)> = whole.chain(short_gop).collect();
    let open = |(kind, part): &(usize, std::ops::Range<u32>)| {
        Clip::open(&made[*kind], &form(), FrameCount(KINDS[*kind].1)).unwrap().excerpt(part.clone())
    };
    for threads in [1, 3] {
        let played = play(parts.iter().map(open).collect::<Vec<_>>(), threads);
        for (number, (kind, part)) in parts.iter().enumerate() {
            let end = (part.end as usize).min(hashes[*kind].len());
            let due = hashes[*kind].get(part.start as usize..end).unwrap_or_default();
            let name = KINDS[*kind].0;
            assert_eq!(played.hashes(number as u64), due, "{threads} threads, frames {part:?} of {name}");
            assert_eq!(played.ends[number].2, [], "{threads} threads, frames {part:?} of {name}");
        }
    }
}

#[test]
fn whole_clips_decode_cleanly() {
    let folder = TempDir::new().unwrap();
    for (name, frames, how) in KINDS {
        let path = clip(folder.path(), name, frames, how);
        for threads in [1, 3] {
            assert_eq!(decode_whole(&path, std::num::NonZero::new(threads).unwrap()), Ok(FrameCount(frames)), "{name}");
        }
    }
}

#[test]
fn frames_that_are_chosen_are_those_of_the_whole_clip_bit_for_bit() {
    let folder = TempDir::new().unwrap();
    for (name, frames, how) in KINDS {
        let path = clip(folder.path(), name, frames, how);
        let all = framemd5(&path);
        for chosen in [vec![0, 1], vec![frames - 1], (0..frames).step_by(5).collect(), vec![7, 3, 3, frames + 1]] {
            let open = || Clip::open(&path, &form(), FrameCount(frames)).unwrap().selection(&chosen);
            let mut expected: Vec<u32> = chosen.iter().copied().filter(|frame| *frame < frames).collect();
            expected.sort_unstable();
            expected.dedup();
            // Twice in a row: what one leaves out must not harm the next.
            let played = play([open(), open()], 1);
            for clip in [0, 1] {
                let expected: Vec<_> = expected.iter().map(|frame| all[*frame as usize].clone()).collect();
                assert_eq!(played.hashes(clip), expected, "{name} {chosen:?}");
                assert_eq!(played.ends[clip as usize].2, [], "{name} {chosen:?}");
            }
        }
    }
}

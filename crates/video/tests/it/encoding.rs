//! Clips that we make ourselves: exactly the pictures pushed, exactly the form, whole or not there at all.

use crate::clips::{SIZE, form, framemd5, play};
use std::fs;
use std::num::NonZero;
use tempfile::TempDir;
use timing::{FrameCount, Rate};
use video::{
    Clip, EncodeError, Encoder, Form, Poll, Quality, Session, SessionError, Tuning, Yuv420p, decode_whole, probe,
};

/// Nearly every sample is kept, so that what comes out can be compared with what went in.
const FAITHFUL: Quality<'_> = Quality { crf: 1.0, preset: "fast", tuning: Tuning::Film, max_bits_per_second: None };
const GOOD: Quality<'_> =
    Quality { crf: 18.0, preset: "medium", tuning: Tuning::Film, max_bits_per_second: Some(2_000_000) };

fn picture(frame: u32) -> Yuv420p {
    let (width, height) = SIZE;
    let level = |x: u32, y: u32| [400 * x + 900 * frame, 500 * y, 300 * (x + y)].map(|level| (level % 65536) as u16);
    let rgb: Vec<u16> = (0..height).flat_map(|y| (0..width).flat_map(move |x| level(x, y))).collect();
    Yuv420p::from_rgb16_dithered(width, height, &rgb).unwrap()
}

#[test]
fn our_clips_are_in_the_form_at_every_rate_and_preset() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("ours.mp4");
    for (rate, preset, frames) in [((30, 1), "medium", 61), ((24_000, 1_001), "ultrafast", 13), ((25, 1), "slow", 300)]
    {
        let form = Form { fps: Rate::new(rate.0, rate.1).unwrap(), ..form() };
        let mut encoder = Encoder::create(&path, &form, Quality { preset, ..GOOD }).unwrap();
        for frame in 0..frames {
            encoder.push(&picture(frame)).unwrap();
        }
        assert_eq!(encoder.finish().unwrap(), FrameCount(frames));
        let probed = probe(&path).unwrap();
        assert_eq!(probed.differences(&form, FrameCount(frames)), [], "{preset}");
        assert_eq!(
            (probed.profile.as_str(), probed.colour.as_str()),
            ("High", "bt709 bt709 bt709 limited"),
            "{preset}"
        );
        assert_eq!(decode_whole(&path, NonZero::<usize>::MIN), Ok(FrameCount(frames)), "{preset}");
        let played = play([Clip::open(&path, &form, FrameCount(frames)).unwrap()], 2);
        assert_eq!(played.hashes(0), framemd5(&path), "{preset}");
    }
}

#[test]
fn a_rate_comes_out_exactly_or_is_refused_before_the_first_frame() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("odd.mp4");
    let with = |num, den| Form { fps: Rate::new(num, den).unwrap(), ..form() };
    for (num, den) in [(999_999_937, 33_333_331), (240, 1), (1, 1), (1_000_000_000, 999_999_999)] {
        let form = with(num, den);
        let mut encoder = Encoder::create(&path, &form, GOOD).unwrap();
        (0..5).for_each(|frame| encoder.push(&picture(frame)).unwrap());
        assert_eq!(encoder.finish().unwrap(), FrameCount(5));
        assert_eq!(probe(&path).unwrap().differences(&form, FrameCount(5)), [], "{num}/{den}");
        fs::remove_file(&path).unwrap();
    }
    for (num, den) in [(4_294_967_291, 143_165_577), (4_294_967_291, 4_294_967_290)] {
        let refused = Encoder::create(&path, &with(num, den), GOOD).err().unwrap();
        assert!(matches!(refused, EncodeError::Rate { .. }), "{refused}");
        assert!(refused.to_string().contains(&format!("{num}/{den}")), "{refused}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn the_same_pictures_make_the_same_file() {
    let folder = TempDir::new().unwrap();
    let made = ["a.mp4", "b.mp4"].map(|name| {
        let path = folder.path().join(name);
        let mut encoder = Encoder::create(&path, &form(), GOOD).unwrap();
        (0..40).for_each(|frame| encoder.push(&picture(frame)).unwrap());
        encoder.finish().unwrap();
        fs::read(path).unwrap()
    });
    assert!(made[0] == made[1]);
}

#[test]
fn what_was_pushed_comes_out_again() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("faithful.mp4");
    let mut encoder = Encoder::create(&path, &form(), FAITHFUL).unwrap();
    (0..10).for_each(|frame| encoder.push(&picture(frame)).unwrap());
    encoder.finish().unwrap();
    let mut session = Session::new(NonZero::<usize>::MIN).unwrap();
    session.push(Clip::open(&path, &form(), FrameCount(10)).unwrap());
    session.finish();
    let mut count = 0;
    while let Poll::Frame(frame) = session.poll() {
        let (before, after) = (picture(frame.in_clip()), Yuv420p::from(&frame));
        for (before, after) in before.planes().into_iter().zip(after.planes()) {
            let worst = before.iter().zip(after).map(|(a, b)| a.abs_diff(*b)).max();
            assert!(worst <= Some(3), "frame {count}: {worst:?}");
        }
        count += 1;
    }
    assert_eq!(count, 10);
}

#[test]
fn frames_tell_how_coarsely_they_are_encoded_when_asked() {
    let folder = TempDir::new().unwrap();
    let mean = |crf: f32, open: fn(NonZero<usize>) -> Result<Session, SessionError>| {
        let path = folder.path().join("coarse.mp4");
        let mut encoder = Encoder::create(&path, &form(), Quality { crf, ..GOOD }).unwrap();
        (0..10).for_each(|frame| encoder.push(&picture(frame)).unwrap());
        encoder.finish().unwrap();
        let mut session = open(NonZero::<usize>::MIN).unwrap();
        session.push(Clip::open(&path, &form(), FrameCount(10)).unwrap());
        session.finish();
        let mut quantisers = Vec::new();
        while let Poll::Frame(frame) = session.poll() {
            quantisers.push(frame.quantiser());
        }
        assert_eq!(quantisers.len(), 10);
        quantisers.into_iter().sum::<Option<f32>>().map(|sum| sum / 10.0)
    };
    let [fine, coarse] = [20.0, 40.0].map(|crf| mean(crf, Session::with_quantisers).unwrap());
    assert!((0.0..=51.0).contains(&fine) && coarse > fine + 10.0 && coarse <= 51.0, "{fine} {coarse}");
    assert_eq!(mean(20.0, Session::new), None);
}

/// Blocks of 8x8 pixels of one colour, in the luma of clips that show a dark gradient moving, at this rate factor.
fn blocks_of_one_colour(tuning: Tuning, crf: f32) -> usize {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("dark.mp4");
    let (width, height) = SIZE;
    // Two steps of 255 from edge to edge: what hides them is the dither alone.
    let level = |x: u32, y: u32, frame: u32| (257.0 * (12.0 + f64::from(x + y + frame) / 100.0)) as u16;
    let picture = |frame| {
        let pixel = |x, y| [level(x, y, frame); 3];
        let rgb: Vec<u16> = (0..height).flat_map(|y| (0..width).flat_map(move |x| pixel(x, y))).collect();
        Yuv420p::from_rgb16_dithered(width, height, &rgb).unwrap()
    };
    let quality = Quality { crf, preset: "slower", tuning, max_bits_per_second: None };
    let mut encoder = Encoder::create(&path, &form(), quality).unwrap();
    (0..10).for_each(|frame| encoder.push(&picture(frame)).unwrap());
    encoder.finish().unwrap();
    let mut session = Session::new(NonZero::<usize>::MIN).unwrap();
    session.push(Clip::open(&path, &form(), FrameCount(10)).unwrap());
    session.finish();
    let mut blocks = 0;
    while let Poll::Frame(frame) = session.poll() {
        let picture = Yuv420p::from(&frame);
        let (luma, stride) = (picture.planes()[0], picture.strides()[0]);
        let is_flat = |x: usize, y: usize| {
            let rows = (y..y + 8).map(|y| &luma[y * stride + x..][..8]);
            rows.flatten().all(|level| *level == luma[y * stride + x])
        };
        let places = (0..height as usize / 8).flat_map(|y| (0..width as usize / 8).map(move |x| (8 * x, 8 * y)));
        blocks += places.filter(|(x, y)| is_flat(*x, *y)).count();
    }
    blocks
}

#[test]
fn dark_gradients_keep_their_dither_and_would_not_by_default() {
    let [film, ours] =
        [(Tuning::Film, 17.0), (Tuning::Gradients, 22.0)].map(|(tuning, crf)| blocks_of_one_colour(tuning, crf));
    assert!(ours * 2 < film, "{ours} blocks of one colour, {film} by default");
}

#[test]
fn an_unfinished_clip_leaves_the_old_one_and_nothing_else() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("clip.mp4");
    fs::write(&path, "the old one").unwrap();
    let mut encoder = Encoder::create(&path, &form(), GOOD).unwrap();
    encoder.push(&picture(0)).unwrap();
    assert!(folder.path().join("clip.mp4.part").exists());
    drop(encoder);
    assert_eq!(fs::read(&path).unwrap(), b"the old one");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn what_cannot_be_encoded_is_told_with_the_path_and_both_values() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("clip.mp4");
    let mut encoder = Encoder::create(&path, &form(), GOOD).unwrap();
    let small = Yuv420p::from_rgb16(2, 2, &[0; 12]).unwrap();
    let told = encoder.push(&small).unwrap_err().to_string();
    assert_eq!(told, format!("frame 0 of clip `{}` has 2x2 pixels (expected 128x100)", path.display()));
    let nowhere = Encoder::create(&folder.path().join("none/clip.mp4"), &form(), GOOD).err();
    assert!(matches!(nowhere, Some(EncodeError::Write { .. })));
    let lossless = Encoder::create(&path, &form(), Quality { crf: 0.0, ..GOOD }).err();
    assert!(matches!(lossless, Some(EncodeError::Factor { .. })), "{lossless:?}");
    let preset = Encoder::create(&path, &form(), Quality { preset: "hasty", ..GOOD }).err();
    assert!(preset.is_some_and(|error| error.to_string().contains("no preset `hasty` (expected one of ultrafast, ")));
}

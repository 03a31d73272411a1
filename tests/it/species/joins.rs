//! Whether frames in a row go on at a join, in value and in speed.
//!
//! Owns the criterion, on frames that nobody encoded: a frame differs from the mean of its neighbours by no more at a join
//! than it does around it. A frame that is missing or shown twice, another picture and another speed all differ by more.
//!
//! Start at [`severity`].

use species::{Image, Motion, Threads};

use super::sheep::{LOOP, picture};

/// Frames on either side of a join that are compared.
pub(crate) const FRAMES: usize = 8;
/// How many times as much as around it a frame at a join may differ from its neighbours' mean, and what is never seen, in
/// levels of 255.
const MOST_TIMES: f64 = 2.0;
const UNSEEN: f64 = 0.5;
/// Pixels along the side of a block.
const BLOCK: usize = 3;

/// How much a motion jumps at `frame`.
pub(crate) fn at(motion: &dyn Motion, frame: f64, threads: &Threads) -> f64 {
    let around = (0..2 * FRAMES).map(|at| frame.floor() + at as f64 - FRAMES as f64);
    severity(&around.map(|frame| picture(motion, frame, threads)).collect::<Vec<Image>>())
}

/// How much a join of a loop may jump: a join is as good as any other place of a loop that jerks by itself, be it only now
/// and then.
pub(crate) fn allowed(turning: &dyn Motion, threads: &Threads) -> f64 {
    let frames: Vec<Image> = (1..LOOP as usize).map(|frame| picture(turning, frame as f64, threads)).collect();
    frames.windows(2 * FRAMES).map(severity).fold(1.0, f64::max)
}

/// The join in the middle of `frames`, of which there are [`FRAMES`] before it and as many after: above 1 it jumps.
pub(crate) fn severity(frames: &[Image]) -> f64 {
    let views: Vec<Vec<f64>> = frames.iter().map(view).collect();
    let bends: Vec<f64> = views.windows(3).map(bend).collect();
    // The last frame before the join and the first after it, which have a neighbour beyond it.
    let (around, across) = ([&bends[..FRAMES - 2], &bends[FRAMES..]].concat(), &bends[FRAMES - 2..FRAMES]);
    let most = |bends: &[f64]| bends.iter().copied().fold(0.0, f64::max);
    most(across) / (MOST_TIMES * most(&around) + UNSEEN)
}

/// How far the second of three frames is from where it would be if motion were even: the root of the mean square.
fn bend(views: &[Vec<f64>]) -> f64 {
    let [before, now, after] = [&views[0], &views[1], &views[2]];
    let squares = before.iter().zip(now).zip(after).map(|((a, b), c)| (a - 2.0 * b + c) * (a - 2.0 * b + c));
    (squares.sum::<f64>() / now.len() as f64).sqrt()
}

/// The luma of blocks, in levels.
fn view(image: &Image) -> Vec<f64> {
    let luma = |pixel: &[f32; 3]| {
        255.0 * (0.2126 * f64::from(pixel[0]) + 0.7152 * f64::from(pixel[1]) + 0.0722 * f64::from(pixel[2]))
    };
    let columns = image.width / BLOCK;
    let mut blocks = vec![0.0; columns * (image.height / BLOCK)];
    for (at, pixel) in image.pixels.iter().enumerate() {
        blocks[at / image.width / BLOCK * columns + at % image.width / BLOCK] += luma(pixel) / (BLOCK * BLOCK) as f64;
    }
    blocks
}

/// A wave that runs through the picture, `pace` of a turn a frame.
fn wave(at: f64, pace: f64) -> Image {
    let light = |column: usize| 0.5 + 0.4 * (std::f64::consts::TAU * (column as f64 / 48.0 + at * pace)).sin();
    let pixels = (0..96 * 54).map(|pixel| [light(pixel % 96) as f32; 3]).collect();
    Image { width: 96, height: 54, pixels }
}

#[test]
fn breaks_that_are_planted_are_found_and_nothing_else_is() {
    let join = |before: f64, after: f64, first: f64| {
        let before = (1..=FRAMES).rev().map(|frame| wave(-(frame as f64), before));
        let after = (0..FRAMES).map(|frame| wave(first + frame as f64, after));
        severity(&before.chain(after).collect::<Vec<_>>())
    };
    for pace in [0.001, 0.003, 0.01] {
        assert!(join(pace, pace, 0.0) < 0.6, "{pace}: nothing is broken");
    }
    for pace in [0.005, 0.01] {
        let found =
            [join(pace, pace, 1.0), join(pace, pace, -1.0), join(pace, 2.0 * pace, 0.0), join(pace, -pace, 0.0)];
        assert!(found.iter().all(|severity| *severity > 1.0), "{pace}: {found:?}");
    }
}

//! The dissolve of pictures that are made up.
//!
//! Owns claims on its ends, its course and its demand. Never draws a species.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::{Dissolve, mixed};
use crate::contract::{Motion, RenderError, Settings};
use crate::guide::Guide;
use crate::image::Image;
use crate::made::Made;
use crate::middle::Middle;
use crate::threads::Threads;

const FRAMES: f64 = 100.0;

/// Waves that run from left to right, 40 frames long; a ball on black that goes round; a still; half a picture of light.
const WAVES: Made = Made(|x, y, frame| {
    let turns = 3.0 * f64::from(x) - frame / 40.0;
    let wave = (turns - turns.floor()) as f32;
    let wave = 4.0 * wave * (1.0 - wave);
    [wave, 0.5 * wave + 0.2 * (y + 1.0), 0.3]
});
const BALL: Made = Made(|x, y, frame| {
    let turn = (frame / 60.0).rem_euclid(1.0) as f32;
    let (u, v) = (2.0 * (turn - 0.5).abs() - 0.5, 2.0 * ((turn + 0.25).fract() - 0.5).abs() - 0.5);
    let near = (1.0 - 2.0 * ((x - u) * (x - u) + (y - v) * (y - v))).max(0.0);
    [near * near, near, 0.6 * near]
});
const STILL: Made = Made(|x, y, _| [0.5 * x + 0.5, 0.5 * y + 0.5, 0.2]);
const HALF: Made = Made(|x, _, _| [if x > 0.0 { 0.9 } else { 0.0 }; 3]);
const GREY: Made = Made(|_, _, _| [0.4; 3]);

const SETTINGS: Settings = Settings {
    size: [160, 90],
    spp: None,
    psnr: None,
    supersample: None,
    temporal_samples: None,
    smooths: false,
    seed: 1,
};

fn dissolve(from: Made, to: Made) -> Dissolve {
    Dissolve::new([Box::new(from), Box::new(to)], FRAMES)
}

fn threads(threads: usize) -> Threads {
    Threads::new(threads).unwrap()
}

fn picture(motion: &dyn Motion, frame: f64) -> Image {
    motion.frame(frame, &SETTINGS, &threads(1)).unwrap().image
}

/// How far pictures are apart, in levels of 255.
fn apart(a: &Image, b: &Image) -> f64 {
    let pairs = a.pixels.as_flattened().iter().zip(b.pixels.as_flattened());
    let squares: f64 = pairs.map(|(a, b)| f64::from(a - b) * f64::from(a - b)).sum();
    255.0 * (squares / (3 * a.pixels.len()) as f64).sqrt()
}

#[test]
fn both_ends_are_the_pictures_of_the_sides_to_the_bit() {
    for (from, to) in [(WAVES, BALL), (BALL, STILL), (STILL, WAVES)] {
        let ends = [picture(&from, 0.0), picture(&to, 0.0)];
        let outside = [picture(&from, -7.0), picture(&to, 3.0)];
        let way = dissolve(from, to);
        assert_eq!([picture(&way, 0.0), picture(&way, FRAMES)], ends);
        assert_eq!([picture(&way, -7.0), picture(&way, FRAMES + 3.0)], outside);
    }
}

#[test]
fn it_sets_out_and_arrives_at_the_speeds_of_the_sides() {
    let way = dissolve(WAVES, BALL);
    for (side, at, inwards) in [(&WAVES, 0.0, 1.0), (&BALL, FRAMES, -1.0)] {
        // Where a frame is short, all that is left of a difference falls with its square.
        let off = |step: f64| apart(&picture(&way, at + step * inwards), &picture(side, step * inwards)) / step;
        let (long, short) = (off(4.0), off(0.5));
        assert!(short < 0.3 * long && short < 0.1, "{at}: {long}, then {short} levels a frame");
    }
}

#[test]
fn no_frame_is_far_from_the_one_before() {
    for (from, to) in [(WAVES, BALL), (BALL, WAVES), (STILL, BALL), (GREY, HALF), (HALF, GREY), (STILL, GREY)] {
        let own = |motion: &Made| apart(&picture(motion, 0.0), &picture(motion, 1.0));
        // Its own most: 1.5 / 100 of the way a frame, in which a place takes 0.6 / 1.6 of it, 1.5 times as fast half way.
        let most = own(&from).max(own(&to)) + 255.0 * 0.06;
        let way = dissolve(from, to);
        let frames: Vec<Image> = (0..=100).map(|frame| picture(&way, f64::from(frame))).collect();
        let worst = frames.windows(2).map(|pair| apart(&pair[0], &pair[1])).fold(0.0, f64::max);
        assert!(worst < most, "{worst} levels, where {most} are expected");
    }
}

#[test]
fn equal_grey_that_brightens_takes_its_ranks_along() {
    // All places are equal, whatever they are: none comes before another, and no step in luma is a step in rank.
    let grey = |light: f32| Image { width: 32, height: 18, pixels: vec![[light; 3]; 32 * 18] };
    for step in 0..400 {
        let guide = Guide::of(&grey(0.002 * step as f32));
        let rank = guide.ranks().of(guide.luma(0));
        assert!((rank - 0.5).abs() < 0.02, "{step}: {rank}");
    }
}

#[test]
fn where_the_second_is_bright_it_arrives_first() {
    let way = dissolve(GREY, HALF);
    let image = picture(&way, 45.0);
    let mean = |from: usize, to: usize| {
        let values = (0..image.height).flat_map(|row| image.pixels[row * image.width..][from..to].iter());
        values.map(|pixel| pixel[1]).sum::<f32>() / (image.height * (to - from)) as f32
    };
    let arrived = [(0.4 - mean(10, 60)) / 0.4, (mean(100, 150) - 0.4) / 0.5];
    assert!(arrived[1] > 0.8 && arrived[0] < 0.2, "{arrived:?} of dark and of bright");
}

#[test]
fn contrast_stays_half_way() {
    let middle = Middle::of(&dissolve(WAVES, BALL), FRAMES, [1280, 720], &threads(1)).unwrap();
    assert!(middle.contrast > 0.6, "{middle:?}");
    // Stripes and their opposite: half of each would be grey.
    let opposite = Made(|x, _, _| [0.5 + 0.4 * (9.0 * x - (9.0 * x).floor() - 0.5); 3]);
    let stripes = Made(|x, _, _| [0.5 - 0.4 * (9.0 * x - (9.0 * x).floor() - 0.5); 3]);
    let middle = Middle::of(&dissolve(stripes, opposite), FRAMES, [1280, 720], &threads(1)).unwrap();
    assert!(middle.contrast > 0.6, "{middle:?}");
}

#[test]
fn pixels_are_the_same_for_any_number_of_threads() {
    let way = dissolve(WAVES, BALL);
    let drawn = [1, 2, 7].map(|count| way.frame(41.5, &SETTINGS, &threads(count)).unwrap());
    assert!(drawn[0] == drawn[1] && drawn[1] == drawn[2]);
    assert!(drawn[0].image.pixels.as_flattened().iter().all(|light| (0.0..=1.0).contains(light)));
}

#[test]
fn what_both_sides_take_and_reach_is_told() {
    let way = dissolve(WAVES, BALL);
    let settings = Settings { psnr: Some(40.0), ..SETTINGS };
    let drawn = way.frame(50.0, &settings, &threads(1)).unwrap();
    let demand = way.demand(50.0, &settings).unwrap();
    assert_eq!((drawn.samples, drawn.psnr, demand.samples), (2 * 160 * 90, Some(40.0), 2 * 160 * 90));
    assert_eq!(way.demand(0.0, &settings).unwrap(), WAVES.demand(0.0, &settings).unwrap());
}

#[test]
fn a_picture_takes_no_more_memory_than_was_told() {
    let (way, threads) = (dissolve(WAVES, BALL), threads(1));
    for size in [[160, 90], [640, 360], [1, 1], [3, 400]] {
        let settings = Settings { size, ..SETTINGS };
        let demand = way.demand(50.0, &settings).unwrap();
        // On the one thread that draws, where allocations are counted.
        let used = threads.run(|| {
            allocation_counter::measure(|| {
                way.frame(50.0, &settings, &threads).unwrap();
            })
        });
        assert!(used.bytes_max <= demand.bytes + demand.bytes_per_thread, "{size:?}: {used:?}, {demand:?}");
    }
}

#[test]
fn it_stops_when_it_is_told_to_and_refuses_pictures_of_two_sizes() {
    let stopped = threads(1).with_stop_flag(Arc::new(AtomicBool::new(true)));
    assert!(matches!(dissolve(WAVES, BALL).frame(50.0, &SETTINGS, &stopped), Err(RenderError::Stopped)));
    let image = |width: usize| Image { width, height: 1, pixels: vec![[0.0; 3]; width] };
    let refused = mixed([&image(1), &image(2)], 0.5, &threads(1));
    assert!(matches!(refused, Err(RenderError::Refused(reason)) if reason.to_string().contains("[1, 1] and [2, 1]")));
}

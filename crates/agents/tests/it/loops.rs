//! Loops are exact, and transitions meet them.

use crate::bred::{SMALL, difference, globe, luma, many, picture, read, settings, sketch};
use species::{Genome, Image, Motion, Settings, Threads};

const TINY: [u32; 2] = [48, 27];

#[test]
fn every_globe_is_an_exact_loop() {
    let threads = Threads::new(2).unwrap();
    for seed in 0..many("GENOMES", 30) {
        let frames = [7.0, 240.0, 100.5][seed as usize % 3];
        let (globe, settings) = (globe(seed), settings(TINY));
        let turning = globe.turning(TINY, frames);
        let at = |frame: f64| picture(turning.as_ref(), frame, &settings, &threads);
        for (frame, same) in [(frames, 0.0), (3.0 * frames, 0.0), (frames + 2.0, 2.0), (2.5 - frames, 2.5)] {
            assert_eq!(at(frame), at(same), "globe {seed}, frames {frame} and {same}: {}", globe.text());
        }
        assert_ne!(at(2.0), at(0.0), "globe {seed} stands still");
    }
}

/// How far the picture in the middle of three is from the mean of its neighbours, in the mean of all pixels.
fn bend(motion: &dyn Motion, middle: f64, step: f64, settings: &Settings, threads: &Threads) -> f64 {
    let [before, at, after] = [-step, 0.0, step].map(|shift| picture(motion, middle + shift, settings, threads));
    let sum = |(index, at): (usize, &f32)| {
        let around = before.pixels.as_flattened()[index] + after.pixels.as_flattened()[index];
        f64::from(around - 2.0 * at).abs()
    };
    at.pixels.as_flattened().iter().enumerate().map(sum).sum::<f64>() / at.pixels.as_flattened().len() as f64
}

#[test]
fn velocity_goes_on_over_the_seam() {
    let threads = Threads::new(2).unwrap();
    for seed in 0..many("GENOMES", 12) {
        let (frames, settings) = (480.0, settings([96, 54]));
        let turning = globe(seed).turning(settings.size, frames);
        let at = |frame: f64| bend(turning.as_ref(), frame, 1.0, &settings, &threads);
        let elsewhere = [61.0, 133.0, 250.0, 377.0].map(at).into_iter().fold(0.0, f64::max);
        assert!(at(frames) < 2.0 * elsewhere, "globe {seed}: {} over the seam, {elsewhere} elsewhere", at(frames));
    }
}

#[test]
fn the_ends_of_a_transition_are_the_loops_to_the_bit() {
    let (threads, settings) = (Threads::new(2).unwrap(), settings(TINY));
    for seed in 0..many("GENOMES", 20) {
        let (from, to) = (globe(seed), globe(seed + 100_000));
        let between = from.transition(to.as_ref(), TINY, [240.0, 180.5], 96.0).unwrap();
        for (end, side, turns) in [(0.0, &from, 240.0), (96.0, &to, 180.5)] {
            let turning = side.turning(TINY, turns);
            let images = [(between.as_ref(), end), (turning.as_ref(), 0.0)];
            let [end, start] = images.map(|(motion, frame)| picture(motion, frame, &settings, &threads));
            assert_eq!(end, start, "pair {seed}");
        }
    }
}

#[test]
fn a_transition_meets_both_loops_in_value_and_in_speed() {
    let threads = Threads::new(2).unwrap();
    // Wide lines have no edges that move by a pixel.
    let settings = sketch([96, 54]);
    for seed in 0..many("GENOMES", 8) {
        let sides = [globe(seed), globe(seed + 100_000)];
        let (turns, frames) = ([360.0, 480.0], 240.0);
        let between = sides[0].transition(sides[1].as_ref(), settings.size, turns, frames).unwrap();
        for (side, end, inwards) in [(0, 0.0, 1.0), (1, frames, -1.0)] {
            let turning = sides[side].turning(settings.size, turns[side]);
            // If the speeds meet, the difference falls with the square of the distance from the end.
            let apart = |frames: f64| {
                let there = picture(between.as_ref(), end + frames, &settings, &threads);
                difference(&there, &picture(turning.as_ref(), frames, &settings, &threads))
            };
            let (near, far) = (apart(inwards * 0.5), apart(inwards * 2.0));
            assert!(far < 0.1 && near < far / 8.0 + 1e-4, "pair {seed}, end {end}: {near} {far}");
        }
    }
}

fn contrast(image: &Image) -> f64 {
    let luma = luma(image);
    let mean = luma.iter().sum::<f64>() / luma.len() as f64;
    (luma.iter().map(|luma| (luma - mean) * (luma - mean)).sum::<f64>() / luma.len() as f64).sqrt()
}

#[test]
fn the_middle_of_a_transition_has_contrast() {
    let (threads, settings) = (Threads::new(2).unwrap(), sketch([160, 90]));
    let pairs = many("GENOMES", 40);
    let is_rich = |seed: &u64| {
        let (from, to) = (globe(*seed), globe(seed + 100_000));
        let between = from.transition(to.as_ref(), settings.size, [480.0; 2], 240.0).unwrap();
        let at = |frame: f64| contrast(&picture(between.as_ref(), frame, &settings, &threads));
        at(120.0) >= 0.6 * f64::midpoint(at(0.0), at(240.0))
    };
    let rich = (0..pairs).filter(is_rich).count();
    assert!(rich as f64 >= 0.9 * pairs as f64, "{rich} of {pairs}");
}

#[test]
fn a_transition_moves_evenly_and_never_jumps() {
    let (threads, settings) = (Threads::new(2).unwrap(), settings([96, 54]));
    for seed in 0..4 {
        let (from, to) = (globe(seed), globe(seed + 100_000));
        let between = from.transition(to.as_ref(), settings.size, [240.0, 360.0], 120.0).unwrap();
        let mut steps: Vec<f64> = Vec::new();
        let mut last = picture(between.as_ref(), 0.0, &settings, &threads);
        for frame in 1..=120 {
            let next = picture(between.as_ref(), f64::from(frame), &settings, &threads);
            let pairs = last.pixels.as_flattened().iter().zip(next.pixels.as_flattened());
            steps.push(pairs.map(|(a, b)| f64::from(a - b).abs()).sum::<f64>());
            last = next;
        }
        let most = steps.iter().copied().fold(0.0, f64::max);
        steps.sort_by(f64::total_cmp);
        assert!(most < 3.0 * steps[60], "pair {seed}: a step of {most}, {} in the middle", steps[60]);
    }
}

#[test]
fn no_transition_leads_to_another_species() {
    #[derive(Debug)]
    struct Other;
    impl Genome for Other {
        fn name(&self) -> Option<&str> {
            None
        }
        fn text(&self) -> String {
            String::new()
        }
        fn lineage(&self) -> species::Lineage {
            species::Lineage::default()
        }
        fn with_lineage(&self, _: &species::Lineage) -> Box<dyn Genome> {
            Box::new(Other)
        }
        fn recipe(&self, _: &Settings) -> species::Recipe {
            species::Recipe { version: String::new(), settings: String::new(), genome: String::new() }
        }
        fn turning(&self, size: [u32; 2], frames: f64) -> Box<dyn Motion> {
            read(SMALL).turning(size, frames)
        }
        fn transition(&self, _: &dyn Genome, _: [u32; 2], _: [f64; 2], _: f64) -> Option<Box<dyn Motion>> {
            None
        }
    }
    assert!(read(SMALL).transition(&Other, TINY, [9.0; 2], 9.0).is_none());
}

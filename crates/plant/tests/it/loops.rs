//! Loops are exact, and transitions meet them.

#![allow(clippy::float_cmp, reason = "loops are equal to the bit")]

use crate::grove::{SMALL, bend, contrast, difference, drawn, many, plant, sized, sketched};
use plant::Plant;
use species::{Genome, Motion, Rng, Threads};

fn turning(plant: &Plant, frames: f64) -> Box<dyn Motion> {
    plant.turning(SMALL.size, frames)
}

/// A pair of plants: every third of one family, so that their genes go over into each other.
fn pair(seed: u64) -> [Plant; 2] {
    let from = plant(seed);
    let to = if seed.is_multiple_of(3) { from.mutated(1.5, &mut Rng::stream(seed, 1)) } else { plant(seed + 5000) };
    [from, Plant { turns: 1 + (seed % 2) as u32, ..to }]
}

fn between([from, to]: &[Plant; 2], turns: [f64; 2], frames: f64) -> Box<dyn Motion> {
    from.transition(to, SMALL.size, turns, frames).unwrap()
}

#[test]
fn frame_f_is_frame_0_to_the_bit_and_plants_move() {
    let threads = Threads::new(2).unwrap();
    for seed in 0..many("GENOMES", 24) {
        let plant = Plant { turns: 1 + (seed % 3) as u32, ..plant(seed) };
        let frames = [7.0, 60.0, 100.5][seed as usize % 3];
        let turning = turning(&plant, frames);
        let first = drawn(&*turning, 0.0, &SMALL, &threads);
        for (frame, same) in [(frames, 0.0), (3.0 * frames, 0.0), (frames + 2.0, 2.0), (2.5 - frames, 2.5)] {
            let [one, other] = [frame, same].map(|frame| drawn(&*turning, frame, &SMALL, &threads));
            assert_eq!(one, other, "plant {seed}, frames {frame} and {same}");
        }
        assert_ne!(drawn(&*turning, 2.0, &SMALL, &threads), first, "plant {seed} stands still");
    }
}

#[test]
fn speed_is_the_same_on_both_sides_of_the_seam() {
    let threads = Threads::new(2).unwrap();
    for seed in 0..many("GENOMES", 24) {
        let turning = turning(&plant(seed), 240.0);
        let at = |frame: f64| drawn(&*turning, frame, &SMALL, &threads);
        let step = |frame: f64| difference(&at(frame), &at(frame + 1.0));
        let (seam, after) = (step(239.0), step(0.0));
        assert!(seam < 1.5 * after + 1e-4 && after < 1.5 * seam + 1e-4, "plant {seed}: {seam} {after}");
        // Another speed would bend as much as a step.
        let bend = bend([at(239.0), at(0.0), at(1.0)].each_ref());
        assert!(bend < 0.4 * after + 1e-5, "plant {seed}: {bend} at a step of {after}");
    }
}

#[test]
fn the_ends_of_a_transition_are_the_loops_to_the_bit() {
    let threads = Threads::new(2).unwrap();
    for seed in 0..many("GENOMES", 24) {
        let pair = pair(seed);
        let way = between(&pair, [20.0, 33.0], 17.0);
        for (frame, of, turns) in [(0.0, &pair[0], 20.0), (17.0, &pair[1], 33.0)] {
            let end = drawn(&*way, frame, &SMALL, &threads);
            assert_eq!(end, drawn(&*turning(of, turns), 0.0, &SMALL, &threads), "pair {seed}, frame {frame}");
        }
    }
}

#[test]
fn a_transition_meets_both_loops_in_speed() {
    let threads = Threads::new(2).unwrap();
    let large = sized([160, 90]);
    for seed in 0..many("GENOMES", 12) {
        let pair = pair(seed);
        let way = between(&pair, [300.0, 400.0], 200.0);
        for (of, turns, end, inwards) in [(&pair[0], 300.0, 0.0, 1.0), (&pair[1], 400.0, 200.0, -1.0)] {
            let side = turning(of, turns);
            // If the speeds meet, the difference falls with the square of the distance from the end.
            let apart = |frames: f64| {
                let there = drawn(&*way, end + inwards * frames, &large, &threads);
                difference(&there, &drawn(&*side, inwards * frames, &large, &threads))
            };
            let (near, far) = (apart(1.0), apart(4.0));
            assert!(near < far / 6.0 + 2e-4, "pair {seed}, end {end}: {near} {far}");
        }
    }
}

#[test]
fn a_transition_has_no_jump() {
    let threads = Threads::new(2).unwrap();
    let frames = 240.0;
    let settings = sketched([96, 54]);
    for seed in 0..many("GENOMES", 6).min(200) {
        let way = between(&pair(seed), [240.0; 2], frames);
        let pictures: Vec<_> = (0..=frames as u32).map(|at| drawn(&*way, f64::from(at), &settings, &threads)).collect();
        let steps: Vec<f64> = pictures.windows(2).map(|two| difference(&two[0], &two[1])).collect();
        for (number, step) in steps.iter().enumerate() {
            let around = &steps[number.saturating_sub(3)..(number + 4).min(steps.len())];
            let usual = (around.iter().sum::<f64>() - step) / (around.len() - 1) as f64;
            assert!(*step < 1.7 * usual + 5e-4, "pair {seed}, frame {number}: {step} among {usual}");
        }
    }
}

#[test]
fn the_middle_of_a_transition_has_the_contrast_of_its_ends() {
    let threads = Threads::new(2).unwrap();
    let (mut kept, many) = (0, many("GENOMES", 40).min(200));
    for seed in 0..many {
        let way = between(&[plant(seed), plant(seed + 5000)], [300.0; 2], 200.0);
        let [first, middle, last] =
            [0.0, 100.0, 200.0].map(|frame| contrast(&drawn(&*way, frame, &sketched([160, 90]), &threads)));
        kept += u64::from(middle >= 0.6 * 0.5 * (first + last));
    }
    assert!(10 * kept >= 9 * many, "{kept} of {many}");
}

#[test]
fn hues_go_the_shorter_way_round() {
    let threads = Threads::new(1).unwrap();
    let hue = plant::GENES.iter().position(|gene| gene.name == "hue").unwrap();
    let with = |number: f64| {
        let mut plant = Plant::default();
        plant.genes[hue] = number;
        plant
    };
    let middle = between(&[with(0.9), with(0.1)], [100.0; 2], 100.0);
    let red = turning(&with(0.0), 100.0);
    // Halfway the clocks are half a loop on, or a whole one: the wind is the same at frame 50.
    let [found, wanted] = [&middle, &red].map(|motion| drawn(&**motion, 50.0, &SMALL, &threads));
    assert!(difference(&found, &wanted) < 0.002, "{}", difference(&found, &wanted));
}

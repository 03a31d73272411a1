//! Loops close, can be shown, and do not depend on the machine.
//!
//! Owns claims on single genomes of all species.

use species::{Figures, Rng, Threads};

use super::joins::{allowed, at};
use super::sheep::{LOOP, SETTINGS, SIZE, bred, drawn, genome, picture, turning};
use super::{SPECIES, genomes, tried};

#[test]
fn frame_f_is_frame_0_to_the_bit_and_the_seam_cannot_be_seen() {
    let threads = Threads::new(0).unwrap();
    for species in tried() {
        let (mut worst, mut jerky) = ((0.0, String::new()), 0);
        for seed in 0..genomes(species) {
            let genome = genome(species, seed);
            let turning = turning(&*genome);
            let frame = |frame: f64| picture(&*turning, frame, &threads);
            for (late, early) in [(LOOP, 0.0), (3.0 * LOOP + 5.0, 5.0), (-2.5, LOOP - 2.5)] {
                assert_eq!(frame(late), frame(early), "{seed}, frames {late} and {early}: {}", genome.text());
            }
            let mut found = at(&*turning, LOOP, &threads);
            // What is beyond the bound may be a loop that jerks everywhere.
            if found >= 1.0 {
                found /= allowed(&*turning, &threads);
                jerky += 1;
            }
            if found > worst.0 {
                worst = (found, format!("{seed}: {}", genome.text()));
            }
        }
        println!("{}: the worst seam is {:.2} of what is allowed, {jerky} jerk", species.name(), worst.0);
        assert!(worst.0 < 1.0, "{} of what is allowed, {}", worst.0, worst.1);
    }
}

#[test]
fn nobody_is_shown_what_is_black_still_or_strobing() {
    let threads = Threads::new(0).unwrap();
    for species in tried() {
        for seed in 0..genomes(species) {
            let genome = genome(species, seed);
            let turning = genome.turning([1280, 720], LOOP);
            let figures = Figures::sketched(&*turning, LOOP, [1280, 720], &threads).unwrap();
            assert_eq!(figures.faults(), [], "{figures:?}, {seed}: {}", genome.text());
        }
    }
}

#[test]
fn pixels_are_the_same_for_any_number_of_threads() {
    let threads = [1, 2, 7].map(|count| Threads::new(count).unwrap());
    for species in tried() {
        for seed in 0..genomes(species).div_ceil(3) {
            let turning = turning(&*genome(species, seed));
            let [one, two, seven] = [0, 1, 2].map(|at| drawn(&*turning, 7.25, &threads[at]));
            assert!(one == two && two == seven, "{}, {seed}", species.name());
        }
    }
}

#[test]
fn the_same_random_numbers_make_the_same_genomes() {
    for species in tried() {
        for seed in 0..genomes(species).div_ceil(3) {
            assert_eq!(bred(species, seed).text(), genome(species, seed).text());
        }
        let other = SPECIES.iter().find(|other| other.name() != species.name());
        if let Some(other) = other {
            let (stranger, mut rng) = (genome(*other, 0), Rng::stream(1, 0));
            assert!(species.mutate(&*stranger, 1.0, &mut rng).is_none());
            assert!(species.cross([&*genome(species, 0), &*stranger], &mut rng).is_none());
        }
    }
}

#[test]
fn a_picture_takes_no_more_than_was_told() {
    let threads = Threads::new(1).unwrap();
    for species in tried() {
        for seed in 0..genomes(species) {
            let turning = genome(species, seed).turning(SIZE, LOOP);
            let demand = turning.demand(40.5, &SETTINGS).unwrap();
            // On the one thread that draws, where allocations are counted.
            let used = threads.run(|| {
                allocation_counter::measure(|| {
                    let samples = turning.frame(40.5, &SETTINGS, &threads).unwrap().samples;
                    assert!(samples <= demand.samples, "{}, {seed}: {samples}, {demand:?}", species.name());
                })
            });
            assert!(used.bytes_max <= demand.bytes, "{}, {seed}: {used:?}, {demand:?}", species.name());
        }
    }
}

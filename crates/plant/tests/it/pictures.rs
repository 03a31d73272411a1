//! What pictures are, what they take, and what they do not depend on.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crate::grove::{SMALL, checksum, difference, drawn, many, plant, sized, sketched};
use plant::{GENES, MANY, Plant};
use species::{Genome, RenderError, Threads};

/// Checksums of small pictures of the plant of no text, of random ones and of bred ones, which were looked at.
const GOLDEN: [u64; 6] = [
    10_998_644_275_126_709_448,
    17_295_712_085_605_266_122,
    17_511_306_380_615_539_573,
    4_340_294_695_778_778_920,
    18_043_967_333_660_142_035,
    7_511_970_056_363_632_507,
];

#[test]
fn pictures_are_those_that_were_looked_at() {
    let threads = Threads::new(2).unwrap();
    let plants = [Plant::default(), plant(1), plant(2), plant(3), plant(4), plant(7)];
    let found = plants.map(|plant| checksum(&drawn(&*plant.turning(SMALL.size, 60.0), 3.0, &SMALL, &threads)));
    assert_eq!(found, GOLDEN);
}

/// Of the way from a bred plant to another one, half way and later.
const ON_THE_WAY: [u64; 2] = [4_359_252_062_452_995_467, 7_214_280_330_268_632_579];

#[test]
fn on_the_way_between_two_plants_are_the_pictures_that_were_there() {
    let threads = Threads::new(2).unwrap();
    let between = plant(3).transition(&plant(7), SMALL.size, [60.0; 2], 30.0).unwrap();
    assert_eq!([15.0, 21.0].map(|frame| checksum(&drawn(&*between, frame, &SMALL, &threads))), ON_THE_WAY);
}

#[test]
fn pixels_are_the_same_for_any_number_of_threads() {
    // No side is a whole number of bands.
    let settings = sized([131, 70]);
    for seed in 0..6 {
        let turning = plant(seed).turning(settings.size, 60.0);
        let draw = |threads| checksum(&drawn(&*turning, 3.0, &settings, &Threads::new(threads).unwrap()));
        let alone = draw(1);
        assert_eq!([draw(2), draw(7)], [alone; 2], "plant {seed}");
    }
}

#[test]
fn a_small_step_of_any_gene_is_a_small_change_of_the_picture() {
    let threads = Threads::new(2).unwrap();
    let settings = sketched([160, 90]);
    let draw = |plant: &Plant| drawn(&*plant.turning(settings.size, 60.0), 7.0, &settings, &threads);
    let (mut seen, many) = ([0; MANY], many("GENOMES", 6).min(50));
    for seed in 0..many {
        let plant = plant(seed);
        let first = draw(&plant);
        for (place, gene) in GENES.iter().enumerate() {
            let stepped = |step: f64| {
                let mut other = plant.clone();
                let number = other.genes[place];
                other.genes[place] = if number > 0.5 { number - step } else { number + step };
                difference(&first, &draw(&other))
            };
            let (tiny, small, large) = (stepped(1e-6), stepped(1e-4), stepped(0.2));
            assert!(tiny < 2e-4 && small < 6e-3, "plant {seed}, `{}`: {tiny} {small}", gene.name);
            seen[place] += u64::from(large > 5e-5);
        }
    }
    // Where the budget of parts is spent, a further order of branches is not seen.
    for (gene, seen) in GENES.iter().zip(seen) {
        assert!(4 * seen >= 3 * many, "`{}` changes {seen} of {many} pictures", gene.name);
    }
}

#[test]
fn a_picture_takes_no_more_than_is_told_before() {
    let threads = Threads::new(1).unwrap();
    for seed in 0..many("GENOMES", 8) {
        let [from, to] = [plant(seed), plant(seed + 77)];
        for settings in [SMALL, sketched([64, 36]), sized([320, 50])] {
            let motions =
                [from.turning(settings.size, 60.0), from.transition(&to, settings.size, [60.0; 2], 30.0).unwrap()];
            for motion in motions {
                let demand = motion.demand(11.0, &settings).unwrap();
                let mut samples = 0;
                // The worker's allocations are counted where they are made.
                let memory = threads.run(|| {
                    allocation_counter::measure(|| {
                        samples = motion.frame(11.0, &settings, &threads).unwrap().samples;
                    })
                });
                assert_eq!(samples, demand.samples);
                assert!(memory.bytes_max <= demand.bytes, "plant {seed}: {} of {}", memory.bytes_max, demand.bytes);
            }
        }
    }
}

#[test]
fn one_moment_is_asked_for_in_two_ways() {
    let turning = plant(1).turning(SMALL.size, 60.0);
    let samples = |settings| turning.demand(0.0, &settings).unwrap().samples;
    let one = species::Settings { spp: Some(1.0), ..SMALL };
    assert_eq!([samples(SMALL), samples(one), samples(sketched(SMALL.size))], [4 * 64 * 36, 64 * 36, 64 * 36]);
    assert_ne!(plant(1).recipe(&one), plant(1).recipe(&SMALL));
}

#[test]
fn what_cannot_be_drawn_is_refused_and_drawing_can_be_stopped() {
    let threads = Threads::new(1).unwrap();
    let turning = plant(1).turning(SMALL.size, 60.0);
    for size in [[0, 9], [9, 16_385]] {
        let refused = turning.frame(0.0, &sized(size), &threads).unwrap_err();
        assert!(refused.to_string().contains("1 to 16384"), "{refused}");
        assert!(turning.demand(0.0, &sized(size)).is_err());
    }
    let stopped = threads.with_stop_flag(Arc::new(AtomicBool::new(true)));
    assert!(matches!(turning.frame(0.0, &SMALL, &stopped), Err(RenderError::Stopped)));
}

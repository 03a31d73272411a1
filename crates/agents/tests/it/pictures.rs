//! What pictures are, and what they do not depend on.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crate::bred::{SMALL, checksum, globe, luma, many, picture, read, settings, sketch};
use species::{Motion, RenderError, Settings, Threads};

/// Globes that were bred and chosen, with the checksums of their pictures, which were looked at.
const CHOSEN: [(&str, &str, u64); 4] = [
    ("snowglobe", include_str!("../../../../flock-tools/demo/genomes/snowglobe.agents"), 1_169_899_218_292_402_335),
    ("neon", include_str!("../../../../flock-tools/demo/genomes/neon.agents"), 11_468_856_995_974_255_643),
    ("gilt", include_str!("../../../../flock-tools/demo/genomes/gilt.agents"), 4_218_897_930_797_673_072),
    ("petal", include_str!("../../../../flock-tools/demo/genomes/petal.agents"), 16_139_512_268_314_356_465),
];

#[test]
fn pictures_are_those_that_were_looked_at() {
    let threads = Threads::new(2).unwrap();
    let settings = settings([131, 70]);
    let found = CHOSEN.map(|(name, text, _)| {
        let globe = read(text);
        assert_eq!(globe.name(), Some(name));
        let turning = globe.turning(settings.size, 240.0);
        (name, checksum(&picture(turning.as_ref(), 33.0, &settings, &threads)))
    });
    assert_eq!(found, CHOSEN.map(|(name, _, sum)| (name, sum)));
}

/// Of the way from the first of them to the second, half way.
const HALF_WAY: u64 = 12_638_140_007_946_517_634;

#[test]
fn half_way_between_two_globes_is_the_picture_that_it_was() {
    let settings = settings([131, 70]);
    let [from, to] = [CHOSEN[0], CHOSEN[1]].map(|(_, text, _)| read(text));
    let between = from.transition(to.as_ref(), settings.size, [240.0; 2], 90.0).unwrap();
    let image = picture(between.as_ref(), 45.0, &settings, &Threads::new(2).unwrap());
    assert_eq!(checksum(&image), HALF_WAY);
}

#[test]
fn pixels_are_the_same_for_any_number_of_threads() {
    for seed in 0..4 {
        let settings = settings([131, 70]);
        let turning = globe(seed).turning(settings.size, 240.0);
        let draw = |threads| checksum(&picture(turning.as_ref(), 3.0, &settings, &Threads::new(threads).unwrap()));
        let alone = draw(1);
        assert_eq!([draw(2), draw(7)], [alone; 2], "globe {seed}");
    }
}

/// Bytes that a frame takes at most, as counted, with one thread that is the counted one.
fn held(motion: &(dyn Motion + 'static), settings: &Settings, threads: usize) -> (u64, u64) {
    let threads = Threads::new(threads).unwrap();
    // What threads set up for themselves once is not a frame's.
    picture(motion, 5.0, &sketch([16, 9]), &threads);
    let (mut samples, mut most) = (0, 0);
    threads.run(|| {
        let memory = allocation_counter::measure(|| samples = motion.frame(5.0, settings, &threads).unwrap().samples);
        most = memory.bytes_max;
    });
    (samples, most)
}

#[test]
fn every_demand_holds() {
    let mut tightest = f64::MAX;
    for seed in 0..many("GENOMES", 12) {
        let (one, other) = (globe(seed), globe(seed + 100_000));
        let size = [[640, 360], [131, 70], [33, 500]][seed as usize % 3];
        let loops = one.turning(size, 240.0);
        let between = one.transition(other.as_ref(), size, [240.0; 2], 10.0).unwrap();
        for motion in [loops.as_ref(), between.as_ref()] {
            for settings in [settings(size), sketch(size)] {
                let demand = motion.demand(5.0, &settings).unwrap();
                // With one thread, and called from it, everything is allocated by the thread that counts.
                let (samples, bytes) = held(motion, &settings, 1);
                assert_eq!(samples, demand.samples, "globe {seed}");
                assert!(bytes <= demand.bytes, "globe {seed}: {bytes} of {}", demand.bytes);
                tightest = tightest.min(bytes as f64 / demand.bytes as f64);
            }
        }
    }
    assert!(tightest > 0.1, "a demand is {tightest} of what is needed");
}

#[test]
fn a_sketch_has_one_moment_and_motion_is_blurred_otherwise() {
    let threads = Threads::new(1).unwrap();
    let turning = read(SMALL).turning([160, 90], 12.0);
    let at = |settings: &Settings| picture(turning.as_ref(), 3.0, settings, &threads);
    let (blurred, still) = (at(&settings([160, 90])), at(&sketch([160, 90])));
    assert_eq!(still, at(&Settings { spp: Some(1.0), ..settings([160, 90]) }));
    // What falls is blurred from row to row.
    let sharpness = |image| luma(image).windows(161).map(|rows| (rows[160] - rows[0]).powi(2)).sum::<f64>();
    assert!(sharpness(&blurred) < 0.9 * sharpness(&still));
}

#[test]
fn a_stopped_drawing_says_so() {
    let stop = Arc::new(AtomicBool::new(true));
    let threads = Threads::new(1).unwrap().with_stop_flag(stop);
    let drawn = read(SMALL).turning([64, 36], 30.0).frame(0.0, &settings([64, 36]), &threads);
    assert!(matches!(drawn, Err(RenderError::Stopped)));
}

#[test]
fn a_large_picture_is_the_small_one_with_more_detail() {
    let threads = Threads::new(2).unwrap();
    for seed in 0..4 {
        let mean = |size: [u32; 2]| {
            let turning = globe(seed).turning(size, 240.0);
            let luma = luma(&picture(turning.as_ref(), 50.0, &settings(size), &threads));
            luma.iter().sum::<f64>() / luma.len() as f64
        };
        let (small, large) = (mean([320, 180]), mean([1280, 720]));
        assert!((small / large - 1.0).abs() < 0.1, "globe {seed}: {small} {large}");
    }
}

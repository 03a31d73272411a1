//! Genomes that are tried, and their small pictures.
//!
//! Owns how they are bred, and how they are drawn. Never judges them.

use std::collections::BTreeMap;
use std::sync::Mutex;

use species::{Breed, Drawn, Genome, Image, Motion, Rng, Settings, Threads};

/// Frames of a loop, and of a transition from one to another.
pub(crate) const LOOP: f64 = 384.0;
pub(crate) const TRANSITION: f64 = 192.0;

pub(crate) const SIZE: [u32; 2] = [96, 54];

/// Samples per pixel where there is noise: so many that motion shows above it.
const SAMPLES: f64 = 500.0;

/// Texts of genomes, by their species and their numbers: breeding takes longer than reading.
static BRED: Mutex<BTreeMap<(&str, u64), String>> = Mutex::new(BTreeMap::new());

/// The genome of a species numbered `seed`: every second one is random, the others are bred.
pub(crate) fn genome(of: &dyn Breed, seed: u64) -> Box<dyn Genome> {
    let known = BRED.lock().unwrap().get(&(of.ending(), seed)).cloned();
    let text = known.unwrap_or_else(|| {
        let text = bred(of, seed).text();
        BRED.lock().unwrap().insert((of.ending(), seed), text.clone());
        text
    });
    of.parse(&text).unwrap()
}

/// The same, bred anew.
pub(crate) fn bred(of: &dyn Breed, seed: u64) -> Box<dyn Genome> {
    let mut rng = Rng::stream(seed, 31);
    let random = of.random(&mut rng);
    if seed.is_multiple_of(2) {
        return random;
    }
    let (child, _) = of.mutate(&*random, 1.0, &mut rng).unwrap();
    let other = of.random(&mut rng);
    of.cross([&*child, &*other], &mut rng).map_or(child, |(child, _)| child)
}

pub(crate) fn turning(of: &dyn Genome) -> Box<dyn Motion> {
    of.turning(SIZE, LOOP)
}

/// The same for all, so that a transition's ends are the loops'.
pub(crate) const SETTINGS: Settings = Settings {
    size: SIZE,
    spp: Some(SAMPLES),
    psnr: None,
    supersample: None,
    temporal_samples: None,
    smooths: true,
    seed: 1,
};

pub(crate) fn drawn(of: &dyn Motion, frame: f64, threads: &Threads) -> Drawn {
    of.frame(frame, &SETTINGS, threads).unwrap()
}

pub(crate) fn picture(of: &dyn Motion, frame: f64, threads: &Threads) -> Image {
    let image = drawn(of, frame, threads).image;
    assert_eq!([image.width, image.height], SIZE.map(|side| side as usize));
    assert!(image.pixels.as_flattened().iter().all(|light| (0.0..=1.0).contains(light)), "no displayable light");
    image
}

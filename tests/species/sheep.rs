//! Genomes that are tried, and their small pictures.
//!
//! Owns how they are bred, and how they are drawn. Never judges them.

use std::fs;
use std::path::{Path, PathBuf};

use flame::{Backend, Flames};
use species::{Breed, Drawn, Genome, Image, Motion, Rng, Settings, Species, Threads};

/// Frames of a loop, and of a transition from one to another.
pub(crate) const LOOP: f64 = 384.0;
pub(crate) const TRANSITION: f64 = 192.0;

pub(crate) const SIZE: [u32; 2] = [96, 54];

/// Samples per pixel where there is noise: so many that motion shows above it.
const SAMPLES: f64 = 500.0;

/// The genome of a species numbered `seed`: every second one is random, the others are bred.
pub(crate) fn genome(of: &dyn Breed, seed: u64) -> Box<dyn Genome> {
    let mut rng = Rng::stream(seed, 31);
    let random = of.random(&mut rng);
    if seed.is_multiple_of(2) {
        return random;
    }
    let (child, _) = of.mutate(&*random, 1.0, &mut rng).unwrap();
    let other = of.random(&mut rng);
    of.cross([&*child, &*other], &mut rng).map_or(child, |(child, _)| child)
}

/// One of the flames of the demo.
pub(crate) fn flame(seed: u64) -> Box<dyn Genome> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../flock-tools/demo/genomes");
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut flames: Vec<PathBuf> = files.filter(|path| path.extension().is_some_and(|it| it == "flam3")).collect();
    flames.sort();
    let text = fs::read_to_string(&flames[seed as usize % flames.len()]).unwrap();
    Flames { backend: Backend::default(), coloured: Ok }.parse(&text).unwrap()
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

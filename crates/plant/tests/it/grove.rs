//! What the claims about plants share: how they are drawn and compared.
//!
//! Owns the plants of a seed, small pictures, and their differences. Never claims anything.
//!
//! Start at [`plant`].

use plant::Plant;
use species::{Image, Motion, Rng, Settings, Threads};

pub(crate) const SMALL: Settings = sized([64, 36]);

pub(crate) const fn sized(size: [u32; 2]) -> Settings {
    Settings { size, spp: None, psnr: None, supersample: None, temporal_samples: None, smooths: false, seed: 0 }
}

/// One moment instead of four.
pub(crate) const fn sketched(size: [u32; 2]) -> Settings {
    Settings { temporal_samples: Some(1), ..sized(size) }
}

/// How many plants a claim is tried on: `daily`, or what the environment says in `GENOMES` or `MUTANTS`.
pub(crate) fn many(variable: &str, daily: u64) -> u64 {
    std::env::var(variable).ok().map_or(daily, |text| text.parse().unwrap())
}

/// A random plant, or one that was bred of several.
pub(crate) fn plant(seed: u64) -> Plant {
    let mut rng = Rng::stream(seed, 0);
    let mut plant = Plant::random(&mut rng);
    for _ in 0..seed % 4 {
        let other = Plant::random(&mut rng);
        plant = plant.crossed(&other, &mut rng).0.mutated(1.0, &mut rng);
    }
    plant
}

pub(crate) fn drawn(motion: &dyn Motion, frame: f64, settings: &Settings, threads: &Threads) -> Image {
    motion.frame(frame, settings, threads).unwrap().image
}

/// FNV-1a over the bits of all channels.
pub(crate) fn checksum(image: &Image) -> u64 {
    let bytes = image.pixels.as_flattened().iter().flat_map(|light| light.to_bits().to_le_bytes());
    bytes.fold(0xcbf2_9ce4_8422_2325, |sum, byte| (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

/// The mean difference of two pictures.
pub(crate) fn difference(a: &Image, b: &Image) -> f64 {
    let pairs = a.pixels.as_flattened().iter().zip(b.pixels.as_flattened());
    pairs.map(|(a, b)| f64::from(a - b).abs()).sum::<f64>() / (3 * a.pixels.len()) as f64
}

/// The mean of how much three pictures in a row are bent in time.
pub(crate) fn bend([a, b, c]: [&Image; 3]) -> f64 {
    let lights = [a, b, c].map(|image| image.pixels.as_flattened());
    let bends = lights[0].iter().zip(lights[1]).zip(lights[2]).map(|((a, b), c)| f64::from(a - 2.0 * b + c).abs());
    bends.sum::<f64>() / lights[0].len() as f64
}

/// The standard deviation of luma.
pub(crate) fn contrast(image: &Image) -> f64 {
    let luma = |[r, g, b]: &[f32; 3]| 0.2126 * f64::from(*r) + 0.7152 * f64::from(*g) + 0.0722 * f64::from(*b);
    let many = image.pixels.len() as f64;
    let mean = image.pixels.iter().map(luma).sum::<f64>() / many;
    (image.pixels.iter().map(|pixel| (luma(pixel) - mean) * (luma(pixel) - mean)).sum::<f64>() / many).sqrt()
}

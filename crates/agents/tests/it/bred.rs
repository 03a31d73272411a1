//! Globes to test with.
//!
//! Owns globes at random and bred ones, pictures of them, and how many of them tests try. Never asserts.

use agents::Agents;
use species::{Breed, Genome, Image, Motion, Rng, Settings, Species, Threads};

/// Pfeiffer's own agent and some more, with everything that a file may say.
pub(crate) const SMALL: &str = r##"
[agents]
version = 1
name = "small"
background = ["#0e1630", "#223054"]
palette = ["#96cdff", "#ebf5ff", "#7896fa"]
drift = 7
glow = 1.25
dust = 30
flock = [
  "v=60&str=F++F++F&it=3&sc=5&rules=('F','F-F++F-F')",
  "v=60&str=[X]+[X]+[X]+[X]+[X]+[X]&it=3&sc=5&rules=('X','F[+F][-F]X')&sw=6&c=2&w=1.5",
  "v=90&str=FX&it=7&rules=('X','X+YF+'),('Y','-FX-Y')&sw=-2",
  "v=72&str=F+F+F+F+F",
]
"##;

/// The number in an environment variable, or a small one for every day.
pub(crate) fn many(variable: &str, daily: u64) -> u64 {
    std::env::var(variable).map_or(daily, |text| text.parse().unwrap())
}

/// A globe of this seed: every other one is at random, the rest are bred.
pub(crate) fn globe(seed: u64) -> Box<dyn Genome> {
    let mut rng = Rng::stream(seed, 0);
    let globe = Agents.random(&mut rng);
    if seed.is_multiple_of(2) {
        return globe;
    }
    let other = Agents.random(&mut rng);
    let (child, _) = Agents.cross([globe.as_ref(), other.as_ref()], &mut rng).unwrap();
    Agents.mutate(child.as_ref(), 1.0, &mut rng).unwrap().0
}

pub(crate) fn read(text: &str) -> Box<dyn Genome> {
    Agents.parse(text).unwrap()
}

pub(crate) fn settings(size: [u32; 2]) -> Settings {
    Settings { size, spp: None, psnr: None, supersample: None, temporal_samples: None, smooths: false, seed: 0 }
}

pub(crate) fn sketch(size: [u32; 2]) -> Settings {
    Settings { temporal_samples: Some(1), ..settings(size) }
}

pub(crate) fn picture(motion: &dyn Motion, frame: f64, settings: &Settings, threads: &Threads) -> Image {
    motion.frame(frame, settings, threads).unwrap().image
}

/// Brightness of every pixel on a screen, by BT.709.
pub(crate) fn luma(image: &Image) -> Vec<f64> {
    let luma = |[red, green, blue]: &[f32; 3]| 0.2126 * red + 0.7152 * green + 0.0722 * blue;
    image.pixels.iter().map(|pixel| f64::from(luma(pixel))).collect()
}

/// FNV-1a over the bits of all channels.
pub(crate) fn checksum(image: &Image) -> u64 {
    let bytes = image.pixels.as_flattened().iter().flat_map(|light| light.to_bits().to_le_bytes());
    bytes.fold(0xcbf2_9ce4_8422_2325, |sum, byte| (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

/// The greatest difference of two pictures.
pub(crate) fn difference(a: &Image, b: &Image) -> f64 {
    let pairs = a.pixels.as_flattened().iter().zip(b.pixels.as_flattened());
    pairs.map(|(a, b)| f64::from(a - b).abs()).fold(0.0, f64::max)
}

//! How much light a moment has, measured on a small picture of few samples.
//!
//! Owns the small picture: its size, its samples and its seed, which are always the same, so that every process of a farm
//! measures the same. Never judges what it measures: `middle.rs` does, and species that expose their transitions.
//!
//! Start at [`Light::of_motion`].

use crate::contract::{Motion, RenderError, Settings};
use crate::image::Image;
use crate::luma::{luma, spread};
use crate::threads::Threads;

/// Pixels of the small picture in its longer direction.
const SIDE: f64 = 96.0;

/// Samples of each of its pixels: 0.3 million in all.
const SAMPLES: f64 = 64.0;

/// Blocks in either direction, whose light tells one moment from the next.
const BLOCKS: usize = 12;

/// A pixel from this luma on shows something.
const LIT: f64 = 0.06;

/// A pixel from this luma on is white.
const WHITE: f64 = 0.97;

/// The light of a moment.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// The mean luma, `0.0..=1.0`.
    pub mean: f64,
    /// The part of pixels that show something.
    pub lit: f64,
    /// The part of pixels that are white.
    pub white: f64,
    /// The standard deviation of the luma.
    pub contrast: f64,
    /// The mean luma of blocks.
    blocks: Vec<f64>,
}

impl Light {
    /// The light of a picture, which has at least one pixel.
    pub fn of(image: &Image) -> Light {
        let lumas: Vec<f64> = image.pixels.iter().map(luma).collect();
        let part = |from: f64| lumas.iter().filter(|luma| **luma >= from).count() as f64 / lumas.len().max(1) as f64;
        let mut blocks = vec![(0.0, 0.0); BLOCKS * BLOCKS];
        for (at, luma) in lumas.iter().enumerate() {
            let (row, column) = (at / image.width * BLOCKS / image.height, at % image.width * BLOCKS / image.width);
            let (sum, pixels) = &mut blocks[row * BLOCKS + column];
            *sum += luma;
            *pixels += 1.0;
        }
        let blocks = blocks.into_iter().map(|(sum, pixels): (f64, f64)| sum / pixels.max(1.0)).collect();
        let [mean, contrast] = spread(lumas.iter().copied());
        Light { mean, lit: part(LIT), white: part(WHITE), contrast, blocks }
    }

    /// The light of `motion` at `frame`, where its pictures are of `size`: a small picture of the same shape is drawn.
    ///
    /// # Errors
    /// As [`Motion::frame`].
    pub fn of_motion(motion: &dyn Motion, frame: f64, size: [u32; 2], threads: &Threads) -> Result<Light, RenderError> {
        let settings = Settings {
            size: small(size, SIDE),
            spp: Some(SAMPLES),
            psnr: None,
            supersample: Some(1),
            temporal_samples: Some(1),
            smooths: false,
            seed: 1,
        };
        Ok(Light::of(&motion.frame(frame, &settings, threads)?.image))
    }

    /// How far the blocks of two moments are apart: the root of their mean square.
    pub fn apart(&self, other: &Light) -> f64 {
        let squares = self.blocks.iter().zip(&other.blocks).map(|(a, b)| (a - b) * (a - b));
        (squares.sum::<f64>() / self.blocks.len() as f64).sqrt()
    }
}

/// A picture's size in the shape of `size`, with `side` pixels in its longer direction.
pub(crate) fn small(size: [u32; 2], side: f64) -> [u32; 2] {
    let longer = f64::from(size[0].max(size[1])).max(1.0);
    size.map(|pixels| (f64::from(pixels) * side / longer).ceil().max(1.0) as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_half_white_picture_is_half_lit_and_as_contrasting_as_can_be() {
        let pixels = (0..64 * 36).map(|at| [f32::from(u8::from(at % 64 >= 32)); 3]).collect();
        let light = Light::of(&Image { width: 64, height: 36, pixels });
        let black = Light::of(&Image { width: 64, height: 36, pixels: vec![[0.0; 3]; 64 * 36] });
        for (found, expected) in
            [(light.mean, 0.5), (light.lit, 0.5), (light.white, 0.5), (light.contrast, 0.5), (black.contrast, 0.0)]
        {
            assert!((found - expected).abs() < 1e-6, "{found} is not {expected}");
        }
        assert!((light.apart(&black) - 0.5_f64.sqrt()).abs() < 0.05 && light.apart(&light) == 0.0);
    }

    #[test]
    fn small_pictures_have_the_shape_of_large_ones() {
        assert_eq!(small([1280, 720], SIDE), [96, 54]);
        assert_eq!(small([720, 1280], SIDE), [54, 96]);
        assert_eq!(small([16_384, 1], SIDE), [96, 1]);
    }
}

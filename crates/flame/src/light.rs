//! How much light a moment has, measured on a small picture of few samples.
//!
//! Owns the small picture: its size, its samples and its seed, which are always the same, so that every process of a farm
//! measures the same. Never judges what it measures: `exposure.rs` and `middle.rs` do.
//!
//! Start at [`Light::of`].

use crate::animate::Motion;
use crate::render::{Arithmetic, Filter, RenderError, Renderer, Settings};
use species::Image;

/// Pixels of the small picture in its longer direction.
const SIDE: f64 = 96.0;

/// Samples of each of its pixels: 0.3 million in all, 6 ms of a core.
const SAMPLES: f64 = 64.0;

/// Blocks in either direction, whose light tells one moment from the next.
const BLOCKS: usize = 12;

/// A pixel from this luma on shows something.
const LIT: f64 = 0.06;

/// A pixel from this luma on is white.
const WHITE: f64 = 0.97;

/// The light of a moment.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Light {
    /// The mean luma, `0.0..=1.0`.
    pub(crate) mean: f64,
    /// The part of pixels that show something.
    pub(crate) lit: f64,
    /// The part of pixels that are white.
    pub(crate) white: f64,
    /// The mean luma of blocks.
    blocks: Vec<f64>,
}

impl Light {
    /// The light of `motion` at `frame`.
    /// Errors: As [`Renderer::render`].
    pub(crate) fn of(motion: &dyn Motion, frame: f64, renderer: &Renderer) -> Result<Light, RenderError> {
        let camera = motion.at(frame).camera;
        let longer = f64::from(camera.size[0].max(camera.size[1])).max(1.0);
        let size = camera.size.map(|side| (f64::from(side) * SIDE / longer).ceil().max(1.0) as u32);
        let settings = Settings {
            size: Some(size),
            // Zoom would multiply them.
            spp: Some(SAMPLES / libm::exp2(2.0 * camera.zoom)),
            supersample: Some(1),
            temporal_samples: Some(1),
            filter: Filter::None,
            seed: 1,
            // The same bits as the fastest, but never by a GPU.
            arithmetic: Arithmetic::Avx2,
            ..Settings::default()
        };
        Ok(Light::new(&renderer.render(motion, frame, &settings)?))
    }

    fn new(image: &Image) -> Light {
        let luma = |[red, green, blue]: &[f32; 3]| {
            0.2126 * f64::from(*red) + 0.7152 * f64::from(*green) + 0.0722 * f64::from(*blue)
        };
        let lumas: Vec<f64> = image.pixels.iter().map(luma).collect();
        let count = lumas.len() as f64;
        let part = |from: f64| lumas.iter().filter(|luma| **luma >= from).count() as f64 / count;
        let mut blocks = vec![(0.0, 0.0); BLOCKS * BLOCKS];
        for (at, luma) in lumas.iter().enumerate() {
            let (row, column) = (at / image.width * BLOCKS / image.height, at % image.width * BLOCKS / image.width);
            let (sum, pixels) = &mut blocks[row * BLOCKS + column];
            *sum += luma;
            *pixels += 1.0;
        }
        let blocks = blocks.into_iter().map(|(sum, pixels): (f64, f64)| sum / pixels.max(1.0)).collect();
        Light { mean: lumas.iter().sum::<f64>() / count, lit: part(LIT), white: part(WHITE), blocks }
    }

    /// How far the blocks of two moments are apart: the root of their mean square.
    pub(crate) fn apart(&self, other: &Light) -> f64 {
        let squares = self.blocks.iter().zip(&other.blocks).map(|(a, b)| (a - b) * (a - b));
        (squares.sum::<f64>() / self.blocks.len() as f64).sqrt()
    }
}

//! What can be told of a loop from few small pictures, and whether anybody should see it.
//!
//! Owns the figures and the limits within which a candidate of breeding is shown. Never compares two candidates.
//!
//! Start at [`Figures::of`], then [`Figures::faults`].

use crate::contract::{Motion, RenderError, Settings};
use crate::image::Image;
use crate::light::small;
use crate::luma::{luma, spread};
use crate::threads::Threads;

mod composition;

use composition::Composition;

/// Pixels of a picture in its longer direction.
const SIDE: f64 = 160.0;
/// Samples of each pixel; and those of a sketch.
const SAMPLES: f64 = 100.0;
const NOISY_SKETCH: f64 = 20.0;
const SKETCH: f64 = 1.0;
/// The moments of the loop that are looked at, each with the [`STEPS`] frames after it.
const MOMENTS: usize = 8;
const STEPS: usize = 2;
/// Of pictures that have noise, motion is measured on means of blocks of so many pixels along a side, and only this part of
/// the flicker counts: their fine parts move on by more than their own size from a frame to the next, and noise is added. The
/// demo's flames have 1.1 to 1.3 before that, at 20 samples per pixel; pictures without any course 1.7, two in turn 2.
const NOISY_BLOCK: usize = 8;
const NOISY_FLICKER: f64 = 0.4;
/// Cells in either direction; an odd number, so that one is in the middle, where most light is.
const CELLS: usize = 5;

/// A pixel below this luma is black.
const BLACK: f64 = 0.02;
/// A pixel of which a channel is above this is clipped.
const CLIPPED: f32 = 0.98;

/// The limits.
const MEAN: [f64; 2] = [0.08, 0.75];
const MOST_BLACK: f64 = 0.92;
const MOST_CLIPPED: f64 = 0.05;
const LEAST_CONTRAST: f64 = 0.05;
/// At every moment: less is a picture of one colour.
const LEAST_AT_ONCE: f64 = 0.02;
const LEAST_ACTIVITY: f64 = 0.0005;
const MOST_FLICKER: f64 = 0.6;
const MOST_UNEVENNESS: f64 = 4.0;
const MOST_DOMINANCE: f64 = 0.6;

/// Figures of a loop, on average over moments of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Figures {
    /// The mean luma, `0.0..=1.0`.
    pub mean: f64,
    /// The standard deviation of the luma.
    pub contrast: f64,
    /// The same at the moment at which it is least.
    pub least_contrast: f64,
    /// The part of pixels that are black. Many species fill the picture, so none is no fault.
    pub black: f64,
    /// The part of pixels with a clipped channel.
    pub clipped: f64,
    /// How colourful it is, in displayable light: 0 is grey, 0.5 is much.
    ///
    /// # Source
    /// Hasler & Süsstrunk, *Measuring colourfulness in natural images* (2003).
    pub colourfulness: f64,
    /// The mean change of luma from a frame to the next.
    pub activity: f64,
    /// The mean second difference of luma over three frames, as a part of the activity: near 0 for smooth motion, over 1
    /// for noise. Of pictures that have noise, a part of it.
    pub flicker: f64,
    /// The change from a frame to the next at the liveliest moment, as a multiple of the activity.
    pub unevenness: f64,
    /// The part of all light that is in one of 25 cells of the picture.
    pub dominance: f64,
    /// The entropy of the hue in 12 bins, each pixel weighted by its chroma: 0 for one hue or none, 1 for all alike.
    pub hue_entropy: f64,
    /// The entropy of the luma in 32 bins: 0 for one luma, 1 for all alike.
    pub luma_entropy: f64,
    /// The part of pixels on strong edges, after Sobel.
    pub edges: f64,
    /// The box-counting dimension of what is brighter than the median lit pixel: 1 of a line, 2 of a plane.
    pub dimension: f64,
    /// Bytes as a PNG per byte of its pixels.
    pub compressed: f64,
    /// The correlation with itself mirrored or turned by half, whichever is largest.
    pub symmetry: f64,
    /// How far the middle of the light is from the middle of the picture, as a part of the way to a corner.
    pub offset: f64,
}

/// Why a candidate is not shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FigureFault {
    /// Nearly all of it is black.
    Black,
    /// Too bright.
    Bright,
    /// Too much is clipped.
    Clipped,
    /// Too dark.
    Dark,
    /// One place has most of the light.
    Dominated,
    /// Too little contrast, at all times or at one.
    Flat,
    /// It hardly moves.
    Still,
    /// Its frames follow each other without a course.
    Strobing,
    /// It moves in jerks.
    Uneven,
}

impl FigureFault {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            FigureFault::Black => "black",
            FigureFault::Bright => "bright",
            FigureFault::Clipped => "clipped",
            FigureFault::Dark => "dark",
            FigureFault::Dominated => "dominated",
            FigureFault::Flat => "flat",
            FigureFault::Still => "still",
            FigureFault::Strobing => "strobing",
            FigureFault::Uneven => "uneven",
        }
    }
}

impl Figures {
    /// The names of the figures that sheep are compared by, in the order of [`Figures::compared`].
    pub const NAMES: [&'static str; 15] = [
        "mean",
        "contrast",
        "black",
        "clipped",
        "colourfulness",
        "hue_entropy",
        "luma_entropy",
        "edges",
        "dimension",
        "compressed",
        "symmetry",
        "offset",
        "activity",
        "flicker",
        "unevenness",
    ];

    /// How far each figure usually is from its middle, in the order of [`Figures::compared`]: by this, sheep are compared
    /// before there are enough of them.
    ///
    /// # Source
    /// Median absolute deviations of sheep by chance that a brood accepts (seed 1: 60 plants, 40 expressions, 24 globes of
    /// agents, 14 flames), the geometric mean of the four species. Of pairs of one species, 1 in 100 is then nearer than
    /// 3.0 (expressions), 1.9 (flames), 0.65 (plants) and 0.42 (agents).
    pub const SPREADS: [f64; 15] =
        [0.037, 0.013, 0.11, 0.0047, 0.025, 0.1, 0.033, 0.0068, 0.012, 0.03, 0.079, 0.017, 0.00058, 0.023, 0.088];

    /// The figures that sheep are compared by. The dominance is none of them: it tells what is wrong, and little else.
    pub fn compared(&self) -> [f64; 15] {
        [
            self.mean,
            self.contrast,
            self.black,
            self.clipped,
            self.colourfulness,
            self.hue_entropy,
            self.luma_entropy,
            self.edges,
            self.dimension,
            self.compressed,
            self.symmetry,
            self.offset,
            self.activity,
            self.flicker,
            self.unevenness,
        ]
    }

    /// The figures of a loop of `frames` frames, of which pictures are to be of `size`: 24 small pictures of the same shape
    /// are drawn, with 100 samples per pixel.
    ///
    /// # Errors
    /// As [`Motion::frame`].
    pub fn of(motion: &dyn Motion, frames: f64, size: [u32; 2], threads: &Threads) -> Result<Figures, RenderError> {
        Figures::sampled(motion, frames, size, SAMPLES, threads)
    }

    /// The same of pictures with few samples, while candidates are screened: 20 per pixel where there is noise, else one.
    ///
    /// # Errors
    /// As [`Motion::frame`].
    pub fn sketched(
        motion: &dyn Motion,
        frames: f64,
        size: [u32; 2],
        threads: &Threads,
    ) -> Result<Figures, RenderError> {
        let spp = if motion.is_noisy() { NOISY_SKETCH } else { SKETCH };
        Figures::sampled(motion, frames, size, spp, threads)
    }

    fn sampled(
        motion: &dyn Motion,
        frames: f64,
        size: [u32; 2],
        spp: f64,
        threads: &Threads,
    ) -> Result<Figures, RenderError> {
        let settings = Settings {
            size: small(size, SIDE),
            spp: Some(spp),
            psnr: None,
            supersample: None,
            temporal_samples: None,
            smooths: true,
            seed: 1,
        };
        let (block, flickering) = if motion.is_noisy() { (NOISY_BLOCK, NOISY_FLICKER) } else { (1, 1.0) };
        let mut sums = Sums::default();
        for moment in 0..MOMENTS {
            let first = (moment as f64 * frames / MOMENTS as f64).floor();
            let mut lumas = Vec::with_capacity(STEPS + 1);
            for step in 0..=STEPS {
                let image = motion.frame(first + step as f64, &settings, threads)?.image;
                let values: Vec<f64> = image.pixels.iter().map(luma).collect();
                if step == 0 {
                    sums.add_picture(&image, &values);
                }
                lumas.push(blocks(&values, image.width, block));
            }
            sums.add_motion(&lumas);
        }
        let figures = sums.figures();
        Ok(Figures { flicker: flickering * figures.flicker, ..figures })
    }

    /// What is wrong with it; nothing if it may be shown.
    pub fn faults(&self) -> Vec<FigureFault> {
        let is_still = self.activity < LEAST_ACTIVITY;
        let all = [
            (self.black > MOST_BLACK, FigureFault::Black),
            (self.mean > MEAN[1], FigureFault::Bright),
            (self.clipped > MOST_CLIPPED, FigureFault::Clipped),
            (self.mean < MEAN[0], FigureFault::Dark),
            (self.dominance > MOST_DOMINANCE, FigureFault::Dominated),
            (self.contrast < LEAST_CONTRAST || self.least_contrast < LEAST_AT_ONCE, FigureFault::Flat),
            (is_still, FigureFault::Still),
            (self.flicker > MOST_FLICKER && !is_still, FigureFault::Strobing),
            (self.unevenness > MOST_UNEVENNESS && !is_still, FigureFault::Uneven),
        ];
        all.into_iter().filter(|(is_wrong, _)| *is_wrong).map(|(_, fault)| fault).collect()
    }
}

/// What is summed up over the moments.
#[derive(Debug, Default)]
struct Sums {
    mean: f64,
    /// At each moment.
    contrasts: Vec<f64>,
    black: f64,
    clipped: f64,
    colourfulness: f64,
    composition: Composition,
    second_difference: f64,
    cells: [f64; CELLS * CELLS],
    /// The change of luma from a frame to the next, at each moment.
    changes: Vec<f64>,
}

impl Sums {
    fn add_picture(&mut self, image: &Image, lumas: &[f64]) {
        let [mean, contrast] = spread(lumas.iter().copied());
        let count = lumas.len().max(1) as f64;
        self.mean += mean;
        self.contrasts.push(contrast);
        self.black += lumas.iter().filter(|luma| **luma < BLACK).count() as f64 / count;
        let is_clipped = |pixel: &&[f32; 3]| pixel.iter().any(|light| *light > CLIPPED);
        self.clipped += image.pixels.iter().filter(is_clipped).count() as f64 / count;
        self.colourfulness += colourfulness(image);
        self.composition.add(&Composition::of(image, lumas));
        for (at, luma) in lumas.iter().enumerate() {
            let (row, column) = (at / image.width * CELLS / image.height, at % image.width * CELLS / image.width);
            self.cells[row * CELLS + column] += luma;
        }
    }

    /// The lumas of frames in a row.
    fn add_motion(&mut self, lumas: &[Vec<f64>]) {
        let mean = |sum: f64| sum / lumas[0].len().max(1) as f64;
        let change = |pair: &[Vec<f64>]| mean(pair[0].iter().zip(&pair[1]).map(|(a, b)| (a - b).abs()).sum());
        self.changes.push(lumas.windows(2).map(change).sum::<f64>() / STEPS as f64);
        let [a, b, c] = [&lumas[0], &lumas[1], &lumas[2]];
        let seconds = a.iter().zip(b).zip(c).map(|((a, b), c)| (a - 2.0 * b + c).abs());
        self.second_difference += mean(seconds.sum());
    }

    fn figures(&self) -> Figures {
        let count = self.changes.len().max(1) as f64;
        let activity = self.changes.iter().sum::<f64>() / count;
        let of_activity = |value: f64| if activity > 0.0 { value / activity } else { 0.0 };
        let most = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
        Figures {
            mean: self.mean / count,
            contrast: self.contrasts.iter().sum::<f64>() / count,
            least_contrast: self.contrasts.iter().copied().fold(f64::INFINITY, f64::min),
            black: self.black / count,
            clipped: self.clipped / count,
            colourfulness: self.colourfulness / count,
            activity,
            flicker: of_activity(self.second_difference / count),
            unevenness: of_activity(most(&self.changes)),
            dominance: most(&self.cells) / self.cells.iter().sum::<f64>().max(1e-9),
            hue_entropy: self.composition.hue_entropy / count,
            luma_entropy: self.composition.luma_entropy / count,
            edges: self.composition.edges / count,
            dimension: self.composition.dimension / count,
            compressed: self.composition.compressed / count,
            symmetry: self.composition.symmetry / count,
            offset: self.composition.offset / count,
        }
    }
}

/// The mean lumas of blocks of a picture so many pixels wide, `side` pixels along a side; those at the edges may be smaller.
fn blocks(lumas: &[f64], width: usize, side: usize) -> Vec<f64> {
    if side <= 1 {
        return lumas.to_vec();
    }
    let columns = width.div_ceil(side);
    let mut sums = vec![(0.0, 0.0); columns * (lumas.len() / width.max(1)).div_ceil(side)];
    for (at, luma) in lumas.iter().enumerate() {
        let (sum, pixels) = &mut sums[at / width / side * columns + at % width / side];
        *sum += luma;
        *pixels += 1.0;
    }
    sums.into_iter().map(|(sum, pixels): (f64, f64)| sum / pixels).collect()
}

fn colourfulness(image: &Image) -> f64 {
    let of = |value: fn([f64; 3]) -> f64| spread(image.pixels.iter().map(|pixel| value(pixel.map(f64::from))));
    let [red_green, red_green_spread] = of(|[red, green, _]| red - green);
    let [yellow_blue, yellow_blue_spread] = of(|[red, green, blue]| f64::midpoint(red, green) - blue);
    let length = |a: f64, b: f64| (a * a + b * b).sqrt();
    length(red_green_spread, yellow_blue_spread) + 0.3 * length(red_green, yellow_blue)
}

#[cfg(test)]
mod tests;

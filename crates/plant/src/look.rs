//! Whether a plant is worth a look: told by small pictures.
//!
//! Owns the figures that a plant is judged by, and their bounds. Never says what is beautiful.
//!
//! Start at [`Look::of`].

use species::{Figures, Image, Threads};

use crate::genome::Plant;
use crate::motion::Loop;

/// The pictures that are looked at.
const SIZE: [u32; 2] = [160, 90];
/// Frames of the loop that is looked at.
const FRAMES: f64 = 240.0;
/// Frames of the longest loop that is not to be still.
const SLOWEST: f64 = 400.0;
/// Where in it: three frames from each on.
const PLACES: [f64; 3] = [0.0, 77.0, 163.0];

/// Figures of a loop of 240 frames at 160 by 90 pixels, without motion blur. Luma is from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// The mean luma.
    pub luma: f64,
    /// Standard deviation of luma over a picture.
    pub contrast: f64,
    /// Mean difference of luma from frame to frame.
    pub activity: f64,
    /// Mean difference of these differences, of the activity.
    pub flicker: f64,
}

impl Look {
    /// The figures of a plant.
    pub fn of(plant: &Plant) -> Look {
        let motion = Loop::new(&Plant { turns: 1, ..plant.clone() }, FRAMES);
        let mut look = Look { luma: 0.0, contrast: 0.0, activity: 0.0, flicker: 0.0 };
        let share = 1.0 / PLACES.len() as f64;
        for place in PLACES {
            let [first, second, third] = [0.0, 1.0, 2.0].map(|frame| lumas(&motion.sketch(place + frame, SIZE)));
            let many = first.len() as f64;
            let mean = first.iter().sum::<f64>() / many;
            let variance = first.iter().map(|luma| (luma - mean) * (luma - mean)).sum::<f64>() / many;
            let steps = first.iter().zip(&second).map(|(a, b)| (b - a).abs()).sum::<f64>() / many;
            let bends = first.iter().zip(&second).zip(&third).map(|((a, b), c)| (a - 2.0 * b + c).abs()).sum::<f64>();
            look.luma += share * mean;
            look.contrast += share * variance.sqrt();
            look.activity += share * steps;
            look.flicker += share * bends / many;
        }
        look.flicker /= look.activity.max(1e-12);
        look
    }

    /// Whether it seems to be neither black, blank, still nor strobing: in a loop of 400 frames its activity is still 0.0005, in one
    /// of 180 its flicker is not over 0.6.
    pub fn is_fair(&self) -> bool {
        (0.08..=0.75).contains(&self.luma)
            && self.contrast >= 0.05
            && self.activity >= 0.0005 * SLOWEST / FRAMES
            && self.flicker <= 0.6 * 180.0 / FRAMES
    }
}

/// Whether a loop of 400 frames has no fault by the figures that sheep of all species are judged by. They tell more than a
/// [`Look`], of eight places, and take longer.
pub(crate) fn has_no_fault(plant: &Plant, threads: &Threads) -> bool {
    let motion = Loop::new(&Plant { turns: 1, ..plant.clone() }, SLOWEST);
    Figures::sketched(&motion, SLOWEST, SIZE, threads).is_ok_and(|figures| figures.faults().is_empty())
}

fn lumas(image: &Image) -> Vec<f64> {
    let luma = |[r, g, b]: &[f32; 3]| 0.2126 * f64::from(*r) + 0.7152 * f64::from(*g) + 0.0722 * f64::from(*b);
    image.pixels.iter().map(luma).collect()
}

//! Figures of sheep as numbers that can be compared.
//!
//! Owns how a pool normalises its figures, and how far apart two sheep are. Never knows what a figure means.
//!
//! Start at [`Scale::of`].

use serde::{Deserialize, Serialize};
use species::Figures;

/// Normalised figures lie within this, in either direction.
const CLIP: f64 = 3.0;

/// Figures are kept to this part of 1: finer than any of them means, and so coarse that JSON gives them back to the bit.
const GRAIN: f64 = 1e9;

/// With fewer sheep, their figures are measured by what is usual: [`Figures::SPREADS`].
pub(crate) const LEAST_SCALED: usize = 8;

/// The figures of a sheep, in an order that is the same for all of a pool: that of `species::Figures::NAMES`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Traits(Vec<f64>);

impl Traits {
    /// These figures; one that is no number is 0.
    pub fn new(values: &[f64]) -> Traits {
        let rounded = |value: &f64| if value.is_finite() { (value * GRAIN).round() / GRAIN } else { 0.0 };
        Traits(values.iter().map(rounded).collect())
    }

    /// The figures.
    pub fn values(&self) -> &[f64] {
        &self.0
    }

    /// The figure at a place; 0 if there is none.
    pub fn at(&self, place: usize) -> f64 {
        self.0.get(place).copied().unwrap_or(0.0)
    }
}

/// The middle and the spread of each figure in a pool.
#[derive(Clone, Debug, PartialEq)]
pub struct Scale {
    /// The median of each figure, and one over its median absolute deviation.
    figures: Vec<(f64, f64)>,
    /// Normalised figures lie within this, in either direction.
    clip: f64,
}

/// Normalised figures.
#[derive(Clone, Debug, PartialEq)]
pub struct Point(Vec<f64>);

impl Scale {
    /// The scale of these sheep. A figure that is the same for more than half of them is measured by its mean absolute
    /// deviation; one that is the same for all tells nothing, and is 0 for every sheep.
    ///
    /// Fewer than 8 sheep have no scale of their own: what is usual takes its place, and nothing is clipped, since nobody
    /// knows where their middle is.
    pub fn of<'a>(sheep: &(impl Iterator<Item = &'a Traits> + Clone)) -> Scale {
        let places = sheep.clone().map(|traits| traits.0.len()).max().unwrap_or(0);
        if sheep.clone().count() < LEAST_SCALED {
            let figures = Figures::SPREADS.iter().map(|spread| (0.0, 1.0 / spread)).collect();
            return Scale { figures, clip: f64::INFINITY };
        }
        let figure = |place: usize| {
            let values: Vec<f64> = sheep.clone().map(|traits| traits.at(place)).collect();
            let middle = median(&values);
            let deviations: Vec<f64> = values.iter().map(|value| (value - middle).abs()).collect();
            let mean = deviations.iter().sum::<f64>() / deviations.len().max(1) as f64;
            let spread = [median(&deviations), mean].into_iter().find(|spread| *spread > 1.0 / GRAIN);
            (middle, spread.map_or(0.0, |spread| 1.0 / spread))
        };
        Scale { figures: (0..places).map(figure).collect(), clip: CLIP }
    }

    /// The figures of a sheep, each as its distance from the median in median absolute deviations, at most 3.
    pub fn point(&self, traits: &Traits) -> Point {
        let figure =
            |(value, (middle, factor)): (&f64, &(f64, f64))| ((value - middle) * factor).clamp(-self.clip, self.clip);
        Point(traits.0.iter().zip(&self.figures).map(figure).collect())
    }
}

impl Point {
    /// How far apart two sheep are: the root of the mean square of the differences of their normalised figures. So it does
    /// not grow with the number of figures. Two sheep of a pool by chance are about 2 apart.
    pub fn distance(&self, other: &Point) -> f64 {
        libm::sqrt(self.distance_squared(other))
    }

    pub(crate) fn distance_squared(&self, other: &Point) -> f64 {
        let squares: f64 = self.0.iter().zip(&other.0).map(|(a, b)| (a - b) * (a - b)).sum();
        squares / self.0.len().max(1) as f64
    }
}

/// The median; 0 of nothing.
pub(crate) fn median(values: &[f64]) -> f64 {
    let mut values = values.to_vec();
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

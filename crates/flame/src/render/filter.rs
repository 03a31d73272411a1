//! Filters: the spatial one between cells and pixels, the temporal one between moments and a frame.
//!
//! Owns the kernels and their supports, and the names of the filters of noise. Never touches a histogram: `tonemap.rs`
//! convolves.
//!
//! flam3 3.1.1 draws other kernels than it names for `mitchell`, `blackman`, `catrom`, `hamming` and both `lanczos`
//! (measured on a single point); here each name draws its own.
//!
//! Start at [`Spatial::new`] and [`shutter`].
//!
//! # Source
//! The kernels are the classical ones: Schumacher, *General filtered image rescaling* (Graphics Gems III,
//! 1992), Mitchell & Netravali (1988), and the windows of signal processing.

use std::f64::consts::PI;

use super::RenderError;
use super::view::in_range;
use crate::genome::{FilterShape, Sampling, TemporalShape};

/// Most moments of a frame: each is a genome, compiled.
const MAX_MOMENTS: u32 = 10_000;

/// How the noise of few samples is smoothed. A genome whose `estimator_radius` is 0 switches every filter off.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// Not at all.
    None,
    /// By its measured variance: what two halves of the samples agree on stays. With many samples the filter has no effect.
    #[default]
    Variance,
    /// As flam3 does: every cell is spread by a kernel that narrows with its density, whatever its neighbours are. How far,
    /// the genome says: `estimator_radius`, `estimator_minimum`, `estimator_curve`.
    Flam3,
}

/// A separable spatial filter, a weight for each cell around a pixel.
#[derive(Clone, Debug)]
pub(crate) struct Spatial {
    /// Weights along one axis; they sum to 1.
    weights: Vec<f64>,
}

impl Spatial {
    /// The filter of `shape` and `radius` pixels on `supersample` cells per pixel.
    ///
    /// Its width is of the same parity as `supersample`, so that it lies centred on a pixel.
    pub(crate) fn new(shape: FilterShape, radius: f64, supersample: usize) -> Spatial {
        let support = support(shape);
        let wide = 2.0 * support * supersample as f64 * radius;
        let mut width = wide as usize + 1;
        if (width ^ supersample) & 1 == 1 {
            width += 1;
        }
        let reach = if wide > 0.0 { support * width as f64 / wide } else { 1.0 };
        let at = |cell: usize| ((2 * cell + 1) as f64 / width as f64 - 1.0) * reach;
        let weights: Vec<f64> = (0..width).map(|cell| kernel(shape, at(cell))).collect();
        let sum: f64 = weights.iter().sum();
        if sum.abs() > 0.0 {
            return Spatial { weights: weights.iter().map(|weight| weight / sum).collect() };
        }
        Spatial { weights: (0..width).map(|cell| f64::from(u8::from(cell == width / 2))).collect() }
    }

    /// Cells along one axis.
    pub(crate) fn width(&self) -> usize {
        self.weights.len()
    }

    /// Weights along one axis.
    pub(crate) fn weights(&self) -> &[f64] {
        &self.weights
    }
}

/// Where a kernel ends.
fn support(shape: FilterShape) -> f64 {
    match shape {
        FilterShape::Box => 0.5,
        FilterShape::Hermite
        | FilterShape::Triangle
        | FilterShape::Blackman
        | FilterShape::Hanning
        | FilterShape::Hamming => 1.0,
        FilterShape::Gaussian | FilterShape::Bell | FilterShape::Quadratic => 1.5,
        FilterShape::BSpline | FilterShape::Mitchell | FilterShape::Catrom | FilterShape::Lanczos2 => 2.0,
        FilterShape::Lanczos3 => 3.0,
    }
}

/// A kernel's value at `t`, inside or outside its support.
fn kernel(shape: FilterShape, t: f64) -> f64 {
    let x = t.abs();
    let inside = |reach: f64, value: f64| if x < reach { value } else { 0.0 };
    match shape {
        FilterShape::Gaussian => libm::exp(-2.0 * x * x),
        FilterShape::Hermite => inside(1.0, (2.0 * x - 3.0) * x * x + 1.0),
        FilterShape::Box => f64::from(u8::from(t > -0.5 && t <= 0.5)),
        FilterShape::Triangle => inside(1.0, 1.0 - x),
        FilterShape::Bell | FilterShape::Quadratic => {
            if x < 0.5 {
                0.75 - x * x
            } else {
                inside(1.5, 0.5 * (x - 1.5).powi(2))
            }
        }
        FilterShape::BSpline => cubic(x, 1.0, 0.0),
        FilterShape::Mitchell => cubic(x, 1.0 / 3.0, 1.0 / 3.0),
        FilterShape::Catrom => cubic(x, 0.0, 0.5),
        FilterShape::Blackman => inside(1.0, 0.42 + 0.5 * libm::cos(PI * x) + 0.08 * libm::cos(2.0 * PI * x)),
        FilterShape::Hanning => inside(1.0, 0.5 + 0.5 * libm::cos(PI * x)),
        FilterShape::Hamming => inside(1.0, 0.54 + 0.46 * libm::cos(PI * x)),
        FilterShape::Lanczos3 => inside(3.0, sinc(x) * sinc(x / 3.0)),
        FilterShape::Lanczos2 => inside(2.0, sinc(x) * sinc(x / 2.0)),
    }
}

/// The two-parameter family of cubics of Mitchell & Netravali.
fn cubic(x: f64, b: f64, c: f64) -> f64 {
    let sum = if x < 1.0 {
        (12.0 - 9.0 * b - 6.0 * c) * x.powi(3) + (-18.0 + 12.0 * b + 6.0 * c) * x * x + (6.0 - 2.0 * b)
    } else if x < 2.0 {
        (-b - 6.0 * c) * x.powi(3) + (6.0 * b + 30.0 * c) * x * x + (-12.0 * b - 48.0 * c) * x + (8.0 * b + 24.0 * c)
    } else {
        0.0
    };
    sum / 6.0
}

fn sinc(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { libm::sin(PI * x) / (PI * x) }
}

/// A moment while the shutter is open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Moment {
    /// Frames from the middle of the exposure.
    pub(crate) offset: f64,
    /// How open the shutter is, `0.0..=1.0`.
    pub(crate) light: f64,
}

/// The moments of one frame, evenly spread over the time that the shutter is open.
/// Errors: [`RenderError::Range`] where there are none, or more than memory should hold.
pub(crate) fn shutter(sampling: &Sampling) -> Result<Vec<Moment>, RenderError> {
    let count = sampling.temporal_samples;
    in_range("temporal_samples", count.into(), (1..=MAX_MOMENTS).contains(&count), "1 to 10000")?;
    if count == 1 {
        return Ok(vec![Moment { offset: 0.0, light: 1.0 }]);
    }
    let place = |i: u32| f64::from(i) / f64::from(count - 1) - 0.5;
    let open = |i: u32| match sampling.temporal_shape {
        TemporalShape::Box => 1.0,
        TemporalShape::Gaussian => kernel(FilterShape::Gaussian, support(FilterShape::Gaussian) * 2.0 * place(i)),
        TemporalShape::Exp => {
            let from_shut = if sampling.temporal_exponent >= 0.0 { i + 1 } else { count - i };
            libm::pow(f64::from(from_shut) / f64::from(count), sampling.temporal_exponent.abs())
        }
    };
    let widest = (0..count).map(open).fold(0.0, f64::max);
    let moment = |i| Moment { offset: place(i) * sampling.temporal_width, light: open(i) / widest };
    Ok((0..count).map(moment).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::genome::Genome;

    #[test]
    fn every_filter_sums_to_one_and_lies_centred() {
        for shape in FilterShape::ALL {
            for (radius, supersample) in [(0.0, 1), (0.5, 1), (1.0, 2), (0.7, 3)] {
                let filter = Spatial::new(*shape, radius, supersample);
                let weights = filter.weights();
                assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-9, "{shape:?}");
                assert_eq!(filter.width() % 2, supersample % 2, "{shape:?}");
                let mirrored = weights.iter().zip(weights.iter().rev());
                assert!(*shape == FilterShape::Box || mirrored.clone().all(|(a, b)| (a - b).abs() < 1e-12));
            }
        }
    }

    #[test]
    fn the_shutter_is_open_for_its_width_and_brightest_once() {
        let mut sampling = Genome::default().sampling;
        sampling.temporal_samples = 5;
        sampling.temporal_width = 1.2;
        for shape in TemporalShape::ALL {
            sampling.temporal_shape = *shape;
            let moments = shutter(&sampling).unwrap();
            assert!((moments[4].offset - moments[0].offset - 1.2).abs() < 1e-12);
            assert_eq!(moments.iter().map(|moment| moment.light).fold(0.0, f64::max), 1.0);
        }
    }
}

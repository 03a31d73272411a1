//! Where in a pixel samples lie, and at which moment of the shutter.
//!
//! Owns the positions: fixed, the same for every pixel, and spread so that all samples count alike although the filter is
//! a tent. Pure arithmetic.
//!
//! Start at [`samples`].

/// Moments in a frame.
pub(crate) const MOMENTS: usize = 4;
/// Samples of every pixel.
pub(crate) const FIRST: usize = 16;
/// Samples of a pixel that is rough, the first ones included.
pub(crate) const ALL: usize = 64;
/// The samples are a square of so many.
const SIDE: usize = 4;

/// A sample of a pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    /// From the pixel's middle, in pixels, -1 to 1: right and down.
    pub(crate) offset: [f32; 2],
    /// The number of its moment.
    pub(crate) moment: usize,
}

/// One sample in the middle of the pixel, at the first moment.
pub(crate) const MIDDLE: Sample = Sample { offset: [0.0; 2], moment: 0 };

/// 16 samples on a rotated grid, then three more such grids between them. Each grid has four samples at each moment, in
/// every row and every column of four one.
pub(crate) fn samples() -> [Sample; ALL] {
    std::array::from_fn(|number| {
        let (grid, column, row) = (number / FIRST, number % SIDE, number % FIRST / SIDE);
        let (right, down) = ((grid & 1) as f64 / 8.0, (grid >> 1) as f64 / 8.0);
        let x = (column as f64 + (row as f64 + 0.5) / SIDE as f64) / SIDE as f64 + right;
        let y = (row as f64 + ((SIDE - 1 - column) as f64 + 0.5) / SIDE as f64) / SIDE as f64 + down;
        Sample { offset: [x, y].map(|part| tent(part.fract()) as f32), moment: (column + row) % MOMENTS }
    })
}

/// Where a tent from -1 to 1 has this part of its weight below.
fn tent(part: f64) -> f64 {
    if part < 0.5 { (2.0 * part).sqrt() - 1.0 } else { 1.0 - (2.0 - 2.0 * part).sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_lie_under_a_tent_and_every_moment_has_a_quarter_of_them_everywhere() {
        let samples = samples();
        for (many, most) in [(FIRST, 0.02), (ALL, 0.005)] {
            for axis in 0..2 {
                let mean = |power: i32| {
                    samples[..many].iter().map(|sample| sample.offset[axis].powi(power)).sum::<f32>() / many as f32
                };
                // A tent has variance 1/6.
                assert!(mean(1).abs() < 1e-5 && (mean(2) - 1.0 / 6.0).abs() < most, "{many}: {} {}", mean(1), mean(2));
            }
            for moment in 0..MOMENTS {
                let of_moment = || samples[..many].iter().filter(|sample| sample.moment == moment);
                assert_eq!(of_moment().count(), many / MOMENTS);
                let mean = of_moment().map(|sample| sample.offset[0]).sum::<f32>() * MOMENTS as f32 / many as f32;
                assert!(mean.abs() < 0.1, "moment {moment}: {mean}");
            }
        }
    }
}

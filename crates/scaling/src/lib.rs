//! Pictures in another size.
//!
//! Owns the filters. They are compiled here, and for as few kinds of pixels and of views as there can be: with the call for
//! all kinds, or in each package that scales, the compiler takes minutes. Never chooses a size, and knows no colours.
//!
//! Start at [`Scaler`].
#![forbid(unsafe_code)]

use fast_image_resize::images::{TypedCroppedImage, TypedImage, TypedImageRef};
use fast_image_resize::pixels::{F32x3, U8};
use fast_image_resize::{FilterType, ResizeAlg, ResizeOptions, Resizer};

/// Scales pictures. Its buffers are kept for the next one of the same size.
#[derive(Debug, Default)]
pub struct Scaler(Resizer);

/// How many samples around its place make a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// Four across and down: sharper than linear, without the ringing of longer filters around thin bright lines.
    CatmullRom,
    /// Six across and down.
    Lanczos3,
}

/// One plane of a picture.
#[derive(Clone, Copy, Debug)]
pub struct Plane<'a> {
    /// Its samples, row by row.
    pub samples: &'a [u8],
    /// Samples from the start of a row to that of the next one; all rows have as many.
    pub stride: usize,
    /// Samples across and down.
    pub size: (u32, u32),
}

/// Samples that are fewer or more than the sizes say, a picture without samples, or a part that lies outside of it.
#[derive(Debug, thiserror::Error)]
#[error("cannot be scaled")]
pub struct ScaleError(#[source] Cause);

/// What the filters say.
type Cause = Box<dyn std::error::Error + Send + Sync>;

impl Scaler {
    /// Scales `plane`, or its part `cut` (left, top, width and height in its samples), to `to`, which has `size`.
    ///
    /// # Errors
    /// [`ScaleError`].
    pub fn plane(
        &mut self,
        plane: Plane<'_>,
        cut: Option<[f64; 4]>,
        filter: Filter,
        size: (u32, u32),
        to: &mut [u8],
    ) -> Result<(), ScaleError> {
        let mut scale = || -> Result<(), Cause> {
            let rows = u32::try_from(plane.samples.len() / plane.stride.max(1))?;
            let from = TypedImageRef::<U8>::from_buffer(u32::try_from(plane.stride)?, rows, plane.samples)?;
            let from = TypedCroppedImage::from_ref(&from, 0, 0, plane.size.0, plane.size.1)?;
            let mut to = TypedImage::<U8>::from_buffer(size.0, size.1, to)?;
            Ok(self.0.resize_typed(&from, &mut to, &options(filter, cut))?)
        };
        scale().map_err(ScaleError)
    }

    /// The picture `rgb`, three bytes a pixel, of `full` size in another `size`, by [`Filter::Lanczos3`].
    ///
    /// # Errors
    /// [`ScaleError`].
    pub fn rgb8(&mut self, rgb: &[u8], full: (u32, u32), size: (u32, u32)) -> Result<Vec<u8>, ScaleError> {
        // As the filters do it, but by those for planes: first down the columns, where colours do not matter, to whole
        // numbers; then along the rows, colour by colour.
        let [wide, across, down] = [3 * full.0, size.0, size.1];
        let rows = Plane { samples: rgb, stride: wide as usize, size: (wide, full.1) };
        let (mut low, mut small) = (vec![0; (wide * down) as usize], vec![0; (across * down) as usize]);
        self.plane(rows, None, Filter::Lanczos3, (wide, down), &mut low)?;
        let mut scaled = vec![0; 3 * small.len()];
        for colour in 0..3 {
            let samples: Vec<u8> = low.chunks_exact(3).map(|pixel| pixel[colour]).collect();
            let plane = Plane { samples: &samples, stride: full.0 as usize, size: (full.0, down) };
            self.plane(plane, None, Filter::Lanczos3, size, &mut small)?;
            scaled.chunks_exact_mut(3).zip(&small).for_each(|(pixel, sample)| pixel[colour] = *sample);
        }
        Ok(scaled)
    }

    /// The picture `rgb`, three numbers a pixel, of `full` size, or its part `cut`, in another `size`, by
    /// [`Filter::Lanczos3`].
    ///
    /// # Errors
    /// [`ScaleError`].
    pub fn rgb_f32(
        &mut self,
        rgb: &[f32],
        full: (u32, u32),
        cut: Option<[f64; 4]>,
        size: (u32, u32),
    ) -> Result<Vec<f32>, ScaleError> {
        let mut scale = || -> Result<Vec<f32>, Cause> {
            let pixels = rgb.chunks_exact(3).map(|p| F32x3::new([p[0], p[1], p[2]])).collect();
            // A view as that of the filters' own buffer: another one would have them compiled twice.
            let from = TypedImage::from_pixels(full.0, full.1, pixels)?;
            let mut to = TypedImage::<F32x3>::new(size.0, size.1);
            self.0.resize_typed(&from, &mut to, &options(Filter::Lanczos3, cut))?;
            Ok(to.pixels().iter().flat_map(|pixel| pixel.0).collect())
        };
        scale().map_err(ScaleError)
    }
}

fn options(filter: Filter, cut: Option<[f64; 4]>) -> ResizeOptions {
    let filter = match filter {
        Filter::CatmullRom => FilterType::CatmullRom,
        Filter::Lanczos3 => FilterType::Lanczos3,
    };
    let options = ResizeOptions::new().resize_alg(ResizeAlg::Convolution(filter));
    cut.map_or(options, |[left, top, width, height]| options.crop(left, top, width, height))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bytes that no filter leaves alone.
    fn noise(count: usize) -> Vec<u8> {
        (0..count).map(|at| (at * at * 37 + at * 101) as u8).collect()
    }

    #[test]
    fn bytes_are_scaled_to_these_very_bits() {
        let samples = noise(60);
        let plane = Plane { samples: &samples, stride: 10, size: (8, 6) };
        let scaled = |cut, filter| {
            let mut to = [0; 6];
            Scaler::default().plane(plane, cut, filter, (3, 2), &mut to).unwrap();
            to
        };
        assert_eq!(scaled(None, Filter::CatmullRom), [120, 153, 135, 74, 132, 149]);
        assert_eq!(scaled(None, Filter::Lanczos3), [121, 152, 136, 73, 134, 148]);
        assert_eq!(scaled(Some([0.5, 1.25, 6.0, 4.0]), Filter::Lanczos3), [127, 152, 143, 68, 108, 156]);
        let colours = Scaler::default().rgb8(&noise(90), (6, 5), (2, 2)).unwrap();
        assert_eq!(colours, [106, 140, 144, 125, 100, 176, 126, 97, 91, 130, 132, 127]);
    }

    #[test]
    fn floats_are_scaled_as_bytes_are() {
        let bytes = noise(90);
        let floats: Vec<f32> = bytes.iter().map(|byte| f32::from(*byte)).collect();
        let cut = Some([0.5, 0.25, 4.0, 4.5]);
        let scaled = Scaler::default().rgb_f32(&floats, (6, 5), cut, (2, 2)).unwrap();
        for colour in 0..3 {
            let samples: Vec<u8> = bytes.iter().skip(colour).step_by(3).copied().collect();
            let mut due = [0; 4];
            let plane = Plane { samples: &samples, stride: 6, size: (6, 5) };
            Scaler::default().plane(plane, cut, Filter::Lanczos3, (2, 2), &mut due).unwrap();
            for (found, due) in scaled.chunks(3).zip(due) {
                assert!((found[colour].clamp(0.0, 255.0) - f32::from(due)).abs() < 1.0, "{} for {due}", found[colour]);
            }
        }
    }

    #[test]
    fn what_is_not_there_is_not_scaled() {
        let samples = noise(20);
        let mut to = [7; 4];
        let mut is_refused = |stride, size, cut| {
            let plane = Plane { samples: &samples, stride, size };
            Scaler::default().plane(plane, cut, Filter::Lanczos3, (2, 2), &mut to).is_err()
        };
        assert!(is_refused(5, (5, 5), None) && is_refused(4, (5, 4), None));
        assert!(is_refused(5, (5, 4), Some([1.0, 0.0, 4.5, 4.0])));
        assert_eq!(to, [7; 4]);
    }
}

//! Scales planes and pictures.
//!
//! Owns the only calls of the scaler, which is compiled anew for every type of pixels and of views of them: here, and as
//! few as there can be. Never knows what a picture shows or which shape it should have.
//!
//! Start at [`Scaler::plane`].
#![forbid(unsafe_code)]

use fast_image_resize::images::{TypedCroppedImage, TypedImage, TypedImageRef};
use fast_image_resize::pixels::{F32x3, U8};
use fast_image_resize::{CropBoxError, FilterType, ImageBufferError, ResizeAlg, ResizeError, ResizeOptions, Resizer};

/// How a sample is made of those around its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// Sharper than linear, without the ringing of longer filters around thin bright lines.
    CatmullRom,
    /// The sharpest, of three samples to each side.
    Lanczos3,
}

/// The part that is scaled: left, top, width and height, in samples, which it may divide.
pub type Cut = [f64; 4];

/// Why nothing was scaled.
#[derive(Clone, Copy, Debug, thiserror::Error)]
pub enum ScalingError {
    /// The part sticks out.
    #[error(transparent)]
    Cut(#[from] ResizeError),
    /// There are fewer samples than the size asks for.
    #[error(transparent)]
    Samples(#[from] ImageBufferError),
    /// The row is shorter than the plane is wide.
    #[error(transparent)]
    Stride(#[from] CropBoxError),
}

/// One plane of a picture.
#[derive(Clone, Copy, Debug)]
pub struct Plane<'a> {
    /// `[height][stride]`, row-major.
    pub samples: &'a [u8],
    /// Samples from the start of a row to that of the next, at least the width.
    pub stride: u32,
    /// Width and height in samples.
    pub size: (u32, u32),
}

/// Scales one plane or picture after another. Its buffers are allocated once for each size.
#[derive(Debug, Default)]
pub struct Scaler(Resizer);

impl Scaler {
    /// Scales `plane`, or a part of it, to all of `to`, which is `[height][width]` of `size`.
    ///
    /// # Errors
    /// [`ScalingError`] where samples are missing or the part sticks out; then `to` is as it was.
    pub fn plane(
        &mut self,
        plane: Plane<'_>,
        cut: Option<Cut>,
        filter: Filter,
        to: &mut [u8],
        size: (u32, u32),
    ) -> Result<(), ScalingError> {
        let rows = TypedImageRef::<U8>::from_buffer(plane.stride, plane.size.1, plane.samples)?;
        let from = TypedCroppedImage::from_ref(&rows, 0, 0, plane.size.0, plane.size.1)?;
        let mut to = TypedImage::<U8>::from_buffer(size.0, size.1, to)?;
        Ok(self.0.resize_typed(&from, &mut to, &options(cut, filter))?)
    }

    /// A picture of bytes, `[height][width][3]` of the size `from`, scaled to the size `to`.
    ///
    /// # Errors
    /// [`ScalingError`] where samples are missing.
    pub fn rgb8(
        &mut self,
        rgb: &[u8],
        from: (u32, u32),
        to: (u32, u32),
        filter: Filter,
    ) -> Result<Vec<u8>, ScalingError> {
        // As the scaler does it, but by the code for planes: first down the columns, where colours do not matter, to whole
        // numbers; then along the rows, colour by colour.
        let stride = 3 * from.0;
        let mut low = vec![0; (stride * to.1) as usize];
        self.plane(Plane { samples: rgb, stride, size: (stride, from.1) }, None, filter, &mut low, (stride, to.1))?;
        let (mut small, mut scaled) = (vec![0; (to.0 * to.1) as usize], vec![0; (3 * to.0 * to.1) as usize]);
        for colour in 0..3 {
            let samples: Vec<u8> = low.chunks_exact(3).map(|pixel| pixel[colour]).collect();
            let plane = Plane { samples: &samples, stride: from.0, size: (from.0, to.1) };
            self.plane(plane, None, filter, &mut small, to)?;
            scaled.chunks_exact_mut(3).zip(&small).for_each(|(pixel, sample)| pixel[colour] = *sample);
        }
        Ok(scaled)
    }

    /// A picture of floats, `[height][width][3]` of the size `from`, or a part of it, scaled to the size `to`.
    ///
    /// # Errors
    /// [`ScalingError`] where samples are missing or the part sticks out.
    pub fn rgb_f32(
        &mut self,
        rgb: &[f32],
        from: (u32, u32),
        cut: Option<Cut>,
        to: (u32, u32),
        filter: Filter,
    ) -> Result<Vec<[f32; 3]>, ScalingError> {
        let pixels = rgb.chunks_exact(3).map(|p| F32x3::new([p[0], p[1], p[2]])).collect();
        // A view as the scaler's own buffer is: its code would be compiled for another one as well.
        let from = TypedImage::from_pixels(from.0, from.1, pixels).map_err(|_| ImageBufferError::InvalidBufferSize)?;
        let mut small = TypedImage::<F32x3>::new(to.0, to.1);
        self.0.resize_typed(&from, &mut small, &options(cut, filter))?;
        Ok(small.pixels().iter().map(|pixel| pixel.0).collect())
    }
}

fn options(cut: Option<Cut>, filter: Filter) -> ResizeOptions {
    let filter = match filter {
        Filter::CatmullRom => FilterType::CatmullRom,
        Filter::Lanczos3 => FilterType::Lanczos3,
    };
    let options = ResizeOptions::new().resize_alg(ResizeAlg::Convolution(filter));
    match cut {
        Some([left, top, width, height]) => options.crop(left, top, width, height),
        None => options,
    }
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
            Scaler::default().plane(plane, cut, filter, &mut to, (3, 2)).unwrap();
            to
        };
        assert_eq!(scaled(None, Filter::CatmullRom), [120, 153, 135, 74, 132, 149]);
        assert_eq!(scaled(None, Filter::Lanczos3), [121, 152, 136, 73, 134, 148]);
        assert_eq!(scaled(Some([0.5, 1.25, 6.0, 4.0]), Filter::Lanczos3), [127, 152, 143, 68, 108, 156]);
        let colours = Scaler::default().rgb8(&noise(90), (6, 5), (2, 2), Filter::Lanczos3).unwrap();
        assert_eq!(colours, [106, 140, 144, 125, 100, 176, 126, 97, 91, 130, 132, 127]);
    }

    #[test]
    fn floats_are_scaled_as_bytes_are() {
        let bytes = noise(90);
        let floats: Vec<f32> = bytes.iter().map(|byte| f32::from(*byte)).collect();
        let cut = Some([0.5, 0.25, 4.0, 4.5]);
        let scaled = Scaler::default().rgb_f32(&floats, (6, 5), cut, (2, 2), Filter::Lanczos3).unwrap();
        for colour in 0..3 {
            let samples: Vec<u8> = bytes.iter().skip(colour).step_by(3).copied().collect();
            let mut due = [0; 4];
            let plane = Plane { samples: &samples, stride: 6, size: (6, 5) };
            Scaler::default().plane(plane, cut, Filter::Lanczos3, &mut due, (2, 2)).unwrap();
            for (found, due) in scaled.iter().zip(due) {
                assert!((found[colour].clamp(0.0, 255.0) - f32::from(due)).abs() < 1.0, "{} for {due}", found[colour]);
            }
        }
    }

    #[test]
    fn what_is_not_there_is_not_scaled() {
        let samples = noise(20);
        let mut to = [7; 4];
        let mut refused = |stride, size, cut| {
            let plane = Plane { samples: &samples, stride, size };
            Scaler::default().plane(plane, cut, Filter::Lanczos3, &mut to, (2, 2)).unwrap_err()
        };
        assert!(matches!(refused(5, (5, 5), None), ScalingError::Samples(_)));
        assert!(matches!(refused(4, (5, 4), None), ScalingError::Stride(_)));
        assert!(matches!(refused(5, (5, 4), Some([1.0, 0.0, 4.5, 4.0])), ScalingError::Cut(_)));
        assert_eq!(to, [7; 4]);
    }
}

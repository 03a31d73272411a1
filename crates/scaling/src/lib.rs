//! Pictures in another size.
//!
//! Owns the filters. They are compiled here, once for each kind of samples: with the call for all kinds, or in each package
//! that scales, the compiler takes minutes. Never chooses a size, and knows no colours.
//!
//! Start at [`Scaler`].
#![forbid(unsafe_code)]

use fast_image_resize::images::{TypedCroppedImage, TypedImage, TypedImageRef};
use fast_image_resize::pixels::{F32x3, U8, U8x3};
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
        let mut scale = || -> Result<Vec<u8>, Cause> {
            let from = TypedImageRef::<U8x3>::from_buffer(full.0, full.1, rgb)?;
            let mut to = TypedImage::<U8x3>::new(size.0, size.1);
            self.0.resize_typed(&from, &mut to, &options(Filter::Lanczos3, None))?;
            Ok(to.pixels().iter().flat_map(|pixel| pixel.0).collect())
        };
        scale().map_err(ScaleError)
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
            let pixels: Vec<F32x3> = rgb.chunks_exact(3).map(|p| F32x3::new([p[0], p[1], p[2]])).collect();
            let from = TypedImageRef::new(full.0, full.1, &pixels)?;
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

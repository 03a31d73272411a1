//! Pictures in 4:2:0, and their conversion from and to RGB.
//!
//! Owns the conversion between display RGB and BT.709 limited-range 4:2:0. Tone and size are kept: the input is already
//! gamma-coded for the display.
//!
//! Start at [`Yuv420p::from_rgb16`]; `encoder.rs` takes the result.

use crate::frame::Frame;

/// BT.709 luma weights of red, green and blue. `screen` cannot see this crate and has its own copy; a test compares them.
pub(crate) const WEIGHTS: [f32; 3] = [0.2126, 0.7152, 0.0722];
/// What `B - Y` and `R - Y` are divided by to lie within half a unit.
const SPAN: [f32; 2] = [2.0 * (1.0 - WEIGHTS[2]), 2.0 * (1.0 - WEIGHTS[0])];

/// One 8-bit planar 4:2:0 picture in memory: BT.709, limited range, chroma sited left (H.264's default): between two
/// rows, on every other column.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Yuv420p {
    size: (u32, u32),
    planes: [Vec<u8>; 3],
}

/// Why samples do not make a picture.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PictureError {
    /// The number of samples does not fit the size.
    #[error("a picture of {width}x{height} has {expected} samples (found {found})")]
    Samples {
        /// Its width.
        width: u32,
        /// Its height.
        height: u32,
        /// Three per pixel of RGB, three for two pixels of 4:2:0.
        expected: usize,
        /// How many there are.
        found: usize,
    },
    /// 4:2:0 needs even sides.
    #[error("a picture of {width}x{height} cannot be 4:2:0: both sides must be even and at least 2")]
    Size {
        /// Its width.
        width: u32,
        /// Its height.
        height: u32,
    },
}

impl Yuv420p {
    /// Converts display RGB, rounding every sample to the nearest value.
    ///
    /// * `rgb`: `[height][width][3]`, row-major, full range, BT.709 primaries, gamma-coded.
    /// * Chroma is the average over two rows and, weighted 1 2 1, three columns around its site.
    ///
    /// # Errors
    /// [`PictureError`] if a side is odd or the number of samples is not `3 * width * height`.
    ///
    /// # Source
    /// ITU-R BT.709-6, items 3.2 to 3.4 (8 bit quantisation), with the averaged chroma of H.264's left siting.
    pub fn from_rgb16(width: u32, height: u32, rgb: &[u16]) -> Result<Self, PictureError> {
        Self::from_rgb(width, height, &unit(rgb), |_, _| 0.5)
    }

    /// Converts as [`Yuv420p::from_rgb16`] does, but dithers, against banding in dark gradients, with a fixed pattern
    /// without visible structure. The pattern is the same on every frame, so that it compresses well and a loop stays a
    /// loop.
    ///
    /// # Errors
    /// As [`Yuv420p::from_rgb16`].
    ///
    /// # Source
    /// Jorge Jimenez, *Next Generation Post Processing in Call of Duty* (2014): interleaved gradient noise.
    pub fn from_rgb16_dithered(width: u32, height: u32, rgb: &[u16]) -> Result<Self, PictureError> {
        Self::from_rgb(width, height, &unit(rgb), gradient_noise)
    }

    /// Converts RGB in `0.0..=1.0` (outside is clipped); otherwise as [`Yuv420p::from_rgb16`].
    ///
    /// # Errors
    /// As [`Yuv420p::from_rgb16`].
    pub fn from_rgb_f32(width: u32, height: u32, rgb: &[f32]) -> Result<Self, PictureError> {
        Self::from_rgb(width, height, rgb, |_, _| 0.5)
    }

    /// A picture from its planes as [`Yuv420p::planes`] gives them.
    ///
    /// # Errors
    /// [`PictureError`] if a side is odd or the samples of all planes are not `3 / 2 * width * height`.
    pub fn from_planes(width: u32, height: u32, samples: &[u8]) -> Result<Self, PictureError> {
        check_sides(width, height)?;
        let luma = width as usize * height as usize;
        if samples.len() != luma * 3 / 2 {
            return Err(PictureError::Samples { width, height, expected: luma * 3 / 2, found: samples.len() });
        }
        let (y, chroma) = samples.split_at(luma);
        let (u, v) = chroma.split_at(luma / 4);
        Ok(Self { size: (width, height), planes: [y, u, v].map(<[u8]>::to_vec) })
    }

    /// A picture of these planes, which are not copied; `None` if they are not of its size, or a side is odd.
    pub(crate) fn of(size: (u32, u32), planes: [Vec<u8>; 3]) -> Option<Self> {
        let luma = size.0 as usize * size.1 as usize;
        let fits = planes.each_ref().map(Vec::len) == [luma, luma / 4, luma / 4];
        (fits && check_sides(size.0, size.1).is_ok()).then_some(Self { size, planes })
    }

    /// `threshold` is added before rounding down: 0.5 rounds to nearest.
    fn from_rgb(w: u32, h: u32, rgb: &[f32], threshold: impl Fn(u32, u32) -> f32) -> Result<Self, PictureError> {
        check_sides(w, h)?;
        let (width, height) = (w as usize, h as usize);
        let expected = 3 * width * height;
        if rgb.len() != expected {
            return Err(PictureError::Samples { width: w, height: h, expected, found: rgb.len() });
        }
        let pixel = |x: usize, y: usize| [0, 1, 2].map(|c| rgb[3 * (y * width + x) + c].clamp(0.0, 1.0));
        let mut planes =
            [Vec::with_capacity(width * height), Vec::with_capacity(expected / 12), Vec::with_capacity(expected / 12)];
        for y in 0..height {
            planes[0].extend((0..width).map(|x| {
                let level = 16.0 + 219.0 * luma(pixel(x, y));
                (level + threshold(x as u32, y as u32)) as u8
            }));
        }
        for y in 0..height / 2 {
            for x in 0..width / 2 {
                let (left, middle, right) = ((2 * x).saturating_sub(1), 2 * x, (2 * x + 1).min(width - 1));
                let taps = [(left, 1.0), (middle, 2.0), (right, 1.0)];
                let mut mean = [0.0f32; 3];
                for (column, weight) in taps {
                    let (above, below) = (pixel(column, 2 * y), pixel(column, 2 * y + 1));
                    for c in 0..3 {
                        mean[c] += weight / 8.0 * (above[c] + below[c]);
                    }
                }
                let y_mean = luma(mean);
                for (plane, difference, span) in [(1, mean[2] - y_mean, SPAN[0]), (2, mean[0] - y_mean, SPAN[1])] {
                    let level = 128.0 + 224.0 * difference / span;
                    // Each plane uses another part of the pattern, so that the three do not step together.
                    let offset = 29 * plane as u32;
                    planes[plane].push((level + threshold(x as u32 + offset, y as u32)) as u8);
                }
            }
        }
        Ok(Self { size: (w, h), planes })
    }

    /// Visible width and height, both even.
    pub fn size(&self) -> (u32, u32) {
        self.size
    }

    /// Y, U and V, row-major without padding.
    pub fn planes(&self) -> [&[u8]; 3] {
        self.planes.each_ref().map(Vec::as_slice)
    }

    /// Bytes from one row to the next of Y, U and V.
    pub fn strides(&self) -> [usize; 3] {
        [1, 2, 2].map(|part| self.size.0 as usize / part)
    }

    /// The picture as 8-bit RGB for looking at: `[height][width][3]`, row-major. Chroma is interpolated linearly.
    pub fn to_rgb8(&self) -> Vec<u8> {
        let (width, height) = (self.size.0 as usize, self.size.1 as usize);
        let mut rgb = Vec::with_capacity(3 * width * height);
        for y in 0..height {
            for x in 0..width {
                let luma = (f32::from(self.planes[0][y * width + x]) - 16.0) / 219.0;
                let [blue, red] = [1, 2].map(|plane| (self.chroma(plane, x, y) - 128.0) / 224.0);
                let (b, r) = (luma + blue * SPAN[0], luma + red * SPAN[1]);
                let g = (luma - WEIGHTS[0] * r - WEIGHTS[2] * b) / WEIGHTS[1];
                rgb.extend([r, g, b].map(|level| (level.clamp(0.0, 1.0) * 255.0 + 0.5) as u8));
            }
        }
        rgb
    }

    /// The chroma plane `plane` at a luma position, undoing the siting.
    fn chroma(&self, plane: usize, x: usize, y: usize) -> f32 {
        let (width, height) = (self.size.0 as usize / 2, self.size.1 as usize / 2);
        let at = |x: usize, y: usize| f32::from(self.planes[plane][y.min(height - 1) * width + x.min(width - 1)]);
        let other = if y.is_multiple_of(2) { (y / 2).saturating_sub(1) } else { y / 2 + 1 };
        let column = |x: usize| 0.75 * at(x, y / 2) + 0.25 * at(x, other);
        if x.is_multiple_of(2) { column(x / 2) } else { 0.5 * (column(x / 2) + column(x / 2 + 1)) }
    }
}

impl From<&Frame> for Yuv420p {
    /// Copies the visible part of a decoded frame, cut to even sides.
    fn from(frame: &Frame) -> Self {
        let size = (frame.size().0 & !1, frame.size().1 & !1);
        let planes = [0usize, 1, 2].map(|plane| {
            let chroma = u32::from(plane > 0);
            let (width, height) = ((size.0 >> chroma) as usize, (size.1 >> chroma) as usize);
            let rows = frame.planes()[plane].chunks(frame.strides()[plane].max(1)).take(height);
            rows.flat_map(|row| &row[..width]).copied().collect()
        });
        Self { size, planes }
    }
}

fn check_sides(width: u32, height: u32) -> Result<(), PictureError> {
    let even = |side: u32| side > 0 && side.is_multiple_of(2);
    if even(width) && even(height) { Ok(()) } else { Err(PictureError::Size { width, height }) }
}

fn unit(rgb: &[u16]) -> Vec<f32> {
    rgb.iter().map(|level| f32::from(*level) / 65535.0).collect()
}

fn luma(rgb: [f32; 3]) -> f32 {
    WEIGHTS[0] * rgb[0] + WEIGHTS[1] * rgb[1] + WEIGHTS[2] * rgb[2]
}

/// A threshold in `0.0..1.0` for a pixel: neighbours differ strongly, any 3x3 block has about the mean of all.
fn gradient_noise(x: u32, y: u32) -> f32 {
    let ramp = 0.067_110_56 * f64::from(x) + 0.005_837_15 * f64::from(y);
    (52.982_918_9 * ramp.fract()).fract() as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat(rgb: [u16; 3]) -> [u8; 3] {
        let picture = Yuv420p::from_rgb16(4, 2, &rgb.repeat(8)).unwrap();
        picture.planes().map(|plane| plane[0])
    }

    #[test]
    fn the_standards_colours_have_the_standards_codes() {
        const ON: u16 = u16::MAX;
        assert_eq!(flat([0, 0, 0]), [16, 128, 128]);
        assert_eq!(flat([ON, ON, ON]), [235, 128, 128]);
        assert_eq!(flat([ON, 0, 0]), [63, 102, 240]);
        assert_eq!(flat([0, ON, 0]), [173, 42, 26]);
        assert_eq!(flat([0, 0, ON]), [32, 240, 118]);
    }

    #[test]
    fn smooth_pictures_come_back_within_four_steps_of_256() {
        let (width, height) = (64u32, 32u32);
        let level = |x: u32, y: u32| [512 * x as u16, 1024 * y as u16, 512 * (63 - x) as u16 + 512 * y as u16];
        let rgb: Vec<u16> = (0..height).flat_map(|y| (0..width).flat_map(move |x| level(x, y))).collect();
        let back = Yuv420p::from_rgb16(width, height, &rgb).unwrap().to_rgb8();
        for (place, (before, after)) in rgb.iter().zip(&back).enumerate() {
            let (before, after) = (f32::from(*before) / 257.0, f32::from(*after));
            assert!((before - after).abs() <= 4.0, "sample {place}: {before} became {after}");
        }
    }

    #[test]
    fn dither_keeps_the_mean_of_a_dark_level_between_two_steps() {
        let rgb = vec![1000u16; 3 * 64 * 64];
        let picture = Yuv420p::from_rgb16_dithered(64, 64, &rgb).unwrap();
        let mean = picture.planes()[0].iter().map(|y| f64::from(*y)).sum::<f64>() / 4096.0;
        assert!((mean - (16.0 + 219.0 * 1000.0 / 65535.0)).abs() < 0.02, "{mean}");
        assert!([19, 20].iter().all(|step| picture.planes()[0].contains(step)));
    }

    #[test]
    fn pixels_that_make_no_picture_are_refused_with_both_values() {
        let odd = Yuv420p::from_rgb16(3, 2, &[0; 18]).unwrap_err();
        assert_eq!(odd.to_string(), "a picture of 3x2 cannot be 4:2:0: both sides must be even and at least 2");
        let short = Yuv420p::from_rgb16(2, 2, &[0; 11]).unwrap_err();
        assert_eq!(short.to_string(), "a picture of 2x2 has 12 samples (found 11)");
    }
}

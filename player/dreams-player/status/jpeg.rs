//! The picture on the glass as a JPEG.
//!
//! Owns the way from BT.709 limited range to what a JPEG has, BT.601 full range, and the small picture of reports. Never decides who gets it.

use jpeg_encoder::{Encoder, ImageBuffer, JpegColorType, SamplingFactor};
use screen::Picture;

/// Good enough that a viewer sees the flame, not the blocks.
const QUALITY: u8 = 85;
/// Of a small picture, which has 64 KiB at most.
const SMALL_QUALITY: u8 = 60;
/// Pixels of a small picture's longer side, at most.
const SMALL: u32 = 480;

/// Encodes `picture`. Some 10 ms at 1280x720.
pub(crate) fn encode(picture: &Picture<'_>) -> Vec<u8> {
    encode_rows(Rows { picture: *picture, side: 1 }, QUALITY)
}

/// Encodes `picture` with at most 480 pixels a side: each of them is the mean of a square of its pixels.
pub(crate) fn encode_small(picture: &Picture<'_>) -> Vec<u8> {
    let side = picture.width.max(picture.height).div_ceil(SMALL) as usize;
    encode_rows(Rows { picture: *picture, side }, SMALL_QUALITY)
}

fn encode_rows(rows: Rows<'_>, quality: u8) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, quality);
    encoder.set_sampling_factor(SamplingFactor::F_2_2);
    encoder.encode_image(rows).expect("a flock's picture has a JPEG's size, and memory takes every byte");
    bytes
}

/// A picture, of which squares of `side` pixels a side become one.
struct Rows<'a> {
    picture: Picture<'a>,
    side: usize,
}

impl Rows<'_> {
    fn pixels(&self, of: u32) -> u16 {
        u16::try_from(of as usize / self.side).unwrap_or(u16::MAX)
    }

    /// The mean of a plane over the square of pixel (`x`, `y`); a plane of chroma has half the pixels each way.
    fn mean(&self, plane: usize, x: usize, y: usize) -> u8 {
        let (rows, stride) = (self.picture.planes[plane], self.picture.strides[plane]);
        let half = usize::from(plane > 0);
        if self.side == 1 {
            return rows[(y >> half) * stride + (x >> half)];
        }
        let row = |y: usize| {
            (x * self.side..(x + 1) * self.side).map(move |x| u32::from(rows[(y >> half) * stride + (x >> half)]))
        };
        let sum: u32 = (y * self.side..(y + 1) * self.side).flat_map(row).sum();
        let count = (self.side * self.side) as u32;
        ((sum + count / 2) / count) as u8
    }
}

impl ImageBuffer for Rows<'_> {
    fn get_jpeg_color_type(&self) -> JpegColorType {
        JpegColorType::Ycbcr
    }

    fn width(&self) -> u16 {
        self.pixels(self.picture.width)
    }

    fn height(&self) -> u16 {
        self.pixels(self.picture.height)
    }

    fn fill_buffers(&self, y: u16, buffers: &mut [Vec<u8>; 4]) {
        let row = usize::from(y);
        for x in 0..usize::from(self.width()) {
            let [y, cb, cr] = converted(self.mean(0, x, row), self.mean(1, x, row), self.mean(2, x, row));
            buffers[0].push(y);
            buffers[1].push(cb);
            buffers[2].push(cr);
        }
    }
}

/// One sample, from BT.709 limited range to BT.601 full range. The factors are the two standards' matrices
/// multiplied out: R'G'B' from 709, then `Y'CbCr` by 601.
fn converted(y: u8, u: u8, v: u8) -> [u8; 3] {
    let y = (f32::from(y) - 16.0) * (255.0 / 219.0);
    let cb = (f32::from(u) - 128.0) * (255.0 / 224.0);
    let cr = (f32::from(v) - 128.0) * (255.0 / 224.0);
    [y + 0.1016 * cb + 0.1961 * cr, 128.0 + 0.9899 * cb - 0.1107 * cr, 128.0 + 0.9834 * cr - 0.0725 * cb]
        .map(|sample| (sample + 0.5) as u8)
}

#[cfg(test)]
mod tests {
    use super::{Picture, SMALL, converted, encode, encode_small};
    use crate::stream::FaultCard;

    #[test]
    fn black_white_and_the_primaries_keep_their_colour() {
        // BT.709 limited range of R'G'B', and BT.601 full range of the same (both matrices by hand).
        let cases = [
            ([16, 128, 128], [0, 128, 128]),
            ([235, 128, 128], [255, 128, 128]),
            ([63, 102, 240], [76, 85, 255]),
            ([173, 42, 26], [150, 44, 21]),
            ([32, 240, 118], [29, 255, 107]),
        ];
        for ([y, u, v], expected) in cases {
            let found = converted(y, u, v);
            assert!(found.iter().zip(expected).all(|(a, b)| a.abs_diff(b) <= 1), "{found:?} is not {expected:?}");
        }
    }

    #[test]
    fn a_small_picture_is_small_whatever_is_on_it() {
        // Noise, the worst case of all pictures.
        let (width, height) = (1280_usize, 720);
        let mut state = 7_u32;
        let mut noise = |count: usize| -> Vec<u8> {
            let mut next = || {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (state >> 24) as u8
            };
            (0..count).map(|_| next()).collect()
        };
        let planes = [noise(width * height), noise(width * height / 4), noise(width * height / 4)];
        let picture = Picture {
            planes: [&planes[0], &planes[1], &planes[2]],
            strides: [width, width / 2, width / 2],
            width: width as u32,
            height: height as u32,
        };
        let jpeg = encode_small(&picture);
        assert!(jpeg.len() <= 64 << 10, "{} bytes", jpeg.len());
        // The size stands in the frame's header: marker, length, precision, height, width.
        let at = jpeg.windows(2).position(|marker| marker == [0xff, 0xc0]).unwrap() + 5;
        let size = [at, at + 2].map(|at| u32::from(u16::from_be_bytes([jpeg[at], jpeg[at + 1]])));
        assert_eq!(size, [240, 426]);
        assert!(size.iter().all(|side| *side <= SMALL));
    }

    #[test]
    fn a_picture_becomes_a_whole_jpeg() {
        let jpeg = encode(&FaultCard::draw((64, 48)).picture());
        assert_eq!((&jpeg[..2], &jpeg[jpeg.len() - 2..]), (&[0xff, 0xd8][..], &[0xff, 0xd9][..]));
    }
}

//! The picture on the glass as a JPEG.
//!
//! Owns the way from BT.709 limited range to what a JPEG has, BT.601 full range. Never decides who gets it.

use jpeg_encoder::{Encoder, ImageBuffer, JpegColorType, SamplingFactor};
use screen::Picture;

/// Good enough that a viewer sees the flame, not the blocks.
const QUALITY: u8 = 85;

/// Encodes `picture`. Some 10 ms at 1280x720.
pub(crate) fn encode(picture: &Picture<'_>) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, QUALITY);
    encoder.set_sampling_factor(SamplingFactor::F_2_2);
    encoder.encode_image(Rows(*picture)).expect("a flock's picture has a JPEG's size, and memory takes every byte");
    bytes
}

struct Rows<'a>(Picture<'a>);

impl ImageBuffer for Rows<'_> {
    fn get_jpeg_color_type(&self) -> JpegColorType {
        JpegColorType::Ycbcr
    }

    fn width(&self) -> u16 {
        u16::try_from(self.0.width).unwrap_or(u16::MAX)
    }

    fn height(&self) -> u16 {
        u16::try_from(self.0.height).unwrap_or(u16::MAX)
    }

    fn fill_buffers(&self, y: u16, buffers: &mut [Vec<u8>; 4]) {
        let picture = &self.0;
        let row = |plane: usize, y: usize| &picture.planes[plane][y * picture.strides[plane]..];
        let y = usize::from(y);
        let (luma, blue, red) = (row(0, y), row(1, y / 2), row(2, y / 2));
        for x in 0..picture.width as usize {
            let [y, cb, cr] = converted(luma[x], blue[x / 2], red[x / 2]);
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
    use super::{converted, encode};
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
    fn a_picture_becomes_a_whole_jpeg() {
        let jpeg = encode(&FaultCard::draw((64, 48)).picture());
        assert_eq!((&jpeg[..2], &jpeg[jpeg.len() - 2..]), (&[0xff, 0xd8][..], &[0xff, 0xd9][..]));
    }
}

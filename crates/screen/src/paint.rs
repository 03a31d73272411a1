//! Writing a picture into a scan-out buffer.
//!
//! Owns the pixel formats that we scan out, their memory layout, and the copy into it. Buffers are not read, because
//! they may be write-combined. Start at [`paint`].

use crate::Picture;
use crate::convert::xrgb_row;

/// A pixel format that we can write, the cheapest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Three planes, 4:2:0: the decoder's format.
    Yu12,
    /// Luma, and interleaved chroma, 4:2:0.
    Nv12,
    /// 8 bits each of blue, green, red and unused.
    Xr24,
}

impl Format {
    /// All of them, best first.
    pub const ALL: [Self; 3] = [Self::Yu12, Self::Nv12, Self::Xr24];

    /// Its four characters, as `drm_fourcc.h` has them.
    pub fn name(self) -> &'static str {
        match self {
            Self::Yu12 => "YU12",
            Self::Nv12 => "NV12",
            Self::Xr24 => "XR24",
        }
    }

    /// The kernel's number for it.
    pub fn fourcc(self) -> u32 {
        self.name().bytes().rev().fold(0, |code, byte| code << 8 | u32::from(byte))
    }

    /// Whether the plane must convert it to RGB.
    pub fn is_yuv(self) -> bool {
        self != Self::Xr24
    }

    /// Width, height and bits per pixel of the single allocation that holds an image of `size`.
    pub fn allocation(self, (width, height): (u32, u32)) -> (u32, u32, u32) {
        match self {
            Self::Yu12 | Self::Nv12 => (width, height + height / 2, 8),
            Self::Xr24 => (width, height, 32),
        }
    }
}

/// Where an image's planes lie in its allocation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// How the pixels are stored.
    pub format: Format,
    /// Pixels across and down, even.
    pub size: (u32, u32),
    /// Bytes per row of each plane, 0 where there is no such plane.
    pub pitches: [u32; 4],
    /// First byte of each plane.
    pub offsets: [u32; 4],
}

impl Layout {
    /// The layout of an image of `size` in an allocation whose rows are `pitch` bytes apart.
    pub fn new(format: Format, size: (u32, u32), pitch: u32) -> Self {
        let luma = pitch * size.1;
        let (pitches, offsets) = match format {
            Format::Yu12 => ([pitch, pitch / 2, pitch / 2, 0], [0, luma, luma + luma / 4, 0]),
            Format::Nv12 => ([pitch, pitch, 0, 0], [0, luma, 0, 0]),
            Format::Xr24 => ([pitch, 0, 0, 0], [0; 4]),
        };
        Self { format, size, pitches, offsets }
    }

    /// Bytes that the image spans.
    pub fn bytes(&self) -> usize {
        self.format.allocation(self.size).1 as usize * self.pitches[0] as usize
    }

    /// The layout of `rows` of the image's rows from row `top` on, both even: an image within the image.
    pub fn part(&self, top: u32, rows: u32) -> Self {
        let offsets =
            std::array::from_fn(|plane| self.offsets[plane] + (top >> self.halved(plane)) * self.pitches[plane]);
        Self { size: (self.size.0, rows), offsets, ..*self }
    }

    /// 1 if `plane` has half the image's rows, else 0.
    fn halved(&self, plane: usize) -> u32 {
        u32::from(self.format.is_yuv() && plane > 0)
    }

    /// The rows of `plane` from `top` on, each from byte `left` on.
    fn rows<'a>(&self, bytes: &'a mut [u8], plane: usize, top: u32, left: u32) -> impl Iterator<Item = &'a mut [u8]> {
        let pitch = self.pitches[plane] as usize;
        let first = self.offsets[plane] as usize + top as usize * pitch;
        bytes[first..].chunks_mut(pitch).map(move |row| &mut row[left as usize..])
    }
}

/// Makes the whole image black.
pub(crate) fn blacken(bytes: &mut [u8], layout: &Layout) {
    let black = if layout.format.is_yuv() { [16, 128, 128] } else { [0; 3] };
    for (plane, black) in black.into_iter().enumerate() {
        let first = layout.offsets[plane] as usize;
        let length = (layout.size.1 >> layout.halved(plane)) * layout.pitches[plane];
        bytes[first..][..length as usize].fill(black);
    }
}

/// Copies `picture` into an image laid out as `layout`, its first pixel at column `left` and row `top`, both even. It must
/// fit there. What lies around it stays as it is.
pub(crate) fn paint(bytes: &mut [u8], layout: &Layout, (left, top): (u32, u32), picture: &Picture<'_>) {
    match layout.format {
        Format::Yu12 => {
            for plane in 0..3 {
                let half = u32::from(plane > 0);
                let (top, left, pitch) = (top >> half, left >> half, layout.pitches[plane] as usize);
                match picture.packed(plane) {
                    // One large copy takes half the time of row by row.
                    Some(rows) if picture.strides[plane] == pitch => {
                        let first = layout.offsets[plane] as usize + top as usize * pitch;
                        bytes[first..][..rows.len()].copy_from_slice(rows);
                    }
                    _ => {
                        for (out, row) in layout.rows(bytes, plane, top, left).zip(picture.rows(plane)) {
                            out[..row.len()].copy_from_slice(row);
                        }
                    }
                }
            }
        }
        Format::Nv12 => {
            for (out, row) in layout.rows(bytes, 0, top, left).zip(picture.rows(0)) {
                out[..row.len()].copy_from_slice(row);
            }
            let chroma = picture.rows(1).zip(picture.rows(2));
            for (out, (u, v)) in layout.rows(bytes, 1, top / 2, left).zip(chroma) {
                for ((pair, &u), &v) in out.chunks_exact_mut(2).zip(u).zip(v) {
                    pair.copy_from_slice(&[u, v]);
                }
            }
        }
        Format::Xr24 => {
            let twice = |row| std::iter::repeat_n(row, 2);
            let chroma = picture.rows(1).zip(picture.rows(2)).flat_map(twice);
            for ((out, y), (u, v)) in layout.rows(bytes, 0, top, left * 4).zip(picture.rows(0)).zip(chroma) {
                xrgb_row(&mut out[..y.len() * 4], y, u, v);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 4x2: luma 1 to 8, chroma (10, 20) and (30, 40).
    const PICTURE: Picture<'static> =
        Picture { width: 4, height: 2, planes: [&[1, 2, 3, 4, 5, 6, 7, 8], &[10, 20], &[30, 40]], strides: [4, 2, 2] };

    fn painted(format: Format, size: (u32, u32), pitch: u32, at: (u32, u32), picture: &Picture<'_>) -> Vec<u8> {
        let layout = Layout::new(format, size, pitch);
        let mut bytes = vec![0; layout.bytes()];
        blacken(&mut bytes, &layout);
        paint(&mut bytes, &layout, at, picture);
        bytes
    }

    #[test]
    fn the_formats_have_the_kernels_numbers() {
        assert_eq!(Format::ALL.map(Format::fourcc), [0x3231_5559, 0x3231_564e, 0x3432_5258]);
    }

    #[test]
    fn yuv_goes_through_unchanged() {
        let three = painted(Format::Yu12, (4, 2), 4, (0, 0), &PICTURE);
        assert_eq!(three, [1, 2, 3, 4, 5, 6, 7, 8, 10, 20, 30, 40]);
        let two = painted(Format::Nv12, (4, 2), 6, (0, 0), &PICTURE);
        assert_eq!(two, [1, 2, 3, 4, 16, 16, 5, 6, 7, 8, 16, 16, 10, 30, 20, 40, 128, 128]);
    }

    #[test]
    fn a_picture_lies_where_it_is_told_to_and_all_around_it_is_black() {
        let bytes = painted(Format::Yu12, (8, 6), 8, (2, 2), &PICTURE);
        let luma: Vec<_> = bytes[..48].chunks(8).collect();
        assert_eq!(luma[1], [16; 8]);
        assert_eq!(luma[2], [16, 16, 1, 2, 3, 4, 16, 16]);
        assert_eq!(luma[3], [16, 16, 5, 6, 7, 8, 16, 16]);
        assert_eq!(luma[4], [16; 8]);
        assert_eq!(bytes[48..60], [128, 128, 128, 128, 128, 10, 20, 128, 128, 128, 128, 128]);
        let rgb = painted(
            Format::Xr24,
            (8, 6),
            32,
            (2, 2),
            &Picture { planes: [&[235; 8], &[128; 2], &[128; 2]], ..PICTURE },
        );
        let white: Vec<_> =
            rgb.chunks(4).enumerate().filter(|(_, pixel)| *pixel == [255; 4]).map(|(at, _)| at).collect();
        assert_eq!(white, [18, 19, 20, 21, 26, 27, 28, 29]);
    }

    #[test]
    fn an_image_within_an_image_leaves_the_others_as_they_are() {
        for format in Format::ALL {
            let pitch = format.allocation((4, 2)).2 / 8 * 4;
            let all = Layout::new(format, (4, 6), pitch);
            let mut bytes = vec![99; all.bytes()];
            blacken(&mut bytes, &all.part(2, 2));
            paint(&mut bytes, &all.part(2, 2), (0, 0), &PICTURE);
            let alone = painted(format, (4, 2), pitch, (0, 0), &PICTURE);
            let touched: Vec<_> = bytes.iter().copied().filter(|&byte| byte != 99).collect();
            assert_eq!(touched, alone, "{format:?}");
            assert_eq!(bytes.len(), 3 * alone.len(), "{format:?}");
        }
    }
}

//! Rotation, scaling and dimming in software, for displays that cannot do it.
//!
//! Owns its buffers, and the order: rotation, scaling, dimming. Steps that the display does itself are skipped.
//! Scan-out buffers are written in `paint.rs`.
//!
//! Start at [`Transformer::apply`].

use crate::output::Rotation;
use crate::picture::{OwnedPicture, Picture};
use scaling::{Filter, Plane, Scaler};
use std::borrow::Cow;

/// Samples of a block that is rotated at a time, across and down: two of them fit into the L1 cache.
const BLOCK: usize = 32;
/// The sample values of black in limited range: luma, and both chromas.
const BLACK: [u8; 3] = [16, 128, 128];

/// A transform of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Transform {
    /// The rotation.
    pub(crate) rotation: Rotation,
    /// Pixels across and down after it, both even.
    pub(crate) size: (u32, u32),
    /// Brightness, in thousandths of every sample.
    pub(crate) thousandths: u16,
}

/// Transforms pictures for a display. Its buffers are allocated once for each size.
#[derive(Debug, Default)]
pub(crate) struct Transformer {
    scaler: Scaler,
    rotated: OwnedPicture,
    scaled: OwnedPicture,
    dimmed: OwnedPicture,
}

impl Transformer {
    /// `picture` after `transform`; the same planes if there is nothing to do.
    pub(crate) fn apply<'a>(&'a mut self, picture: &Picture<'a>, transform: Transform) -> Picture<'a> {
        let mut out = *picture;
        if transform.rotation != Rotation::None {
            rotate(&out, transform.rotation, &mut self.rotated);
            out = self.rotated.view();
        }
        if (out.width, out.height) != transform.size {
            scale(&mut self.scaler, &out, transform.size, &mut self.scaled);
            out = self.scaled.view();
        }
        if transform.thousandths < 1000 {
            dim(&out, transform.thousandths, &mut self.dimmed);
            out = self.dimmed.view();
        }
        out
    }
}

fn rotate(picture: &Picture<'_>, rotation: Rotation, into: &mut OwnedPicture) {
    into.resize(rotation.of_size((picture.width, picture.height)));
    for plane in 0..3 {
        let (width, height) = picture.extent(plane);
        let (from, stride) = (picture.planes[plane], picture.strides[plane]);
        let to = into.plane_mut(plane);
        match rotation {
            Rotation::None => copy(picture.rows(plane), to),
            Rotation::Half => {
                for (row, out) in picture.rows(plane).zip(to.rchunks_exact_mut(width)) {
                    out.iter_mut().rev().zip(row).for_each(|(out, sample)| *out = *sample);
                }
            }
            Rotation::Clockwise90 => {
                blocks(width, height, |x, y| to[x * height + (height - 1 - y)] = from[y * stride + x]);
            }
            Rotation::Clockwise270 => {
                blocks(width, height, |x, y| to[(width - 1 - x) * height + y] = from[y * stride + x]);
            }
        }
    }
}

fn copy<'a>(rows: impl Iterator<Item = &'a [u8]>, to: &mut [u8]) {
    let mut rest = to;
    for row in rows {
        let (out, after) = rest.split_at_mut(row.len());
        out.copy_from_slice(row);
        rest = after;
    }
}

/// Visits every sample of a plane, block by block.
fn blocks(width: usize, height: usize, mut visit: impl FnMut(usize, usize)) {
    for top in (0..height).step_by(BLOCK) {
        for left in (0..width).step_by(BLOCK) {
            for y in top..(top + BLOCK).min(height) {
                for x in left..(left + BLOCK).min(width) {
                    visit(x, y);
                }
            }
        }
    }
}

/// Scales each plane separately: chroma moves by a quarter of a sample at most.
fn scale(scaler: &mut Scaler, picture: &Picture<'_>, size: (u32, u32), into: &mut OwnedPicture) {
    into.resize(size);
    for plane in 0..3 {
        let half = u32::from(plane > 0);
        let (width, height) = picture.extent(plane);
        let stride = picture.strides[plane];
        let rows = whole_rows(picture.planes[plane], stride, height);
        let from = Plane { samples: &rows, stride: stride as u32, size: (width as u32, height as u32) };
        let (to, size) = (into.plane_mut(plane), (size.0 >> half, size.1 >> half));
        // Sharper than linear, without the ringing of longer filters around thin bright lines.
        scaler.plane(from, None, Filter::CatmullRom, to, size).expect("the rows are whole, and `to` is of this size");
    }
}

/// `height` rows of `stride` bytes. The last row of a plane may lack its padding.
fn whole_rows(plane: &[u8], stride: usize, height: usize) -> Cow<'_, [u8]> {
    plane.get(..stride * height).map_or_else(
        || {
            let mut padded = plane.to_vec();
            padded.resize(stride * height, 0);
            Cow::Owned(padded)
        },
        Cow::Borrowed,
    )
}

/// The dimming of samples: towards black.
#[derive(Clone, Copy, Debug)]
pub struct Dim {
    factor: i16,
}

impl Dim {
    /// Bits of the factor's fraction.
    const BITS: u32 = 7;

    /// To so many thousandths, 1000 at most.
    pub fn to(thousandths: u16) -> Self {
        let factor = (u32::from(thousandths.min(1000)) << Self::BITS).div_ceil(1000);
        Self { factor: factor as i16 }
    }

    /// What of the samples of plane number `plane`, 2 at most, is left.
    #[inline]
    pub fn row(self, plane: usize, row: &[u8], out: &mut [u8]) {
        let black = i16::from(BLACK[plane]);
        for (out, sample) in out.iter_mut().zip(row) {
            let above = (i16::from(*sample) - black) * self.factor + (1 << (Self::BITS - 1));
            *out = (black + (above >> Self::BITS)) as u8;
        }
    }
}

fn dim(picture: &Picture<'_>, thousandths: u16, into: &mut OwnedPicture) {
    let dim = Dim::to(thousandths);
    into.resize((picture.width, picture.height));
    for plane in 0..BLACK.len() {
        let rows = into.plane_mut(plane).chunks_exact_mut(picture.extent(plane).0);
        rows.zip(picture.rows(plane)).for_each(|(out, row)| dim.row(plane, row, out));
    }
}

#[cfg(test)]
mod tests {
    use super::{Transform, Transformer};
    use crate::output::Rotation;
    use crate::picture::Picture;

    /// 4x2: luma 1 to 8, chroma (10, 20) and (30, 40).
    const PICTURE: Picture<'static> =
        Picture { width: 4, height: 2, planes: [&[1, 2, 3, 4, 5, 6, 7, 8], &[10, 20], &[30, 40]], strides: [4, 2, 2] };

    fn transformed(picture: &Picture<'_>, rotation: Rotation, size: (u32, u32), thousandths: u16) -> [Vec<u8>; 3] {
        let mut transformer = Transformer::default();
        let out = transformer.apply(picture, Transform { rotation, size, thousandths });
        assert_eq!((out.width, out.height), size);
        [0, 1, 2].map(|plane| out.rows(plane).flatten().copied().collect())
    }

    #[test]
    fn nothing_is_copied_where_nothing_is_to_be_done() {
        let mut transformer = Transformer::default();
        let transform = Transform { rotation: Rotation::None, size: (4, 2), thousandths: 1000 };
        let out = transformer.apply(&PICTURE, transform);
        assert!((0..3).all(|plane| std::ptr::eq(out.planes[plane], PICTURE.planes[plane])));
    }

    #[test]
    fn a_picture_is_rotated_clockwise() {
        let rotated = |rotation: Rotation| transformed(&PICTURE, rotation, rotation.of_size((4, 2)), 1000);
        let quarter = rotated(Rotation::Clockwise90);
        assert_eq!(quarter, [vec![5, 1, 6, 2, 7, 3, 8, 4], vec![10, 20], vec![30, 40]]);
        let half = rotated(Rotation::Half);
        assert_eq!(half, [vec![8, 7, 6, 5, 4, 3, 2, 1], vec![20, 10], vec![40, 30]]);
        let back = rotated(Rotation::Clockwise270);
        assert_eq!(back, [vec![4, 8, 3, 7, 2, 6, 1, 5], vec![20, 10], vec![40, 30]]);
    }

    #[test]
    fn blocks_of_any_size_are_rotated_to_their_last_sample() {
        let (width, height) = (70usize, 38usize);
        let luma: Vec<u8> = (0..width * height).map(|at| (at % 251) as u8).collect();
        let chroma = vec![7; width * height / 4];
        let picture = Picture {
            width: 70,
            height: 38,
            planes: [&luma, &chroma, &chroma],
            strides: [width, width / 2, width / 2],
        };
        let once = transformed(&picture, Rotation::Clockwise90, (38, 70), 1000);
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            assert_eq!(once[0][x * height + (height - 1 - y)], luma[y * width + x]);
        }
        let turned = Picture { width: 38, height: 70, planes: [&once[0], &once[1], &once[2]], strides: [38, 19, 19] };
        assert_eq!(transformed(&turned, Rotation::Clockwise270, (70, 38), 1000)[0], luma);
    }

    #[test]
    fn a_scaled_picture_is_the_same_picture() {
        // A slope, in rows with padding of which the last has none.
        let (width, height, stride) = (64usize, 32usize, 80usize);
        let sample = |x: usize, y: usize| (40 + 2 * x + y) as u8;
        let mut luma = vec![255; stride * (height - 1) + width];
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            luma[y * stride + x] = sample(x, y);
        }
        let chroma = vec![99; width * height / 4];
        let planes: [&[u8]; 3] = [&luma, &chroma, &chroma];
        let picture = Picture { width: 64, height: 32, planes, strides: [stride, width / 2, width / 2] };
        for (across, down) in [(96, 48), (32, 16), (130, 64)] {
            let [luma, u, v] = transformed(&picture, Rotation::None, (across, down), 1000);
            assert!(u.iter().chain(&v).all(|sample| *sample == 99));
            for (y, row) in luma.chunks(across as usize).enumerate().skip(4).take(down as usize - 8) {
                for (x, found) in row.iter().enumerate().skip(4).take(across as usize - 8) {
                    let place = |at: usize, of: u32, was: usize| (at as f64 + 0.5) * was as f64 / f64::from(of) - 0.5;
                    let expected = 40.0 + 2.0 * place(x, across, width) + place(y, down, height);
                    assert!((f64::from(*found) - expected).abs() < 1.5, "{found} for {expected} at {x} {y}");
                }
            }
        }
    }

    #[test]
    fn dimming_moves_every_sample_towards_black_and_black_stays() {
        let luma = [16, 235, 126, 16, 16, 235, 126, 16];
        let picture = Picture { planes: [&luma, &[128, 240], &[16, 128]], ..PICTURE };
        let [y, u, v] = transformed(&picture, Rotation::None, (4, 2), 500);
        assert_eq!(y, [16, 126, 71, 16, 16, 126, 71, 16]);
        assert_eq!((u, v), (vec![128, 184], vec![72, 128]));
        let [y, u, v] = transformed(&picture, Rotation::None, (4, 2), 0);
        assert_eq!((y, u, v), (vec![16; 8], vec![128; 2], vec![128; 2]));
    }
}

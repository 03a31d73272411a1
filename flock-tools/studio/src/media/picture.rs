//! Small pictures: their size, their bytes, and sheets of several.
//!
//! Owns the size of a picture in a box, and the arrangement of a sheet. Never draws and never decodes.
//!
//! Start at [`fit`] and [`sheet`].

use std::path::Path;

use ::species::Image;
use operations::decoder::thumbnail::Thumbnail;
use operations::portrait::picture::{averaged_planes, jpeg};
use video::Frame;

use super::MediaError;
use super::cache;

/// The largest size in the shape of `full` that fits into `most`, both sides even; never larger than `full`.
pub(super) fn fit(full: (u32, u32), most: (u32, u32)) -> (u32, u32) {
    let parts = [(most.0, full.0), (most.1, full.1)].map(|(most, full)| f64::from(most) / f64::from(full.max(1)));
    let part = parts[0].min(parts[1]).min(1.0);
    let side = |full: u32| ((f64::from(full) * part / 2.0).round() as u32 * 2).max(2);
    (side(full.0), side(full.1))
}

/// A frame of a clip as a small picture of `size`, which is not larger.
pub(super) fn of_frame(frame: &Frame, size: (u32, u32)) -> Option<Thumbnail> {
    averaged_planes(frame.planes(), frame.strides(), frame.size(), size)
}

/// A drawn picture.
pub(super) fn of_image(image: &Image) -> Thumbnail {
    Thumbnail { size: (image.width as u32, image.height as u32), rgb: image.to_rgb8() }
}

/// `pictures`, all of one size, row by row in `columns` columns. Cells that are left over are black.
pub(super) fn sheet(pictures: &[Thumbnail], columns: usize) -> Thumbnail {
    let (width, height) = pictures.first().map_or((2, 2), |first| first.size);
    let rows = pictures.len().div_ceil(columns).max(1);
    let row_bytes = 3 * width as usize;
    let mut rgb = vec![0; row_bytes * columns * height as usize * rows];
    for (number, picture) in pictures.iter().enumerate() {
        let (column, row) = (number % columns, number / columns);
        for (y, line) in picture.rgb.chunks(row_bytes).enumerate() {
            let start = ((row * height as usize + y) * columns + column) * row_bytes;
            rgb[start..start + row_bytes].copy_from_slice(line);
        }
    }
    Thumbnail { size: (width * columns as u32, height * rows as u32), rgb }
}

/// Has `path` hold `picture` as a JPEG of at most about `most` bytes.
pub(super) fn save(path: &Path, picture: &Thumbnail, most: usize) -> Result<(), MediaError> {
    let bytes = jpeg(picture, most).ok_or_else(|| MediaError::refused("a picture", "it is too large"))?;
    cache::write(path, &bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_picture_has_the_shape_of_the_large_one_and_is_never_larger() {
        assert_eq!(fit((1280, 720), (160, 160)), (160, 90));
        assert_eq!(fit((720, 1280), (160, 160)), (90, 160));
        assert_eq!(fit((1024, 768), (160, 160)), (160, 120));
        assert_eq!(fit((64, 36), (160, 160)), (64, 36));
        assert_eq!(fit((8000, 2), (160, 160)), (160, 2));
    }

    #[test]
    fn a_sheet_has_its_pictures_row_by_row() {
        let of = |level: u8| Thumbnail { size: (2, 2), rgb: vec![level; 12] };
        let found = sheet(&[of(1), of(2), of(3)], 2);
        assert_eq!(found.size, (4, 4));
        let row = |y: usize| found.rgb[12 * y..12 * (y + 1)].to_vec();
        let pair = |a: u8, b: u8| [[a; 6], [b; 6]].concat();
        assert_eq!([row(0), row(1), row(2), row(3)], [pair(1, 2), pair(1, 2), pair(3, 0), pair(3, 0)]);
    }
}

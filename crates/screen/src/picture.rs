//! A decoded picture.
//!
//! Owns the borrowed view of its planes, and the copy that a screen in memory keeps. `paint.rs` converts pixels.

use crate::ScreenError;

/// A borrowed 8-bit 4:2:0 picture: BT.709 primaries and matrix, limited range.
#[derive(Clone, Copy, Debug)]
pub struct Picture<'a> {
    /// Visible width in pixels, even.
    pub width: u32,
    /// Visible height in pixels, even.
    pub height: u32,
    /// Y, U and V planes, row-major; U and V have half the width and half the height.
    pub planes: [&'a [u8]; 3],
    /// Bytes from one row to the next of each plane, at least its visible width.
    pub strides: [usize; 3],
}

impl<'a> Picture<'a> {
    /// The visible rows of plane `plane` (0 = Y, 1 = U, 2 = V), without padding, top to bottom.
    pub fn rows(&self, plane: usize) -> impl Iterator<Item = &'a [u8]> + use<'a> {
        let (width, height) = self.extent(plane);
        self.planes[plane].chunks(self.strides[plane]).take(height).map(move |row| &row[..width])
    }

    /// The same in one piece, where no padding lies between the rows.
    pub(crate) fn packed(&self, plane: usize) -> Option<&'a [u8]> {
        let (width, height) = self.extent(plane);
        (self.strides[plane] == width).then(|| &self.planes[plane][..width * height])
    }

    /// Visible samples across and down of plane `plane`.
    pub(crate) fn extent(&self, plane: usize) -> (usize, usize) {
        let half = u32::from(plane > 0);
        ((self.width >> half) as usize, (self.height >> half) as usize)
    }

    /// Checks the picture: its size must be even, not empty and not larger than `screen`, and its planes complete.
    pub(crate) fn check(&self, screen: (u32, u32)) -> Result<(), ScreenError> {
        let even = |n: u32| n > 0 && n.is_multiple_of(2);
        let filled = |plane: usize| {
            let (width, height) = self.extent(plane);
            let stride = self.strides[plane];
            stride >= width && self.planes[plane].len() >= stride * (height - 1) + width
        };
        let fits = even(self.width) && even(self.height) && self.width <= screen.0 && self.height <= screen.1;
        if fits && (0..3).all(filled) {
            return Ok(());
        }
        let (screen_width, screen_height) = screen;
        Err(ScreenError::Size { width: self.width, height: self.height, screen_width, screen_height })
    }
}

/// A picture that owns its planes, without padding.
#[derive(Clone, Debug, Default)]
pub(crate) struct OwnedPicture {
    size: (u32, u32),
    planes: [Vec<u8>; 3],
}

impl OwnedPicture {
    /// Copies `picture`, reusing its memory.
    pub(crate) fn copy_from(&mut self, picture: &Picture<'_>) {
        self.size = (picture.width, picture.height);
        for (plane, bytes) in self.planes.iter_mut().enumerate() {
            bytes.clear();
            picture.rows(plane).for_each(|row| bytes.extend_from_slice(row));
        }
    }

    /// Changes the size; the samples are undefined.
    pub(crate) fn resize(&mut self, size: (u32, u32)) {
        self.size = size;
        for (plane, bytes) in self.planes.iter_mut().enumerate() {
            let half = u32::from(plane > 0);
            bytes.resize((size.0 >> half) as usize * (size.1 >> half) as usize, 0);
        }
    }

    /// The samples of plane `plane`, row by row.
    pub(crate) fn plane_mut(&mut self, plane: usize) -> &mut [u8] {
        &mut self.planes[plane]
    }

    pub(crate) fn view(&self) -> Picture<'_> {
        let (width, height) = self.size;
        let half = (width / 2) as usize;
        let [y, u, v] = &self.planes;
        Picture { width, height, planes: [y, u, v], strides: [width as usize, half, half] }
    }
}

//! One decoded picture on its way to the glass.
//!
//! Owns the borrowed view of its planes. Never owns pixels.

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
        let half = u32::from(plane > 0);
        let (width, height) = ((self.width >> half) as usize, (self.height >> half) as usize);
        self.planes[plane].chunks(self.strides[plane]).take(height).map(move |row| &row[..width])
    }
}

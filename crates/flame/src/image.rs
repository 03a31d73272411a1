//! A finished picture.
//!
//! Owns the layout of displayable light. Never knows how it came to be (`render`) or where it goes:
//! writing a PNG or encoding a clip is the caller's.
//!
//! Start at [`Image`].

/// Displayable light: `[height][width][3]` f32, row-major, red green blue, each in `0.0..=1.0`.
///
/// The values are gamma-encoded for a screen, full range, BT.709 primaries.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `height * width` pixels of red, green, blue.
    pub pixels: Vec<[f32; 3]>,
}

impl Image {
    /// The picture as `[height][width][3]` bytes, full range, rounded to nearest.
    pub fn to_rgb8(&self) -> Vec<u8> {
        self.pixels.as_flattened().iter().map(|light| (light * 255.0 + 0.5) as u8).collect()
    }

    /// The picture as `[height][width][3]` u16, full range, rounded to nearest.
    pub fn to_rgb16(&self) -> Vec<u16> {
        self.pixels.as_flattened().iter().map(|light| (light * 65535.0 + 0.5) as u16).collect()
    }
}

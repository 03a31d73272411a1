//! Small copies of frames, for people to look at.
//!
//! Owns their size and colours: RGB as a browser shows it. Never encodes them: the callers do.
//!
//! Start at [`shrink`].

use scaling::{Filter, Scaler};
use video::Yuv420p;

/// A small picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Thumbnail {
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// `[height][width][3]`, row-major, full range.
    pub rgb: Vec<u8>,
}

/// A copy of `picture` that is `width` pixels wide, in its own proportions.
pub fn shrink(picture: &Yuv420p, width: u32) -> Thumbnail {
    let (full_width, full_height) = picture.size();
    let height = (u64::from(width) * u64::from(full_height) / u64::from(full_width)).max(1) as u32;
    let size = (width, height);
    let small = Scaler::default().rgb8(&picture.to_rgb8(), picture.size(), size, Filter::Lanczos3);
    Thumbnail { size, rgb: small.expect("three bytes a pixel") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thumbnail_keeps_colours_and_proportions() {
        let rgb: Vec<u16> = [0xffff, 0x8000, 0].repeat(320 * 180);
        let small = shrink(&Yuv420p::from_rgb16(320, 180, &rgb).unwrap(), 160);
        assert_eq!(small.size, (160, 90));
        assert!(small.rgb.chunks(3).all(|pixel| pixel[0] > 250 && (120..=136).contains(&pixel[1]) && pixel[2] < 6));
    }
}

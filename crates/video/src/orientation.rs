//! How a picture is turned and mirrored between its file and the screen.
//!
//! Owns the meaning of a container's display matrix, and the turning of pictures. Scales and positions in the matrix have
//! no part in it: ffmpeg makes the shape of pixels of the scale. Never reads a file: `foreign.rs` does.
//!
//! Start at [`Orientation::of_matrix`].

/// Bytes of a display matrix: nine 32-bit numbers in the machine's byte order.
const MATRIX_BYTES: usize = 36;

/// Largest part of a row of the matrix that counts as rounding: 0.9 degrees.
const ROUNDING: f64 = 1.0 / 64.0;

/// One of the eight ways to put a rectangle on itself or on its side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Orientation {
    /// Whether rows of the stored picture are columns on the screen.
    is_on_its_side: bool,
    /// Whether the picture on the screen runs against the stored one: across, down.
    is_reversed: [bool; 2],
}

impl Orientation {
    /// As stored.
    pub const UPRIGHT: Self = Self { is_on_its_side: false, is_reversed: [false; 2] };

    /// The orientation that a display matrix asks for.
    ///
    /// # Errors
    /// In words: what the matrix does instead, if it is none of the eight.
    ///
    /// # Source
    /// ISO/IEC 14496-12, 6.2.2: `x = a p + c q + tx`, `y = b p + d q + ty`, in the order `a b u c d v tx ty w`.
    pub(crate) fn of_matrix(bytes: &[u8]) -> Result<Self, String> {
        let number = |at: usize| {
            let word = bytes.get(4 * at..4 * at + 4).and_then(|word| word.try_into().ok());
            f64::from(i32::from_ne_bytes(word.unwrap_or_default()))
        };
        let ([a, b], [c, d]) = ([number(0), number(1)], [number(3), number(4)]);
        let is_small = |part: f64, whole: f64| part.abs() <= ROUNDING * whole.abs();
        let is_flat = number(2) == 0.0 && number(5) == 0.0;
        if bytes.len() != MATRIX_BYTES || !is_flat || a * d - b * c == 0.0 {
            return Err("in perspective or to a line".to_owned());
        }
        if is_small(b, a) && is_small(c, d) {
            return Ok(Self { is_on_its_side: false, is_reversed: [a < 0.0, d < 0.0] });
        }
        if is_small(a, b) && is_small(d, c) {
            return Ok(Self { is_on_its_side: true, is_reversed: [c < 0.0, b < 0.0] });
        }
        Err(format!("turned by {:.1} degrees or sheared", b.atan2(a).to_degrees()))
    }

    /// Width and height on the screen of a stored picture, or those stored of one on the screen.
    #[must_use]
    pub fn swapped(self, (width, height): (u32, u32)) -> (u32, u32) {
        if self.is_on_its_side { (height, width) } else { (width, height) }
    }

    /// The stored picture `rgb`, `[height][width][3]` of `size`, as it is on the screen.
    pub(crate) fn seen(self, rgb: Vec<f32>, size: (u32, u32)) -> Vec<f32> {
        if self == Self::UPRIGHT {
            return rgb;
        }
        let (width, height) = self.swapped(size);
        let reversed = |at: u32, side: u32, axis: usize| if self.is_reversed[axis] { side - 1 - at } else { at };
        let mut seen = Vec::with_capacity(rgb.len());
        for y in 0..height {
            for x in 0..width {
                let (across, down) = self.swapped((reversed(x, width, 0), reversed(y, height, 1)));
                let start = 3 * (down as usize * size.0 as usize + across as usize);
                seen.extend_from_slice(&rgb[start..start + 3]);
            }
        }
        seen
    }
}

#[cfg(test)]
mod tests {
    use super::Orientation;

    fn matrix(numbers: [i32; 9]) -> Vec<u8> {
        numbers.into_iter().flat_map(i32::to_ne_bytes).collect()
    }

    fn turned([a, b, c, d]: [i32; 4]) -> Result<Orientation, String> {
        Orientation::of_matrix(&matrix([a, b, 0, c, d, 0, 7 << 16, 0, 1 << 30]))
    }

    /// The picture `0 1 2` over `3 4 5` as it is seen.
    fn seen(orientation: Orientation) -> Vec<u8> {
        let rgb = (0..6).flat_map(|level| [level as f32; 3]).collect();
        orientation.seen(rgb, (3, 2)).chunks(3).map(|pixel| pixel[0] as u8).collect()
    }

    #[test]
    fn the_eight_orientations_are_read_whatever_their_scale() {
        for one in [1 << 16, 3 << 15] {
            for (numbers, due) in [
                ([one, 0, 0, one], [0, 1, 2, 3, 4, 5]),
                ([0, one, -one, 0], [3, 0, 4, 1, 5, 2]),
                ([-one, 0, 0, -one], [5, 4, 3, 2, 1, 0]),
                ([0, -one, one, 0], [2, 5, 1, 4, 0, 3]),
                ([-one, 0, 0, one], [2, 1, 0, 5, 4, 3]),
                ([one, 0, 0, -one], [3, 4, 5, 0, 1, 2]),
                ([0, one, one, 0], [0, 3, 1, 4, 2, 5]),
                ([0, -one, -one, 0], [5, 2, 4, 1, 3, 0]),
            ] {
                assert_eq!(seen(turned(numbers).unwrap()), due, "{numbers:?}");
            }
        }
        assert_eq!(turned([1 << 16, 0, 0, 1 << 16]), Ok(Orientation::UPRIGHT));
    }

    #[test]
    fn any_other_matrix_is_refused_with_what_it_does() {
        let refused = turned([46341, 46341, -46341, 46341]).unwrap_err();
        assert_eq!(refused, "turned by 45.0 degrees or sheared");
        assert!(turned([1 << 16, 0, 1 << 16, 1 << 16]).is_err());
        assert!(turned([0; 4]).is_err() && Orientation::of_matrix(&[0; 8]).is_err());
        let perspective = matrix([1 << 16, 0, 9, 0, 1 << 16, 0, 0, 0, 1 << 30]);
        assert!(Orientation::of_matrix(&perspective).is_err());
    }
}

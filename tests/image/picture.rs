//! What is on the glass of a machine, and whether it is art.
//!
//! Owns the judgement: art has many colours and lights a good part of the glass; a console, a firmware's words and a
//! dark screen do not. Never touches a machine.

use std::collections::HashSet;
use std::fs;
use std::path::Path;

/// Colours that no text has, and every frame of the built-in flock.
const COLOURS: usize = 500;
/// One pixel of so many must be lit.
const LIT: usize = 20;
/// Every so manieth pixel is looked at.
const STEP: usize = 7;

/// What a look at the glass has shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Look {
    width: usize,
    height: usize,
    /// How many colours are there, and how many pixels are not dark, of those looked at.
    colours: usize,
    lit: usize,
}

impl Look {
    /// Judges a binary PPM, as QEMU writes it.
    pub(crate) fn at(path: &Path) -> Self {
        let bytes = fs::read(path).unwrap();
        let mut ends = bytes.iter().enumerate().filter(|(_, byte)| byte.is_ascii_whitespace()).map(|(at, _)| at);
        // `P6`, width, height, 255: four words.
        let end = ends.nth(3).expect("a picture has a head");
        let head = std::str::from_utf8(&bytes[..end]).unwrap();
        let words: Vec<_> = head.split_whitespace().collect();
        assert_eq!((words[0], words[3]), ("P6", "255"), "{head}");
        let (width, height) = (words[1].parse().unwrap(), words[2].parse().unwrap());
        Self::of(width, height, &bytes[end + 1..])
    }

    /// Judges `pixels`, three bytes each.
    fn of(width: usize, height: usize, pixels: &[u8]) -> Self {
        assert_eq!(pixels.len(), width * height * 3);
        let lit = || pixels.chunks_exact(3).step_by(STEP).filter(|pixel| pixel.iter().any(|value| *value > 24));
        Self { width, height, colours: lit().collect::<HashSet<_>>().len(), lit: lit().count() }
    }

    /// Whether it is a frame of a flock.
    pub(crate) fn is_art(&self) -> bool {
        self.colours >= COLOURS && self.lit * LIT * STEP >= self.width * self.height
    }
}

#[cfg(test)]
mod tests {
    use super::Look;

    fn look(of: impl Fn(usize) -> [u8; 3]) -> Look {
        let pixels: Vec<_> = (0..320 * 200).flat_map(of).collect();
        Look::of(320, 200, &pixels)
    }

    #[test]
    fn black_and_text_and_few_colours_are_no_art() {
        assert!(!look(|_| [0; 3]).is_art());
        assert!(!look(|at| if at % 5 == 0 { [170; 3] } else { [0; 3] }).is_art());
        assert!(!look(|at| if at < 2_000 { [(at % 251) as u8, (at % 83) as u8, 90] } else { [0; 3] }).is_art());
        assert!(look(|at| [(at % 251) as u8, (at % 83) as u8, 90]).is_art());
    }
}

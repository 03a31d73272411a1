//! Looks at the screen of a machine: which frame it shows, if any.
//!
//! Owns the reading of QEMU's screen dumps; `reference_frames.rs` has the frames that they are compared with.

use crate::machine::reference_frames::{Place, ReferenceFrames, SIZE, Samples};
use std::fs;
use std::path::Path;
use std::time::Duration;

/// The brightest value of black: frames are brighter somewhere, borders nowhere.
const DARK: u8 = 24;

/// The result of one look.
#[derive(Clone, Debug)]
pub(crate) struct Look {
    /// When it was taken.
    pub(crate) at: Duration,
    /// The frame that was shown, if it was one.
    pub(crate) place: Option<Place>,
    /// Otherwise the size of the picture in pixels, and its brightest sample.
    pub(crate) other: Option<((usize, usize), u8)>,
}

impl Look {
    /// Judges a binary PPM, as QEMU writes it, against `references`. `near` is the frame that was found last;
    /// `may_tear` says that pictures are copied to where they are shown, so that parts of two may be seen.
    pub(crate) fn new(
        path: &Path,
        at: Duration,
        references: &[&ReferenceFrames],
        near: &mut usize,
        may_tear: bool,
    ) -> Self {
        let bytes = fs::read(path).unwrap();
        let mut ends = bytes.iter().enumerate().filter(|(_, byte)| byte.is_ascii_whitespace()).map(|(at, _)| at);
        // `P6`, width, height, 255: four words.
        let end = ends.nth(3).expect("a picture has a head");
        let head = std::str::from_utf8(&bytes[..end]).unwrap();
        let words: Vec<_> = head.split_whitespace().collect();
        assert_eq!((words[0], words[3]), ("P6", "255"), "{head}");
        let size = (words[1].parse().unwrap(), words[2].parse().unwrap());
        let pixels = &bytes[end + 1..];
        assert_eq!(pixels.len(), size.0 * size.1 * 3);
        let brightest = pixels.iter().step_by(7).copied().max().unwrap_or_default();
        let mut place = None;
        // This saves the comparison with all frames while a machine starts.
        let colour =
            |x: usize, y: usize| -> [u8; 3] { pixels[(y * size.0 + x) * 3..][..3].try_into().expect("three bytes") };
        let glass = ScreenGeometry::of(size);
        let is_framed = || glass.border().all(|(x, y)| colour(x, y).iter().all(|light| *light <= DARK));
        if brightest > DARK && is_framed() {
            let samples = Samples::of(|x, y| glass.pixel(x, y, colour));
            let mut whole = |reference: &&ReferenceFrames| match size {
                SIZE => reference.find(&samples, near),
                _ => reference.find_scaled(&samples),
            };
            let torn = |reference: &&ReferenceFrames| reference.find_torn(&samples);
            place = references.iter().find_map(&mut whole);
            place = place.or_else(|| references.iter().filter(|_| may_tear).find_map(torn));
        }
        Self { at, other: place.is_none().then_some((size, brightest)), place }
    }

    /// Whether it shows a whole frame of a flock.
    pub(crate) fn is_art(&self) -> bool {
        self.place.is_some()
    }

    /// Whether it shows black only.
    pub(crate) fn is_dark(&self) -> bool {
        self.other.is_some_and(|(_, brightest)| brightest <= DARK)
    }
}

/// The geometry of a screen of another size: the picture is scaled to fit, in the middle, with black borders.
struct ScreenGeometry {
    size: (usize, usize),
    scale: f64,
}

impl ScreenGeometry {
    fn of(size: (usize, usize)) -> Self {
        Self { size, scale: (size.0 as f64 / SIZE.0 as f64).min(size.1 as f64 / SIZE.1 as f64) }
    }

    /// Pixels to the left of the picture, and above it.
    fn margins(&self) -> (f64, f64) {
        let margin = |glass: usize, picture: usize| (glass as f64 - picture as f64 * self.scale) / 2.0;
        (margin(self.size.0, SIZE.0), margin(self.size.1, SIZE.1))
    }

    /// The colour at the middle of this pixel of the picture.
    fn pixel(&self, x: usize, y: usize, colour: impl Fn(usize, usize) -> [u8; 3]) -> [u8; 3] {
        let (left, top) = self.margins();
        let place = |margin: f64, at: usize| (margin + (at as f64 + 0.5) * self.scale) as usize;
        colour(place(left, x), place(top, y))
    }

    /// Pixels around the picture, but for those that rounding may reach.
    fn border(&self) -> impl Iterator<Item = (usize, usize)> {
        let ((left, top), (width, height)) = (self.margins(), self.size);
        let is_outside = move |at: usize, margin: f64, size: usize| at.min(size - 1 - at) as f64 + 3.0 < margin;
        let all = (0..height).step_by(3).flat_map(move |y| (0..width).step_by(3).map(move |x| (x, y)));
        all.filter(move |(x, y)| is_outside(*x, left, width) || is_outside(*y, top, height))
    }
}

/// The looks from the first frame on, all of which must show a frame. `how_often` is the least number per second.
pub(crate) fn only_art(looks: &[Look], how_often: f64) -> &[Look] {
    let first = looks.iter().position(Look::is_art).expect("art is lit");
    let since = &looks[first..];
    for (number, look) in since.iter().enumerate() {
        assert!(look.is_art(), "look {number} after the first lit frame, see `target/image/odd.ppm`: {:?}", look.other);
    }
    let seconds = since[since.len() - 1].at.saturating_sub(since[0].at).as_secs_f64();
    let often = since.len() as f64 / seconds;
    println!("{} looks before the first lit frame, {} in {seconds:.1} s from it on: all art", first, since.len());
    assert!(often >= how_often, "looked only {often:.1} times a second");
    since
}

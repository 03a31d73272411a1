//! What is on the glass of a machine, and whether it is art.
//!
//! Owns the reading of QEMU's pictures; what art is, `gallery.rs` says. Never touches a machine.

use crate::gallery::{Gallery, Place, SIZE, Samples};
use std::fs;
use std::path::Path;
use std::time::Duration;

/// A picture without a brighter sample is no frame.
const DARK: u8 = 24;

/// What a look at the glass has shown.
#[derive(Clone, Debug)]
pub(crate) struct Look {
    /// When it was.
    pub(crate) at: Duration,
    /// The frame that was there, if it was one.
    pub(crate) place: Option<Place>,
    /// Else, what it was: its pixels across and down, and its brightest sample.
    pub(crate) other: Option<((usize, usize), u8)>,
}

impl Look {
    /// Judges a binary PPM, as QEMU writes it, by what may hang there. `near` is where in the gallery the last one was.
    pub(crate) fn new(path: &Path, at: Duration, galleries: &[&Gallery], near: &mut usize) -> Self {
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
        // That spares looking through all of them while a machine starts.
        if size == SIZE && brightest > DARK {
            let samples = Samples::of(|x, y| pixels[(y * SIZE.0 + x) * 3..][..3].try_into().expect("three bytes"));
            place = galleries.iter().find_map(|gallery| gallery.find(&samples, near));
        }
        Self { at, other: place.is_none().then_some((size, brightest)), place }
    }

    /// Whether it is a frame of a flock, whole.
    pub(crate) fn is_art(&self) -> bool {
        self.place.is_some()
    }

    /// Whether nothing is to be seen.
    pub(crate) fn is_dark(&self) -> bool {
        self.other.is_some_and(|(_, brightest)| brightest <= DARK)
    }
}

/// The looks from the first lit frame on, all of which must be art. `how_often` they were taken a second, at least.
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

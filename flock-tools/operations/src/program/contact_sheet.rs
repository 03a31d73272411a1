//! A contact sheet: pictures with lines of text, as PNG.
//!
//! Owns paper, letters and the file. Never knows what the pictures show: whoever lays a sheet out does.
//!
//! Start at [`ContactSheet::new`].

use std::fs::File;
use std::io::{self, BufWriter};
use std::path::Path;

use font8x8::legacy::BASIC_LEGACY;

/// The colour of paper.
const PAPER: [u8; 3] = [24, 24, 28];
/// The colour of text.
pub const INK: [u8; 3] = [220, 220, 210];

/// Dots of a letter, in either direction.
pub const LETTER: u32 = 8;

/// A sheet being laid out, from the top down.
pub struct ContactSheet {
    width: u32,
    /// RGB, row by row.
    pixels: Vec<u8>,
}

impl ContactSheet {
    /// A sheet without rows, `width` pixels wide.
    pub fn new(width: u32) -> Self {
        Self { width, pixels: Vec::new() }
    }

    /// Its height so far, in pixels.
    pub fn height(&self) -> u32 {
        self.pixels.len() as u32 / (3 * self.width)
    }

    /// Adds rows of paper.
    pub fn grow(&mut self, rows: u32) {
        self.pixels.extend(PAPER.repeat((rows * self.width) as usize));
    }

    /// Writes `text` on rows that are there, from `at` on, x before y; what is wider than `room` is left out. A dot of a
    /// letter has `dot` pixels.
    pub fn write(&mut self, text: &str, at: [u32; 2], room: u32, dot: u32, ink: [u8; 3]) {
        for (place, letter) in text.chars().take((room / (LETTER * dot)) as usize).enumerate() {
            let rows = BASIC_LEGACY.get(letter as usize).unwrap_or(&BASIC_LEGACY['?' as usize]);
            let left = at[0] + place as u32 * LETTER * dot;
            for y in 0..LETTER * dot {
                let bits = rows[(y / dot) as usize];
                for x in (0..LETTER * dot).filter(|x| bits >> (x / dot) & 1 == 1) {
                    self.paste([left + x, at[1] + y], 1, &ink);
                }
            }
        }
    }

    /// Puts a picture, `width` pixels wide, on rows that are there. `rgb` has its bytes, row by row.
    pub fn paste(&mut self, at: [u32; 2], width: u32, rgb: &[u8]) {
        for (y, row) in (at[1]..).zip(rgb.chunks(3 * width as usize)) {
            let start = 3 * (y * self.width + at[0]) as usize;
            self.pixels[start..start + row.len()].copy_from_slice(row);
        }
    }

    /// Writes the sheet as PNG.
    pub fn save(&self, path: &Path) -> io::Result<()> {
        let mut encoder = png::Encoder::new(BufWriter::new(File::create(path)?), self.width, self.height());
        encoder.set_color(png::ColorType::Rgb);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.pixels)?;
        writer.finish()?;
        Ok(())
    }
}

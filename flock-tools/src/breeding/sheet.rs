//! A contact sheet of sheep: small pictures with their ids.
//!
//! Owns its layout and how the pictures are drawn. Never chooses the sheep.
//!
//! Start at [`Sheet::of`].

use std::fs::File;
use std::io::{self, BufWriter};
use std::path::Path;

use font8x8::legacy::BASIC_LEGACY;
use species::{Genome, RenderError, Settings, Threads};

use super::nursery::{FRAMES, SIZE};
use crate::program::{Exit, Fatal};

/// A picture, in pixels.
const PICTURE: [u32; 2] = [240, 135];
/// Samples per pixel.
const SAMPLES: f64 = 100.0;
/// Pictures in a row.
const ROW: usize = 5;
/// Pixels between pictures, and around all.
const GAP: u32 = 8;
/// Height of a line of text: letters of 8 by 8 dots.
const LINE: u32 = 12;

const PAPER: [u8; 3] = [24, 24, 28];
const INK: [u8; 3] = [220, 220, 210];

/// A sheet.
pub(super) struct Sheet {
    width: u32,
    /// RGB, row by row.
    pixels: Vec<u8>,
}

impl Sheet {
    /// A sheet of these sheep, by their names: frame 0 of each loop.
    /// Errors: If one cannot be drawn.
    pub(super) fn of(sheep: &[(String, &dyn Genome)], threads: &Threads) -> Result<Self, Fatal> {
        let rows = sheep.len().div_ceil(ROW) as u32;
        let [width, height] = [ROW as u32 * (PICTURE[0] + GAP) + GAP, rows * (PICTURE[1] + LINE + GAP) + GAP];
        let mut sheet = Self { width, pixels: PAPER.repeat((width * height) as usize) };
        for (at, (name, genome)) in sheep.iter().enumerate() {
            let left = GAP + (at % ROW) as u32 * (PICTURE[0] + GAP);
            let top = GAP + (at / ROW) as u32 * (PICTURE[1] + LINE + GAP);
            let picture = picture(*genome, threads).map_err(|error| Fatal::new(Exit::Malformed, error))?;
            for (row, line) in (top..).zip(picture.chunks(3 * PICTURE[0] as usize)) {
                let start = 3 * (row * width + left) as usize;
                sheet.pixels[start..start + line.len()].copy_from_slice(line);
            }
            sheet.write(name, left, top + PICTURE[1] + 2);
        }
        Ok(sheet)
    }

    /// Writes the sheet as PNG.
    pub(super) fn save(&self, path: &Path) -> io::Result<()> {
        let height = self.pixels.len() as u32 / (3 * self.width);
        let mut encoder = png::Encoder::new(BufWriter::new(File::create(path)?), self.width, height);
        encoder.set_color(png::ColorType::Rgb);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.pixels)?;
        writer.finish()?;
        Ok(())
    }

    /// Writes `text` under a picture, as far as there is room.
    fn write(&mut self, text: &str, left: u32, top: u32) {
        for (at, letter) in text.chars().take((PICTURE[0] / 8) as usize).enumerate() {
            let rows = BASIC_LEGACY.get(letter as usize).unwrap_or(&BASIC_LEGACY['?' as usize]);
            for (y, bits) in (top..).zip(rows) {
                for x in (0..8).filter(|x| bits >> x & 1 == 1) {
                    let dot = 3 * (y * self.width + left + at as u32 * 8 + x) as usize;
                    self.pixels[dot..dot + 3].copy_from_slice(&INK);
                }
            }
        }
    }
}

/// RGB, row by row.
fn picture(genome: &dyn Genome, threads: &Threads) -> Result<Vec<u8>, RenderError> {
    let settings = Settings {
        size: PICTURE,
        spp: Some(SAMPLES),
        psnr: None,
        supersample: None,
        temporal_samples: None,
        smooths: true,
        seed: 1,
    };
    let image = genome.turning(SIZE, FRAMES).frame(0.0, &settings, threads)?.image;
    Ok(image.pixels.iter().flatten().map(|light| (light * 255.0).round() as u8).collect())
}

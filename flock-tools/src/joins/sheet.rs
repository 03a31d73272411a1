//! A contact sheet of joins: the frames that meet, side by side.
//!
//! Owns its layout. Never chooses the joins: `mod.rs` sorts them.
//!
//! Start at [`Sheet`].

use std::fs::File;
use std::io::{self, BufWriter};
use std::path::Path;

use font8x8::legacy::BASIC_LEGACY;
use video::Yuv420p;

use super::JudgedJoin;
use crate::decoder::thumbnail::{Thumbnail, shrink};

/// Width of one frame on the sheet, in pixels.
const FRAME_WIDTH: u32 = 320;
/// Frames in a row: two before the join, two after.
const FRAMES: u32 = 4;
/// Pixels between frames, and around all.
const GAP: u32 = 8;
/// Pixels between the frames before a join and those after.
const CUT: u32 = 24;
/// Pixels of one dot of a letter.
const DOT: u32 = 2;
/// Height of a line of text.
const LINE: u32 = 8 * DOT + GAP;

const PAPER: [u8; 3] = [24, 24, 28];
const INK: [u8; 3] = [220, 220, 210];
/// The colour of joins that jump.
const ALARM: [u8; 3] = [255, 120, 90];

/// A sheet being laid out, from the top down.
pub(crate) struct Sheet {
    width: u32,
    /// RGB, row by row.
    pixels: Vec<u8>,
}

impl Sheet {
    /// A sheet with nothing on it.
    pub(crate) fn new() -> Self {
        let mut sheet = Self { width: FRAMES * FRAME_WIDTH + (FRAMES - 1) * GAP + CUT + 2 * GAP, pixels: Vec::new() };
        sheet.grow(GAP);
        sheet
    }

    /// Adds a join: its names and figures, and below them its `frames`.
    pub(crate) fn add(&mut self, JudgedJoin { join, figures }: &JudgedJoin, frames: &[Yuv420p]) {
        let ink = if figures.jumps() { ALARM } else { INK };
        let names = format!("{}: {} > {}", join.sheep, join.before.path, join.after.path);
        let [step, course, speed] = [figures.step_db, figures.course_db, figures.speed_db];
        let text = format!(
            "severity {:.2}: step {step:+.1} dB, course {course:+.1} dB, speed {speed:+.1} dB; PSNR {:.1} ({:.1}) dB",
            figures.severity, figures.value_db, figures.inside_db
        );
        self.line(&names, ink);
        self.line(&text, ink);
        let thumbnails: Vec<Thumbnail> = frames.iter().map(|frame| shrink(frame, FRAME_WIDTH)).collect();
        let top = self.height();
        self.grow(thumbnails.iter().map(|thumbnail| thumbnail.size.1).max().unwrap_or(0) + 2 * GAP);
        // Frames after the join stand to the right even if one before it is missing.
        let before = if join.before.frames.0 == 1 { 1 } else { 2 };
        for (at, thumbnail) in (2 - before..).zip(&thumbnails) {
            let left = GAP + at * (FRAME_WIDTH + GAP) + if at >= 2 { CUT } else { 0 };
            self.paste(left, top, thumbnail);
        }
    }

    /// Writes the sheet as PNG.
    pub(crate) fn save(&self, path: &Path) -> io::Result<()> {
        let mut encoder = png::Encoder::new(BufWriter::new(File::create(path)?), self.width, self.height());
        encoder.set_color(png::ColorType::Rgb);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.pixels)?;
        writer.finish()?;
        Ok(())
    }

    fn height(&self) -> u32 {
        self.pixels.len() as u32 / (3 * self.width)
    }

    fn grow(&mut self, rows: u32) {
        self.pixels.extend(PAPER.repeat((rows * self.width) as usize));
    }

    /// A line of text, cut at the edge of the sheet.
    fn line(&mut self, text: &str, ink: [u8; 3]) {
        let top = self.height();
        self.grow(LINE);
        let fit = (self.width - 2 * GAP) / (8 * DOT);
        for (at, letter) in text.chars().take(fit as usize).enumerate() {
            let rows = BASIC_LEGACY.get(letter as usize).unwrap_or(&BASIC_LEGACY['?' as usize]);
            let left = GAP + at as u32 * 8 * DOT;
            for y in 0..8 * DOT {
                let bits = rows[(y / DOT) as usize];
                for x in (0..8 * DOT).filter(|x| bits >> (x / DOT) & 1 == 1) {
                    self.dot(left + x, top + y, ink);
                }
            }
        }
    }

    fn dot(&mut self, x: u32, y: u32, ink: [u8; 3]) {
        let at = 3 * (y * self.width + x) as usize;
        self.pixels[at..at + 3].copy_from_slice(&ink);
    }

    fn paste(&mut self, left: u32, top: u32, thumbnail: &Thumbnail) {
        let rows = thumbnail.rgb.chunks(3 * thumbnail.size.0 as usize);
        for (y, row) in (top..).zip(rows) {
            let at = 3 * (y * self.width + left) as usize;
            self.pixels[at..at + row.len()].copy_from_slice(row);
        }
    }
}

//! A contact sheet of joins: the frames that meet, side by side.
//!
//! Owns its layout. Never chooses the joins: `mod.rs` sorts them.
//!
//! Start at [`Sheet`].

use std::io;
use std::path::Path;

use video::Yuv420p;

use super::JudgedJoin;
use crate::decoder::thumbnail::{Thumbnail, shrink};
use crate::program::contact_sheet::{ContactSheet, INK, LETTER};

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
const LINE: u32 = LETTER * DOT + GAP;
/// Pixels from edge to edge.
const WIDTH: u32 = FRAMES * FRAME_WIDTH + (FRAMES - 1) * GAP + CUT + 2 * GAP;

/// The colour of joins that jump.
const ALARM: [u8; 3] = [255, 120, 90];

/// A sheet being laid out, from the top down.
pub(super) struct Sheet(ContactSheet);

impl Sheet {
    /// A sheet with nothing on it.
    pub(super) fn new() -> Self {
        let mut sheet = ContactSheet::new(WIDTH);
        sheet.grow(GAP);
        Self(sheet)
    }

    /// Adds a join: its names and figures, and below them its `frames`.
    pub(super) fn add(&mut self, JudgedJoin { join, figures }: &JudgedJoin, frames: &[Yuv420p]) {
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
        let top = self.0.height();
        self.0.grow(thumbnails.iter().map(|thumbnail| thumbnail.size.1).max().unwrap_or(0) + 2 * GAP);
        // Frames after the join stand to the right even if one before it is missing.
        let before = if join.before.frames.0 == 1 { 1 } else { 2 };
        for (at, thumbnail) in (2 - before..).zip(&thumbnails) {
            let left = GAP + at * (FRAME_WIDTH + GAP) + if at >= 2 { CUT } else { 0 };
            self.0.paste([left, top], thumbnail.size.0, &thumbnail.rgb);
        }
    }

    /// Writes the sheet as PNG.
    pub(super) fn save(&self, path: &Path) -> io::Result<()> {
        self.0.save(path)
    }

    /// A line of text, cut at the edge of the sheet.
    fn line(&mut self, text: &str, ink: [u8; 3]) {
        let top = self.0.height();
        self.0.grow(LINE);
        self.0.write(text, [GAP, top], WIDTH - 2 * GAP, DOT, ink);
    }
}

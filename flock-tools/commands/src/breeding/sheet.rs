//! A contact sheet of sheep: small pictures with their ids.
//!
//! Owns its layout and how the pictures are drawn. Never chooses the sheep.
//!
//! Start at [`Sheet::of`].

use std::io;
use std::path::Path;

use operations::breeding::nursery::{FRAMES, SIZE};
use operations::program::contact_sheet::{ContactSheet, INK};
use operations::program::{Exit, Fatal};
use species::{Genome, RenderError, Settings, Threads};

/// A picture, in pixels.
const PICTURE: [u32; 2] = [240, 135];
/// Samples per pixel.
const SAMPLES: f64 = 100.0;
/// Pictures in a row.
const ROW: usize = 5;
/// Pixels between pictures, and around all.
const GAP: u32 = 8;
/// Height of a line of text, which is two pixels below its picture.
const LINE: u32 = 12;

/// A sheet.
pub(super) struct Sheet(ContactSheet);

impl Sheet {
    /// A sheet of these sheep, by their names: frame 0 of each loop.
    /// Errors: If one cannot be drawn.
    pub(super) fn of(sheep: &[(String, &dyn Genome)], threads: &Threads) -> Result<Self, Fatal> {
        let mut sheet = ContactSheet::new(ROW as u32 * (PICTURE[0] + GAP) + GAP);
        sheet.grow(GAP);
        for row in sheep.chunks(ROW) {
            let top = sheet.height();
            sheet.grow(PICTURE[1] + LINE + GAP);
            for (left, (name, genome)) in (GAP..).step_by((PICTURE[0] + GAP) as usize).zip(row) {
                let picture = picture(*genome, threads).map_err(|error| Fatal::new(Exit::Malformed, error))?;
                sheet.paste([left, top], PICTURE[0], &picture);
                sheet.write(name, [left, top + PICTURE[1] + 2], PICTURE[0], 1, INK);
            }
        }
        Ok(Self(sheet))
    }

    /// Writes the sheet as PNG.
    pub(super) fn save(&self, path: &Path) -> io::Result<()> {
        self.0.save(path)
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

//! Light of strokes.
//!
//! Owns one band of rows: how much of each pixel a body covers, and the light that it adds. Bands know nothing of each
//! other. Never knows what a body is.
//!
//! Start at [`Band::add`].

use crate::colour::mixed;
use crate::sprite::{Sprite, Sprites, Streak};

/// Rows of a band.
pub(crate) const ROWS: usize = 16;

/// Some rows of the picture.
pub(crate) struct Band<'p> {
    /// The number of its first row.
    pub(crate) top: usize,
    /// Pixels in a row.
    pub(crate) width: usize,
    /// Linear light of its pixels.
    pub(crate) light: &'p mut [[f32; 3]],
}

impl Band<'_> {
    /// Adds `share` of the light of all sprites. `cover` has room for the band. Returns how often
    /// a streak was evaluated.
    pub(crate) fn add(&mut self, sprites: &Sprites, share: f32, cover: &mut [f32]) -> u64 {
        let screen = [0..self.width, self.top..self.top + self.light.len() / self.width];
        let mut evaluations = 0;
        for sprite in &sprites.bodies {
            for down in sprite.copies.into_iter().flatten() {
                let [columns, rows] = sprite.cells(down, &screen);
                if columns.is_empty() || rows.is_empty() {
                    continue;
                }
                // Lines of one body do not add up where they meet: the brighter one counts.
                let cover = &mut cover[..columns.len() * rows.len()];
                cover.fill(0.0);
                for streak in &sprites.streaks[sprite.streaks.clone()] {
                    let cells = streak.cells(sprite, down, &screen);
                    evaluations += (cells[0].len() * cells[1].len()) as u64;
                    for row in cells[1].clone() {
                        let line = &mut cover[(row - rows.start) * columns.len()..][..columns.len()];
                        let line = &mut line[cells[0].start - columns.start..][..cells[0].len()];
                        let y = row as f32 + 0.5 - down;
                        for (column, cover) in cells[0].clone().zip(line) {
                            *cover = cover.max(lit(streak, sprite.soft, [column as f32 + 0.5, y]));
                        }
                    }
                }
                for (row, line) in rows.clone().zip(cover.chunks(columns.len())) {
                    let pixels = &mut self.light[(row - self.top) * self.width..][columns.clone()];
                    let y = row as f32 + 0.5 - down - sprite.centre[1];
                    for ((column, cover), pixel) in columns.clone().zip(line).zip(pixels) {
                        if *cover > 0.0 {
                            add(pixel, sprite, [column as f32 + 0.5 - sprite.centre[0], y], cover * share);
                        }
                    }
                }
            }
        }
        evaluations
    }
}

/// The light of a streak at a point: its coverage, with an edge as wide as it is out of focus. What is thinner than its
/// edge is drawn as wide as that and as much dimmer, so that no light is lost and none flickers.
#[inline]
fn lit(streak: &Streak, soft: f32, point: [f32; 2]) -> f32 {
    let radius = streak.capsule.radii[0];
    let wide = radius.max(0.5 * soft);
    let edge = (0.5 - (streak.capsule.distance(point) + radius - wide) / soft).clamp(0.0, 1.0);
    edge * edge * (3.0 - 2.0 * edge) * (radius / wide) * streak.light
}

/// Adds light whose colour goes from the middle to the tips.
#[inline]
fn add(pixel: &mut [f32; 3], sprite: &Sprite, [x, y]: [f32; 2], light: f32) {
    let part = ((x * x + y * y).sqrt() / sprite.reach).min(1.0);
    let colour = mixed(sprite.light[0], sprite.light[1], part);
    for (pixel, colour) in pixel.iter_mut().zip(colour) {
        *pixel += colour * light;
    }
}

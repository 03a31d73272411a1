//! The glow around light.
//!
//! Owns three blurred copies of the picture, small ones as wide blurs need no fine grid, and what they add to a row. Never
//! knows what shines.
//!
//! Start at [`Glow::of`].

use rayon::iter::{IndexedParallelIterator, ParallelIterator};
use rayon::slice::ParallelSliceMut;

/// How wide each is, as the standard deviation in heights of the picture, and how strong.
const GLOWS: [(f64, f32); 3] = [(0.0045, 0.45), (0.016, 0.50), (0.06, 0.80)];
/// Cells of a small copy that a standard deviation is wide, at least, where the picture has as many pixels.
const FINE: f64 = 3.0;

/// The glow of a picture.
pub(crate) struct Glow {
    planes: Vec<Plane>,
}

/// A small copy.
struct Plane {
    width: usize,
    height: usize,
    /// Pixels along a cell.
    cell: usize,
    strength: f32,
    light: Vec<[f32; 3]>,
}

/// Cells along and down, and pixels along a cell.
fn grid([width, height]: [usize; 2], deviation: f64) -> ([usize; 2], usize) {
    let cell = ((deviation * height as f64 / FINE) as usize).max(1);
    ([width.div_ceil(cell), height.div_ceil(cell)], cell)
}

impl Glow {
    /// Bytes of the glow of a picture while it is made: all copies, and another while it is blurred.
    pub(crate) fn bytes(size: [usize; 2]) -> u64 {
        let cells = GLOWS.map(|(deviation, _)| grid(size, deviation).0.iter().product::<usize>());
        let all = cells.iter().sum::<usize>() + cells.iter().max().unwrap_or(&0);
        (all * size_of::<[f32; 3]>() + 4096) as u64
    }

    /// Bytes that a row needs.
    pub(crate) fn bytes_of_row(size: [usize; 2]) -> u64 {
        (grid(size, GLOWS[0].0).0[0] * size_of::<[f32; 3]>()) as u64
    }

    /// The glow of a picture of linear light.
    pub(crate) fn of(light: &[[f32; 3]], size: [usize; 2]) -> Glow {
        let plane = |(deviation, strength)| Plane::of(light, size, deviation, strength);
        Glow { planes: GLOWS.into_iter().map(plane).collect() }
    }

    /// Adds `much` of the glow to row number `row`. `room` is for the row of a small copy.
    pub(crate) fn add(&self, pixels: &mut [[f32; 3]], row: usize, much: f32, room: &mut Vec<[f32; 3]>) {
        for plane in &self.planes {
            let (rows, weights) = spline(row, plane.cell, plane.height);
            let lines = rows.map(|row| &plane.light[row * plane.width..][..plane.width]);
            room.clear();
            room.extend((0..plane.width).map(|column| {
                [0, 1, 2].map(|channel| (0..3).map(|line| lines[line][column][channel] * weights[line]).sum::<f32>())
            }));
            let strength = much * plane.strength;
            for (column, pixel) in pixels.iter_mut().enumerate() {
                let (columns, weights) = spline(column, plane.cell, plane.width);
                let cells = columns.map(|column| room[column]);
                for (channel, light) in pixel.iter_mut().enumerate() {
                    let glow = cells[0][channel] * weights[0]
                        + cells[1][channel] * weights[1]
                        + cells[2][channel] * weights[2];
                    *light += strength * glow;
                }
            }
        }
    }
}

/// The cells around a pixel, and how much each counts: a quadratic spline has no creases.
#[inline]
fn spline(pixel: usize, cell: usize, cells: usize) -> ([usize; 3], [f32; 3]) {
    let at = pixel / cell;
    let off = ((pixel % cell) as f32 + 0.5) / cell as f32 - 0.5;
    let (before, after) = (0.5 - off, 0.5 + off);
    let around = [at.saturating_sub(1), at, (at + 1).min(cells - 1)];
    (around, [0.5 * before * before, 0.75 - off * off, 0.5 * after * after])
}

impl Plane {
    fn of(light: &[[f32; 3]], size: [usize; 2], deviation: f64, strength: f32) -> Plane {
        let ([width, height], cell) = grid(size, deviation);
        let mut small = vec![[0.0; 3]; width * height];
        // Beyond the picture is no light.
        let share = 1.0 / (cell * cell) as f32;
        small.par_chunks_mut(width).enumerate().for_each(|(row, cells)| {
            for pixels in light.chunks(size[0]).skip(row * cell).take(cell) {
                for (cell, pixels) in cells.iter_mut().zip(pixels.chunks(cell)) {
                    for pixel in pixels {
                        cell.iter_mut().zip(pixel).for_each(|(cell, pixel)| *cell += pixel * share);
                    }
                }
            }
        });
        let taps = taps(deviation * size[1] as f64 / cell as f64);
        let mut blurred = vec![[0.0; 3]; width * height];
        blurred.par_chunks_mut(width).zip(small.par_chunks_mut(width)).for_each(|(to, from)| {
            for (tap, shift) in &taps {
                let (skip, lead) = ((-shift).max(0) as usize, (*shift).max(0) as usize);
                let to = to.get_mut(skip..).unwrap_or_default().as_flattened_mut();
                let from = from.get(lead..).unwrap_or_default().as_flattened();
                to.iter_mut().zip(from).for_each(|(to, from)| *to += tap * from);
            }
        });
        small.par_chunks_mut(width).enumerate().for_each(|(row, to)| {
            to.fill([0.0; 3]);
            for (tap, shift) in &taps {
                let from = row as isize + shift;
                if (0..height as isize).contains(&from) {
                    let from = blurred[from as usize * width..][..width].as_flattened();
                    to.as_flattened_mut().iter_mut().zip(from).for_each(|(to, from)| *to += tap * from);
                }
            }
        });
        Plane { width, height, cell, strength, light: small }
    }
}

/// The weights of a Gaussian, which sum up to 1, and how many cells away.
fn taps(deviation: f64) -> Vec<(f32, isize)> {
    let far = (3.0 * deviation).ceil() as isize;
    let weight = |shift: isize| libm::exp(-0.5 * (shift * shift) as f64 / (deviation * deviation));
    let sum: f64 = (-far..=far).map(weight).sum();
    (-far..=far).map(|shift| ((weight(shift) / sum) as f32, shift)).collect()
}

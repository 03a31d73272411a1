//! What leads a dissolve: a picture's luma without its details.
//!
//! Owns the blur, the slopes of what is left, and how bright a place is among all others. Never mixes pictures:
//! `dissolve.rs` does.
//!
//! Start at [`Guide::of`].

use rayon::iter::{IndexedParallelIterator, ParallelIterator};
use rayon::slice::ParallelSliceMut;

use crate::image::Image;
use crate::luma::luma;

/// Details smaller than this part of the height are blurred: the deviation of the blur.
const BLUR: f64 = 0.02;
/// The length over which a slope is told, and the farthest that it leads, as a part of the height.
const REACH: f64 = 0.06;
/// Passes of a box, which together are near enough to a bell.
const PASSES: usize = 3;
/// The values of luma that are told apart.
const BINS: usize = 512;
/// Places whose luma differs by so many bins are about as bright as each other.
const ALIKE: usize = 4;
/// Bins on either side of black and white, so that none who are alike are lost.
const MARGIN: usize = PASSES * ALIKE;

/// The blurred luma of a picture.
#[derive(Debug)]
pub(crate) struct Guide {
    width: usize,
    height: usize,
    lumas: Vec<f32>,
    /// Pixels.
    reach: f32,
}

/// How bright is how rare.
#[derive(Debug)]
pub(crate) struct Ranks(Vec<f32>);

/// A box as wide as its deviation asks, with edges that count in part.
///
/// # Source
/// Gwosdek, Grewenig, Bruhn & Weickert, *Theoretical foundations of Gaussian convolution by extended box filtering*
/// (2011).
#[derive(Clone, Copy, Debug)]
struct Window {
    radius: usize,
    edge: f64,
}

impl Guide {
    /// Bytes of memory that it takes for a pixel, while it is made.
    pub(crate) const BYTES: u64 = 8;

    /// Bytes that a thread needs to make one, for a pixel in the picture's longer direction.
    pub(crate) const BYTES_PER_THREAD: u64 = 4;

    /// The guide of a picture, made by the threads that this is called on.
    pub(crate) fn of(image: &Image) -> Guide {
        let (width, height) = (image.width, image.height);
        let lumas: Vec<f32> = image.pixels.iter().map(|pixel| luma(pixel) as f32).collect();
        let across = Window::of(BLUR * height as f64);
        let lumas = transposed(&across.blurred(lumas, width), width);
        let lumas = transposed(&across.blurred(lumas, height), height);
        Guide { width, height, lumas, reach: (REACH * height as f64) as f32 }
    }

    /// The luma at a pixel, row-major.
    pub(crate) fn luma(&self, at: usize) -> f32 {
        self.lumas[at]
    }

    /// Towards the light, in pixels, right and down: as far as the luma rises over the reach, and never as far as that.
    pub(crate) fn slope(&self, column: usize, row: usize) -> [f32; 2] {
        let at = |column: usize, row: usize| self.lumas[row * self.width + column];
        let (left, right) = (column.saturating_sub(1), (column + 1).min(self.width - 1));
        let (up, down) = (row.saturating_sub(1), (row + 1).min(self.height - 1));
        let half = 0.5 * self.reach;
        let [x, y] = [half * (at(right, row) - at(left, row)), half * (at(column, down) - at(column, up))];
        let scale = self.reach / (1.0 + x * x + y * y).sqrt();
        [x * scale, y * scale]
    }

    /// The ranks of its own places. They are a smooth function of every luma in the picture, so that they change as
    /// smoothly as the picture does; even where most of it is equally dark.
    pub(crate) fn ranks(&self) -> Ranks {
        let mut bins = vec![0.0; BINS + 2 * MARGIN];
        for luma in &self.lumas {
            let (bin, part) = Ranks::bin(*luma);
            bins[bin] += 1.0 - f64::from(part);
            bins[bin + 1] += f64::from(part);
        }
        for _ in 0..PASSES {
            bins = spread_out(&bins);
        }
        let mut below = 0.0;
        let count = self.lumas.len().max(1) as f64;
        let rank = |bin: f64| {
            // Half of those that are equal count as less.
            let rank = (below + 0.5 * bin) / count;
            below += bin;
            rank.clamp(0.0, 1.0) as f32
        };
        Ranks(bins.into_iter().map(rank).collect())
    }
}

impl Ranks {
    /// The part of places that are darker than `luma`, `0.0..=1.0`.
    pub(crate) fn of(&self, luma: f32) -> f32 {
        let (bin, part) = Ranks::bin(luma);
        self.0[bin] * (1.0 - part) + self.0[bin + 1] * part
    }

    /// The bin below a luma, and how far towards the next one it is.
    fn bin(luma: f32) -> (usize, f32) {
        let place = luma.clamp(0.0, 1.0) * (BINS - 1) as f32;
        let bin = (place as usize).min(BINS - 2);
        (bin + MARGIN, place - bin as f32)
    }
}

impl Window {
    fn of(deviation: f64) -> Window {
        let variance = deviation * deviation / PASSES as f64;
        let radius = ((1.0 + 12.0 * variance).sqrt() * 0.5 - 0.5).floor();
        let next = (radius + 1.0) * (radius + 1.0);
        let edge = (2.0 * radius + 1.0) * (radius * (radius + 1.0) - 3.0 * variance) / (6.0 * (variance - next));
        Window { radius: radius as usize, edge: edge.max(0.0) }
    }

    /// Rows of `width` values, each blurred along itself; beyond its ends a row goes on as it ends.
    fn blurred(self, mut rows: Vec<f32>, width: usize) -> Vec<f32> {
        rows.par_chunks_mut(width).for_each_init(
            || vec![0.0; width],
            |copy: &mut Vec<f32>, row| {
                for _ in 0..PASSES {
                    copy.copy_from_slice(row);
                    self.pass(copy, row);
                }
            },
        );
        rows
    }

    fn pass(self, from: &[f32], to: &mut [f32]) {
        let (last, radius) = (from.len() - 1, self.radius as isize);
        let at = |place: isize| f64::from(from[place.clamp(0, last as isize) as usize]);
        let weight = 1.0 / (2.0 * self.radius as f64 + 1.0 + 2.0 * self.edge);
        let mut sum: f64 = (-radius..=radius).map(at).sum();
        for (place, value) in to.iter_mut().enumerate() {
            let place = place as isize;
            let (before, after) = (at(place - radius - 1), at(place + radius + 1));
            *value = ((sum + self.edge * (before + after)) * weight) as f32;
            sum += after - at(place - radius);
        }
    }
}

/// Rows of `width` values as columns.
fn transposed(rows: &[f32], width: usize) -> Vec<f32> {
    let height = rows.len() / width;
    let mut columns = vec![0.0; rows.len()];
    columns.par_chunks_mut(height).enumerate().for_each(|(column, values)| {
        for (row, value) in values.iter_mut().enumerate() {
            *value = rows[row * width + column];
        }
    });
    columns
}

/// Each bin's count shared with its neighbours.
fn spread_out(bins: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; bins.len()];
    let share = 1.0 / (2 * ALIKE + 1) as f64;
    for (bin, value) in out.iter_mut().enumerate() {
        let near = bin.saturating_sub(ALIKE)..(bin + ALIKE + 1).min(bins.len());
        *value = bins[near].iter().sum::<f64>() * share;
    }
    out
}

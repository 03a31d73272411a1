//! A frame reduced to the means of blocks, in which joins are judged.
//!
//! Owns the reduction: in means the noise of the encoder nearly vanishes, and motion stays. Never compares two frames:
//! `figures.rs` does.
//!
//! Start at [`View::of`].

use video::Yuv420p;

/// Blocks across a picture, if they are larger than the smallest.
const BLOCKS_ACROSS: usize = 80;
/// The smallest block, in luma pixels: two blocks of the encoder's transform, so that their errors cancel in the mean.
const SMALLEST_BLOCK: usize = 16;
/// Blocks of the fine view along one side of a block of the broad view.
const BROAD: usize = 4;

/// The means of blocks of a frame, Y, U and V one after the other: each `0.0..=255.0`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct View {
    /// Blocks of 16 pixels where the picture is at most 1280 wide.
    pub(crate) fine: Vec<f32>,
    /// Blocks four times as wide and high.
    pub(crate) broad: Vec<f32>,
}

/// A plane of samples or of means.
struct Plane {
    width: usize,
    samples: Vec<f32>,
}

impl View {
    /// Reduces `picture`.
    pub(crate) fn of(picture: &Yuv420p) -> Self {
        let (width, _) = picture.size();
        let block = (width as usize).div_ceil(BLOCKS_ACROSS).next_multiple_of(2).max(SMALLEST_BLOCK);
        let (mut fine, mut broad) = (Vec::new(), Vec::new());
        for (number, samples) in picture.planes().into_iter().enumerate() {
            let chroma = usize::from(number > 0);
            let blocks = means(samples.chunks(width as usize >> chroma), block >> chroma, |sample| f32::from(*sample));
            broad.extend(means(blocks.samples.chunks(blocks.width), BROAD, |mean| *mean).samples);
            fine.extend(blocks.samples);
        }
        Self { fine, broad }
    }
}

/// The mean of every block of `block` by `block` samples, row by row; blocks at the right and lower edge are smaller.
fn means<'a, T: 'a>(rows: impl Iterator<Item = &'a [T]>, block: usize, value: impl Fn(&T) -> f32) -> Plane {
    let rows: Vec<&[T]> = rows.collect();
    let across = rows.first().map_or(0, |row| row.len());
    let mut samples = Vec::new();
    for band in rows.chunks(block) {
        let mut sums = vec![0.0; across.div_ceil(block)];
        for row in band {
            for (sum, samples) in sums.iter_mut().zip(row.chunks(block)) {
                *sum += samples.iter().map(&value).sum::<f32>();
            }
        }
        let size = |at: usize| (block.min(across - at * block) * band.len()) as f32;
        samples.extend(sums.into_iter().enumerate().map(|(at, sum)| sum / size(at)));
    }
    Plane { width: across.div_ceil(block).max(1), samples }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_at_the_edges_are_means_of_what_is_there() {
        let rows: [&[u8]; 3] = [&[1, 3, 10], &[5, 7, 20], &[100, 200, 250]];
        let plane = means(rows.into_iter(), 2, |sample| f32::from(*sample));
        assert_eq!((plane.width, plane.samples), (2, vec![4.0, 15.0, 150.0, 250.0]));
    }

    #[test]
    fn a_flat_picture_is_flat_in_every_view() {
        for (width, height) in [(1280, 720), (64, 64), (16, 16), (322, 182), (3840, 2160)] {
            let luma = (width * height) as usize;
            let samples = [vec![90; luma], vec![100; luma / 4], vec![110; luma / 4]].concat();
            let view = View::of(&Yuv420p::from_planes(width, height, &samples).unwrap());
            for means in [&view.fine, &view.broad] {
                let third = means.len() / 3;
                assert_eq!(means.len() % 3, 0, "{width}x{height}");
                assert!(means[..third].iter().all(|mean| (mean - 90.0).abs() < 1e-3), "{width}x{height}");
                assert!(means[2 * third..].iter().all(|mean| (mean - 110.0).abs() < 1e-3), "{width}x{height}");
            }
        }
        let pixels = 1280 * 720 * 3 / 2;
        let view = View::of(&Yuv420p::from_planes(1280, 720, &vec![0; pixels]).unwrap());
        assert_eq!((view.fine.len(), view.broad.len()), (3 * 80 * 45, 3 * 20 * 12));
    }
}

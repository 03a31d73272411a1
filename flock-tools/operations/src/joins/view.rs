//! A frame reduced to the means of blocks, in which joins are judged.
//!
//! Owns the reduction: in means the noise of the encoder nearly vanishes, and motion stays. Pictures of every size have the
//! same blocks, as parts of the picture, so that a clip is judged alike at every size. Never compares two frames:
//! `figures.rs` does.
//!
//! Start at [`View::of`].

use std::ops::Range;

use video::Yuv420p;

/// Blocks of a picture, nearly square: 80 across and 45 down at 16:9.
const BLOCKS: f64 = 3600.0;
/// The smallest block, in luma pixels: two of a plane of colour. Pictures below 320x180 have fewer blocks.
const SMALLEST_BLOCK: u32 = 4;
/// Blocks of the fine view along one side of a block of the broad view.
const BROAD: usize = 4;
/// The noise of x264 between the end of one clip and the keyframe of the next, as a squared distance in blocks of one pixel,
/// at a quantiser of 0. It grows by the factor 2 with every [`DOUBLING`] steps of the quantiser, and falls with the area
/// of a block. Measured at rate factors 17, 20, 26 and 34, in blocks of 4, 8 and 16 pixels: off by a third at most on slow
/// takes; fast ones have less.
const NOISE: f32 = 1.43;
const DOUBLING: f32 = 5.0;

/// The means of blocks of a frame, Y, U and V one after the other: each `0.0..=255.0`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct View {
    /// Blocks of 16 pixels where the picture has 1280x720.
    pub fine: Vec<f32>,
    /// Blocks four times as wide and high.
    pub broad: Vec<f32>,
    /// What its encoding adds to the squared distance from a frame that is encoded as coarsely, in the fine view.
    pub noise: f32,
}

impl View {
    /// Reduces `picture`, which is encoded with this mean `quantiser` of H.264; without one it counts as free of noise.
    pub(super) fn of(picture: &Yuv420p, quantiser: Option<f32>) -> Self {
        let size = picture.size();
        let (across, down) = grid(size);
        let area = size.0 as f32 * size.1 as f32 / (across * down) as f32;
        let noise = quantiser.map_or(0.0, |quantiser| NOISE * (quantiser / DOUBLING).exp2() / area);
        let (mut fine, mut broad) = (Vec::new(), Vec::new());
        for (number, samples) in picture.planes().into_iter().enumerate() {
            let chroma = usize::from(number > 0);
            let (width, height) = (size.0 as usize >> chroma, size.1 as usize >> chroma);
            let blocks =
                means(samples, width, &parts(width, across), &parts(height, down), |sample| f32::from(*sample));
            let groups = [across, down].map(|blocks| parts(blocks, blocks.div_ceil(BROAD)));
            broad.extend(means(&blocks, across, &groups[0], &groups[1], |mean| *mean));
            fine.extend(blocks);
        }
        Self { fine, broad, noise }
    }
}

/// How many blocks a picture of this size has across and down.
fn grid((width, height): (u32, u32)) -> (usize, usize) {
    let side = (f64::from(width) * f64::from(height) / BLOCKS).sqrt();
    let blocks = |length: u32| {
        let most = (length / SMALLEST_BLOCK).max(1);
        (f64::from(length) / side).round().clamp(1.0, f64::from(most)) as usize
    };
    (blocks(width), blocks(height))
}

/// `0..length` in so many parts, as equal as whole numbers can be.
fn parts(length: usize, count: usize) -> Vec<Range<usize>> {
    (0..count).map(|part| part * length / count..(part + 1) * length / count).collect()
}

/// The mean of every block of `samples`, which are rows of `width`: blocks row by row, by their `columns` and `rows`.
fn means<T>(
    samples: &[T],
    width: usize,
    columns: &[Range<usize>],
    rows: &[Range<usize>],
    value: impl Fn(&T) -> f32,
) -> Vec<f32> {
    let mut means = Vec::with_capacity(columns.len() * rows.len());
    for band in rows {
        let mut sums = vec![0.0; columns.len()];
        for row in samples[band.start * width..band.end * width].chunks(width) {
            for (sum, column) in sums.iter_mut().zip(columns) {
                *sum += row[column.clone()].iter().map(&value).sum::<f32>();
            }
        }
        means.extend(sums.iter().zip(columns).map(|(sum, column)| sum / (column.len() * band.len()) as f32));
    }
    means
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_means_of_what_is_there() {
        let samples: [u8; 9] = [1, 3, 10, 5, 7, 20, 100, 200, 250];
        let means = means(&samples, 3, &parts(3, 2), &parts(3, 2), |sample| f32::from(*sample));
        assert_eq!(means, [1.0, 6.5, 52.5, 119.25]);
        assert_eq!(parts(3, 2), [0..1, 1..3]);
    }

    #[test]
    fn pictures_of_every_size_have_the_same_blocks() {
        for size in [(320, 180), (640, 360), (1280, 720), (1920, 1080), (3840, 2160)] {
            assert_eq!(grid(size), (80, 45), "{size:?}");
        }
        assert_eq!(grid((720, 1280)), (45, 80));
        assert_eq!(grid((960, 960)), (60, 60));
        // Blocks of 4 pixels, or one.
        for (size, blocks) in [((160, 90), (40, 22)), ((64, 64), (16, 16)), ((2, 2), (1, 1)), ((4096, 2), (1024, 1))] {
            assert_eq!(grid(size), blocks, "{size:?}");
        }
    }

    #[test]
    fn a_flat_picture_is_flat_in_every_view() {
        for (width, height) in [(1280, 720), (64, 64), (16, 16), (322, 182), (3840, 2160), (2, 2), (720, 1280)] {
            let luma = (width * height) as usize;
            let samples = [vec![90; luma], vec![100; luma / 4], vec![110; luma / 4]].concat();
            let view = View::of(&Yuv420p::from_planes(width, height, &samples).unwrap(), None);
            for means in [&view.fine, &view.broad] {
                let third = means.len() / 3;
                assert_eq!(means.len() % 3, 0, "{width}x{height}");
                assert!(means[..third].iter().all(|mean| (mean - 90.0).abs() < 1e-3), "{width}x{height}");
                assert!(means[2 * third..].iter().all(|mean| (mean - 110.0).abs() < 1e-3), "{width}x{height}");
            }
        }
        let pixels = 1280 * 720 * 3 / 2;
        let view = View::of(&Yuv420p::from_planes(1280, 720, &vec![0; pixels]).unwrap(), None);
        assert_eq!((view.fine.len(), view.broad.len()), (3 * 80 * 45, 3 * 20 * 12));
    }

    #[test]
    fn small_and_coarse_pictures_have_more_noise() {
        let noise = |(width, height): (u32, u32), quantiser| {
            let samples = vec![90; (width * height * 3 / 2) as usize];
            View::of(&Yuv420p::from_planes(width, height, &samples).unwrap(), quantiser).noise
        };
        assert!(noise((1280, 720), None).abs() < 1e-9);
        let [large, small, coarse] = [((1280, 720), 30.0), ((320, 180), 30.0), ((320, 180), 35.0)]
            .map(|(size, quantiser)| noise(size, Some(quantiser)));
        assert!((small / large - 16.0).abs() < 1e-3 && (coarse / small - 2.0).abs() < 1e-3, "{large} {small} {coarse}");
    }
}

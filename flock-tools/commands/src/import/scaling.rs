//! Scales pictures to the size of the flock.
//!
//! Owns the scaling, and the choice between cropping and padding where the shape differs: the artist makes it. Never decodes
//! and never encodes.
//!
//! Start at [`Scaling::new`].

use scaling::{Filter, Plane, Scaler, ScalingError};
use video::{ForeignPicture, VideoInfo, Yuv420p};

/// How a picture of another shape is scaled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Fit {
    /// Fill the flock's picture and cut off what sticks out
    Crop,
    /// Show all of it and leave black what it does not fill
    Pad,
}

/// How the pictures of one video are scaled to the flock's size.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Scaling {
    /// The flock's width and height.
    size: (u32, u32),
    /// The part of the picture that is used: left, top, width and height, in its pixels; `None`: all of it.
    cut: Option<[f64; 4]>,
    /// Its place in the flock's picture: left, top, width and height, in pixels.
    put: [u32; 4],
}

impl Scaling {
    /// The scaling of pictures of the video `about` to `size`.
    /// Errors: In words, if their shape is another and `fit` is `None`.
    pub(super) fn new(about: &VideoInfo, size: (u32, u32), fit: Option<Fit>) -> Result<Self, String> {
        let (width, height) = (f64::from(about.size.0), f64::from(about.size.1));
        let full = [f64::from(size.0), f64::from(size.1)];
        // The width on a screen with square pixels.
        let shown = width * f64::from(about.pixel.0) / f64::from(about.pixel.1);
        let scales = [full[0] / shown, full[1] / height];
        let whole = Self { size, cut: None, put: [0, 0, size.0, size.1] };
        // To the nearest pixel of the flock's it is the same shape.
        let off = [(shown * scales[1] - full[0]).abs(), (height * scales[0] - full[1]).abs()];
        if off[0].min(off[1]) <= 1.0 {
            return Ok(whole);
        }
        match fit {
            None => Err(format!(
                "has another shape: {}x{} pixels{} (expected that of {}x{}; --fit crop or --fit pad)",
                about.size.0,
                about.size.1,
                if about.pixel.0 == about.pixel.1 {
                    String::new()
                } else {
                    format!(", each {} wide and {} high", about.pixel.0, about.pixel.1)
                },
                size.0,
                size.1
            )),
            Some(Fit::Crop) => {
                let scale = scales[0].max(scales[1]);
                let (wide, high) = ((width * full[0] / (shown * scale)).min(width), (full[1] / scale).min(height));
                Ok(Self { cut: Some([(width - wide) / 2.0, (height - high) / 2.0, wide, high]), ..whole })
            }
            Some(Fit::Pad) => {
                let scale = scales[0].min(scales[1]);
                // Even, as the chroma has half as many samples.
                let side = |length: f64, most: u32| (2 * (length * scale / 2.0).round() as u32).clamp(2, most);
                let (wide, high) = (side(shown, size.0), side(height, size.1));
                let left = |most: u32, side: u32| (most - side) / 4 * 2;
                Ok(Self { put: [left(size.0, wide), left(size.1, high), wide, high], ..whole })
            }
        }
    }

    /// The picture in the flock's size and colours. If neither differs, its samples are not changed.
    /// Errors: The scaler's error.
    pub(super) fn picture(&self, picture: &ForeignPicture) -> Result<Yuv420p, String> {
        let (width, height) = picture.size();
        let same = picture.size() == self.size && self.put == [0, 0, width, height] && self.cut.is_none();
        match picture.to_yuv420p() {
            Some(samples) if same => return Ok(samples),
            Some(samples) => return self.scaled_planes(&samples),
            None => (),
        }
        let mut rgb = picture.to_rgb();
        if !same {
            rgb = self.scaled(picture.size(), &rgb)?;
        }
        Yuv420p::from_rgb_f32(self.size.0, self.size.1, &rgb).map_err(|error| error.to_string())
    }

    /// The picture, scaled plane by plane: far quicker than by way of RGB.
    fn scaled_planes(&self, picture: &Yuv420p) -> Result<Yuv420p, String> {
        let mut samples = Vec::new();
        for (at, plane) in picture.planes().into_iter().enumerate() {
            samples.extend(self.scaled_plane(picture.size(), plane, at > 0)?);
        }
        Yuv420p::from_planes(self.size.0, self.size.1, &samples).map_err(|error| error.to_string())
    }

    /// One plane of a picture of this width and height.
    fn scaled_plane(&self, (width, height): (u32, u32), plane: &[u8], is_chroma: bool) -> Result<Vec<u8>, String> {
        let (half, black) = if is_chroma { (2, 128) } else { (1, 16) };
        let (across, down) = (width / half, height / half);
        let [left, top, wide, high] = self.put.map(|side| side / half);
        let cut =
            self.cut.unwrap_or([0.0, 0.0, f64::from(width), f64::from(height)]).map(|side| side / f64::from(half));
        // Chroma sits a quarter of its width left of the middle of its place, before scaling and after it.
        let shift = if is_chroma { 0.25 * (1.0 - cut[2] / f64::from(wide)) } else { 0.0 };
        let margin = shift.abs().ceil() as usize;
        let widened: Vec<u8> = plane
            .chunks_exact(across as usize)
            .flat_map(|row| {
                let [first, last] = [row[0], row[row.len() - 1]].map(|level| std::iter::repeat_n(level, margin));
                first.chain(row.iter().copied()).chain(last)
            })
            .collect();
        let stride = across + 2 * margin as u32;
        let full = Plane { samples: &widened, stride, size: (stride, down) };
        let mut small = vec![0; (wide * high) as usize];
        let cut = [cut[0] + margin as f64 + shift, cut[1], cut[2], cut[3]];
        let scaled = Scaler::default().plane(full, Some(cut), Filter::Lanczos3, &mut small, (wide, high));
        scaled.map_err(refusal)?;
        let (across, down) = ((self.size.0 / half) as usize, (self.size.1 / half) as usize);
        let mut placed = vec![black; across * down];
        for (y, row) in small.chunks_exact(wide as usize).enumerate() {
            let start = (y + top as usize) * across + left as usize;
            placed[start..][..row.len()].copy_from_slice(row);
        }
        Ok(placed)
    }

    fn scaled(&self, size: (u32, u32), rgb: &[f32]) -> Result<Vec<f32>, String> {
        let [left, top, wide, high] = self.put;
        let small = Scaler::default().rgb_f32(rgb, size, self.cut, (wide, high), Filter::Lanczos3);
        let small = small.map_err(refusal)?;
        let (across, down) = (self.size.0 as usize, self.size.1 as usize);
        let mut placed = vec![0.0; 3 * across * down];
        for (y, row) in small.chunks(wide as usize).enumerate() {
            let start = 3 * ((y + top as usize) * across + left as usize);
            for (to, from) in placed[start..].chunks_exact_mut(3).zip(row) {
                to.copy_from_slice(from);
            }
        }
        Ok(placed)
    }
}

fn refusal(error: ScalingError) -> String {
    format!("cannot be scaled: {error}")
}

#[cfg(test)]
mod tests {
    use video::Orientation;

    use super::*;

    fn about(size: (u32, u32), pixel: (u32, u32)) -> VideoInfo {
        let (codec, tags) = ("mpeg4".to_owned(), Vec::new());
        let orientation = Orientation::UPRIGHT;
        VideoInfo { codec, size, pixel, orientation, fps: None, frames: None, seconds: None, matrix: None, tags }
    }

    #[test]
    fn the_same_shape_is_scaled_and_another_one_is_refused_with_both() {
        for (size, pixel) in [((1280, 720), (1, 1)), ((640, 360), (1, 1)), ((641, 361), (1, 1)), ((720, 576), (64, 45))]
        {
            let scaling = Scaling::new(&about(size, pixel), (1280, 720), None).unwrap();
            assert_eq!((scaling.cut, scaling.put), (None, [0, 0, 1280, 720]), "{size:?}");
        }
        let refused = Scaling::new(&about((640, 480), (1, 1)), (1280, 720), None).unwrap_err();
        assert!(refused.contains("640x480") && refused.contains("1280x720"), "{refused}");
        let refused = Scaling::new(&about((720, 576), (16, 15)), (1280, 720), None).unwrap_err();
        assert!(refused.contains("each 16 wide and 15 high"), "{refused}");
    }

    #[test]
    fn what_sticks_out_is_cut_on_both_sides_and_what_is_missing_is_left_on_both() {
        let scaling = |fit| Scaling::new(&about((640, 480), (1, 1)), (1280, 720), Some(fit)).unwrap();
        assert_eq!(scaling(Fit::Crop).cut, Some([0.0, 60.0, 640.0, 360.0]));
        assert_eq!(scaling(Fit::Crop).put, [0, 0, 1280, 720]);
        assert_eq!(scaling(Fit::Pad).put, [160, 0, 960, 720]);
        assert_eq!(scaling(Fit::Pad).cut, None);
        let padded = scaling(Fit::Pad).scaled((640, 480), &vec![0.5; 3 * 640 * 480]).unwrap();
        let is = |x: usize, y: usize, level: f32| (padded[3 * (y * 1280 + x)] - level).abs() < 1e-5;
        assert!(is(159, 0, 0.0) && is(1120, 719, 0.0) && is(160, 0, 0.5) && is(1119, 719, 0.5));
    }

    #[test]
    fn planes_are_scaled_to_what_their_picture_is_scaled_to() {
        let level = |x: u32, y: u32| [x as f32 / 64.0, y as f32 / 48.0, (x + y) as f32 / 112.0];
        let rgb: Vec<f32> = (0..48).flat_map(|y| (0..64).flat_map(move |x| level(x, y))).collect();
        let picture = Yuv420p::from_rgb_f32(64, 48, &rgb).unwrap();
        for (size, fit) in [((160, 90), Fit::Crop), ((160, 90), Fit::Pad), ((32, 18), Fit::Crop), ((32, 24), Fit::Pad)]
        {
            let scaling = Scaling::new(&about((64, 48), (1, 1)), size, Some(fit)).unwrap();
            let found = scaling.scaled_planes(&picture).unwrap();
            let due = Yuv420p::from_rgb_f32(size.0, size.1, &scaling.scaled((64, 48), &rgb).unwrap()).unwrap();
            let mean = |plane: usize| {
                let pairs = found.planes()[plane].iter().zip(due.planes()[plane]);
                pairs.map(|(found, due)| f64::from(found.abs_diff(*due))).sum::<f64>()
                    / due.planes()[plane].len() as f64
            };
            assert!((0..3).all(|plane| mean(plane) < 1.0), "{size:?} {fit:?}: {:?}", [mean(0), mean(1), mean(2)]);
        }
    }
}

//! A small picture of each sheep.
//!
//! Owns the choice of its source: the first frame of the loop; for a sheep without one, the first frame of a transition that
//! leaves it; if no clip is there, a still of the genome. A sheep without all of these has no picture. Never judges a clip:
//! `dreams check` does.
//!
//! Start at [`all`].

use std::path::Path;

use ::species::{Settings, Threads};
use ct_codecs::{Base64, Encoder as _};
use flame::Backend;
use flock::{Clip, Manifest, Sheep, Transition};
use jpeg_encoder::{ColorType, Encoder, SamplingFactor};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use video::{Form, Yuv420p};

use super::colour::Colour;
use crate::decoder::Decoder;
use crate::decoder::thumbnail::Thumbnail;
use crate::species;

/// The most pixels of all pictures of a page together, and the most that one is wide.
const PIXELS: f64 = 8.5e6;
const WIDEST: u32 = 400;
/// The most bytes of all pictures of a page together; as text they are 6 MB.
const BYTES: usize = 4_400_000;
/// Qualities that are tried until a picture is small enough; the last one is used in any case.
const QUALITIES: [u8; 4] = [84, 72, 56, 40];
/// Samples per pixel of a still that is rendered if there is no clip.
const STILL_SPP: f64 = 60.0;

/// A picture as the page has it.
#[derive(Debug, PartialEq, Eq)]
pub struct Picture {
    /// `data:image/jpeg;base64,...`
    pub url: String,
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// Its most striking colour.
    pub colour: Colour,
}

/// The pictures of `sheep` of the flock in `folder`, in their order. Uses all cores.
pub fn all(
    folder: &Path,
    manifest: &Manifest,
    sheep: &[&Sheep],
    decoder: Option<&dyn Decoder>,
) -> Vec<Option<Picture>> {
    let size = size(manifest.size, sheep.len());
    let form = Form { size: manifest.size, fps: manifest.fps };
    let most = BYTES / sheep.len().max(1);
    let of = |sheep: &&Sheep| {
        let frame = |clip: &Clip| first_frame(decoder?, folder, clip, &form, size);
        let own = sheep.clip.as_ref().and_then(frame);
        let leaves = |transition: &&Transition| sheep.clip.is_none() && transition.from == sheep.id;
        let passed = || manifest.transitions.iter().filter(leaves).find_map(|transition| frame(&transition.clip));
        let pixels = own.or_else(passed).or_else(|| still(folder, sheep, size))?;
        Picture::of(&pixels, most)
    };
    sheep.par_iter().map(of).collect()
}

/// The size of each of `count` pictures of clips of `full` size.
fn size(full: (u32, u32), count: usize) -> (u32, u32) {
    let aspect = f64::from(full.0) / f64::from(full.1);
    let widest = (PIXELS / count.max(1) as f64 * aspect).sqrt() as u32;
    let width = widest.min(WIDEST).min(full.0) / 2 * 2;
    let height = (f64::from(width) / aspect / 2.0).round() as u32 * 2;
    (width.max(2), height.clamp(2, full.1))
}

impl Picture {
    /// `pixels` in at most about `most` bytes. `None` if they are no picture.
    pub fn of(pixels: &Thumbnail, most: usize) -> Option<Self> {
        let colour = Colour::of_picture(&pixels.rgb);
        let bytes = jpeg(pixels, most)?;
        let url = format!("data:image/jpeg;base64,{}", Base64::encode_to_string(&bytes).ok()?);
        Some(Self { url, size: pixels.size, colour })
    }
}

/// `pixels` as a JPEG in at most about `most` bytes. `None` if they are no picture.
pub fn jpeg(pixels: &Thumbnail, most: usize) -> Option<Vec<u8>> {
    let (width, height) = (u16::try_from(pixels.size.0).ok()?, u16::try_from(pixels.size.1).ok()?);
    let mut bytes = Vec::new();
    for quality in QUALITIES {
        bytes.clear();
        let mut encoder = Encoder::new(&mut bytes, quality);
        encoder.set_sampling_factor(SamplingFactor::F_2_2);
        encoder.encode(&pixels.rgb, width, height, ColorType::Rgb).ok()?;
        if bytes.len() <= most {
            break;
        }
    }
    Some(bytes)
}

/// The first frame of `clip`, shrunk to `size`, if it is there and in the flock's form.
fn first_frame(decoder: &dyn Decoder, folder: &Path, clip: &Clip, form: &Form, size: (u32, u32)) -> Option<Thumbnail> {
    let mut first = None;
    decoder.play(folder, form, &[(clip, 0..1)], &mut |_, frame| first = averaged(&frame.picture, size));
    first
}

/// `frame` shrunk to `size`, which is not larger than it.
fn averaged(frame: &Yuv420p, size: (u32, u32)) -> Option<Thumbnail> {
    averaged_planes(frame.planes(), frame.strides(), frame.size(), size)
}

/// The same of the Y, U and V of a frame of `full` size, whose rows begin every `strides` bytes.
pub fn averaged_planes(
    planes: [&[u8]; 3],
    strides: [usize; 3],
    full: (u32, u32),
    size: (u32, u32),
) -> Option<Thumbnail> {
    let mut samples = Vec::with_capacity((size.0 * size.1 * 3 / 2) as usize);
    for (number, (plane, stride)) in planes.into_iter().zip(strides).enumerate() {
        let half = u32::from(number > 0);
        let [full, small] = [full, size].map(|size| ((size.0 >> half) as usize, (size.1 >> half) as usize));
        shrink(plane, stride, full, small, &mut samples);
    }
    let rgb = Yuv420p::from_planes(size.0, size.1, &samples).ok()?.to_rgb8();
    Some(Thumbnail { size, rgb })
}

/// Appends `plane` shrunk from `full` to `small`: every sample is the mean of those that it covers.
fn shrink(plane: &[u8], stride: usize, full: (usize, usize), small: (usize, usize), samples: &mut Vec<u8>) {
    let part = |at: usize, full: usize, small: usize| {
        let start = at * full / small;
        start..((at + 1) * full / small).max(start + 1)
    };
    for y in 0..small.1 {
        let rows = part(y, full.1, small.1);
        for x in 0..small.0 {
            let columns = part(x, full.0, small.0);
            let count = (rows.len() * columns.len()) as u32;
            let row_sum =
                |row: usize| plane[row * stride..][columns.clone()].iter().map(|&s| u32::from(s)).sum::<u32>();
            let sum: u32 = rows.clone().map(row_sum).sum();
            samples.push(((sum + count / 2) / count) as u8);
        }
    }
}

/// The still of the sheep's genome, if it has one that can be rendered.
fn still(folder: &Path, sheep: &Sheep, size: (u32, u32)) -> Option<Thumbnail> {
    let genome = species::read(&sheep.genome.as_ref()?.inside(folder), &Backend::default()).ok()?;
    let settings = Settings {
        size: [size.0, size.1],
        spp: Some(STILL_SPP),
        psnr: None,
        supersample: Some(2),
        temporal_samples: Some(1),
        smooths: true,
        seed: 0,
    };
    let drawn = genome.turning(settings.size, 1.0).frame(0.0, &settings, &Threads::new(1).ok()?).ok()?;
    Some(Thumbnail { size, rgb: drawn.image.to_rgb8() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_sheep_have_large_pictures_and_many_small_ones_all_of_the_clips_shape() {
        assert_eq!(size((1280, 720), 3), (400, 226));
        assert_eq!(size((1280, 720), 300), (224, 126));
        assert_eq!(size((320, 240), 3), (320, 240));
        for count in [1, 2, 30, 95, 200, 1000, 20_000] {
            for full in [(1280, 720), (720, 1280), (16, 16), (4096, 16), (16, 4096), (1920, 1200)] {
                let (width, height) = size(full, count);
                assert!(width >= 2 && height >= 2 && width <= full.0 && height <= full.1, "{full:?} {count}");
                assert!(width % 2 == 0 && height % 2 == 0, "{full:?} {count}");
            }
        }
    }

    #[test]
    fn shrinking_takes_the_mean_of_what_a_sample_covers() {
        // 5x4 with a stride of 6, to 2x2: columns 0-1 and 2-4, rows 0-1 and 2-3.
        let plane: Vec<u8> = (0..24).map(|at| if at % 6 == 5 { 255 } else { at }).collect();
        let mut samples = Vec::new();
        shrink(&plane, 6, (5, 4), (2, 2), &mut samples);
        assert_eq!(samples, [4, 6, 16, 18]);
    }

    #[test]
    fn three_hundred_pictures_stay_small_whatever_they_show() {
        let size = size((1280, 720), 300);
        let noise = |at: u32| (at.wrapping_mul(2_654_435_761) >> 13) as u8;
        let pixels = Thumbnail { size, rgb: (0..size.0 * size.1 * 3).map(noise).collect() };
        let picture = Picture::of(&pixels, BYTES / 300).unwrap();
        assert!(300 * picture.url.len() < 6_000_000, "{}", picture.url.len());
    }
}

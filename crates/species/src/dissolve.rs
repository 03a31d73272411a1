//! The transition between pictures of any two species.
//!
//! Owns how two moving pictures become one: both loops run on, each is drawn towards the other's light, the second arrives
//! where it is bright first, and contrast that is lost is restored. All that changes is eased by s = 3b^2 - 2b^3, whose
//! speed is 0 at both ends: frame 0 is the first's own, the last frame the second's, to the bit, and both go on at their
//! own speeds there. Never knows what is in a picture.
//!
//! Start at [`Dissolve`].

use rayon::iter::{IndexedParallelIterator, IntoParallelRefMutIterator, ParallelIterator};
use rayon::slice::ParallelSliceMut;

use crate::contract::{Demand, Drawn, Motion, RenderError, Settings};
use crate::guide::{Guide, Ranks};
use crate::image::Image;
use crate::luma::{luma, spread};
use crate::threads::Threads;

/// The part of the way that a place takes from the first picture to the second.
const SOFT: f32 = 0.6;

/// The most by which contrast that is lost between two pictures is raised.
const MOST_GAIN: f64 = 2.0;

/// The way from one motion to another, in pictures.
pub struct Dissolve {
    sides: [Box<dyn Motion>; 2],
    frames: f64,
}

/// The sides' pictures do not have the same size.
#[derive(Debug, thiserror::Error)]
#[error("pictures of {from:?} and {to:?} pixels cannot be dissolved")]
struct SizeError {
    from: [usize; 2],
    to: [usize; 2],
}

/// Both pictures, and what leads one into the other.
struct Pair<'p> {
    images: [&'p Image; 2],
    guides: [Guide; 2],
    /// Of the second's guide.
    ranks: Ranks,
    eased: f32,
}

impl Dissolve {
    /// The version of its pictures: with another one, the same sides make other bits.
    pub const VERSION: u32 = 1;

    /// From the first to the second in `frames` frames (> 0): frame 0 is the first's frame 0, and frame `frames` the
    /// second's. The first goes on to its frame `frames`, the second comes from its frame -`frames`.
    pub fn new(sides: [Box<dyn Motion>; 2], frames: f64) -> Dissolve {
        Dissolve { sides, frames }
    }

    /// How far it has come, `0.0..=1.0`, as it is eased.
    fn eased(&self, frame: f64) -> f32 {
        let b = (frame / self.frames).clamp(0.0, 1.0);
        (b * b * (3.0 - 2.0 * b)) as f32
    }

    /// The only side of which the picture is made; `None` if it is made of both.
    fn only(eased: f32) -> Option<usize> {
        match eased {
            0.0 => Some(0),
            1.0 => Some(1),
            _ => None,
        }
    }

    /// The frame of a side.
    fn frame_of(&self, side: usize, frame: f64) -> f64 {
        if side == 0 { frame } else { frame - self.frames }
    }
}

impl Motion for Dissolve {
    fn demand(&self, frame: f64, settings: &Settings) -> Result<Demand, RenderError> {
        let side = |side: usize| self.sides[side].demand(self.frame_of(side, frame), settings);
        if let Some(only) = Dissolve::only(self.eased(frame)) {
            return side(only);
        }
        let [from, to] = [side(0)?, side(1)?];
        let pixels: u64 = settings.size.map(u64::from).iter().product();
        let longer = settings.size.map(u64::from).into_iter().max().unwrap_or(0);
        // Three pictures and two guides, or the first picture while the second is drawn; and some room for the ranks.
        let own = pixels * (3 * size_of::<[f32; 3]>() as u64 + 2 * Guide::BYTES) + (1 << 16);
        Ok(Demand {
            samples: from.samples.saturating_add(to.samples),
            bytes: from.bytes.max(to.bytes).saturating_add(own),
            bytes_per_thread: from.bytes_per_thread.max(to.bytes_per_thread) + longer * Guide::BYTES_PER_THREAD,
        })
    }

    fn frame(&self, frame: f64, settings: &Settings, threads: &Threads) -> Result<Drawn, RenderError> {
        let side = |side: usize| self.sides[side].frame(self.frame_of(side, frame), settings, threads);
        let eased = self.eased(frame);
        if let Some(only) = Dissolve::only(eased) {
            return side(only);
        }
        let [from, to] = [side(0)?, side(1)?];
        let psnr = match (from.psnr, to.psnr) {
            (Some(from), Some(to)) => Some(from.min(to)),
            (from, to) => from.or(to),
        };
        let image = threads.run(|| mixed([&from.image, &to.image], eased, threads))?;
        Ok(Drawn { image, samples: from.samples + to.samples, psnr })
    }

    fn is_noisy(&self) -> bool {
        self.sides.iter().any(|side| side.is_noisy())
    }
}

/// The picture between two.
fn mixed(images: [&Image; 2], eased: f32, threads: &Threads) -> Result<Image, RenderError> {
    let [from, to] = images.map(|image| [image.width, image.height]);
    if from != to {
        return Err(RenderError::Refused(SizeError { from, to }.into()));
    }
    let guide = |image: &Image| if threads.are_stopped() { Err(RenderError::Stopped) } else { Ok(Guide::of(image)) };
    let guides = [guide(images[0])?, guide(images[1])?];
    let pair = Pair { images, ranks: guides[1].ranks(), guides, eased };
    let [width, height] = from;
    let mut pixels = vec![[0.0; 3]; width * height];
    pixels.par_chunks_mut(width).enumerate().for_each(|(row, pixels)| {
        if !threads.are_stopped() {
            pixels.iter_mut().enumerate().for_each(|(column, pixel)| *pixel = pair.pixel(column, row));
        }
    });
    if threads.are_stopped() {
        return Err(RenderError::Stopped);
    }
    pair.restore_contrast(&mut pixels);
    Ok(Image { width, height, pixels })
}

impl Pair<'_> {
    fn pixel(&self, column: usize, row: usize) -> [f32; 3] {
        let at = row * self.images[0].width + column;
        let late = 1.0 - self.ranks.of(self.guides[1].luma(at));
        let part = ((self.eased * (1.0 + SOFT) - late) / SOFT).clamp(0.0, 1.0);
        let part = part * part * (3.0 - 2.0 * part);
        let led = |side: usize, by: f32| {
            let [x, y] = self.guides[1 - side].slope(column, row);
            sampled(self.images[side], [column, row], [x * by, y * by])
        };
        if part <= 0.0 {
            return led(0, self.eased);
        }
        if part >= 1.0 {
            return led(1, self.eased - 1.0);
        }
        let [from, to] = [led(0, self.eased), led(1, self.eased - 1.0)];
        [0, 1, 2].map(|channel| from[channel] * (1.0 - part) + to[channel] * part)
    }
}

impl Pair<'_> {
    /// What is between two pictures has less contrast than either: it is raised to what is expected on the way, around the
    /// mean, so that it neither pales nor gets darker.
    fn restore_contrast(&self, pixels: &mut [[f32; 3]]) {
        let contrast = |pixels: &[[f32; 3]]| spread(pixels.iter().map(luma));
        let [from, to] = self.images.map(|image| contrast(&image.pixels)[1]);
        let expected = from + (to - from) * f64::from(self.eased);
        let [mean, found] = contrast(pixels);
        let gain = (expected / found.max(1e-6)).clamp(1.0, MOST_GAIN) as f32;
        let mean = mean as f32;
        if gain > 1.0 {
            let raise = |light: f32| (mean + (light - mean) * gain).clamp(0.0, 1.0);
            pixels.par_iter_mut().for_each(|pixel| *pixel = pixel.map(raise));
        }
    }
}

/// The light `off` pixels from a pixel, right and down; beyond its edges a picture goes on as it ends.
///
/// # Source
/// Catmull & Rom, *A class of local interpolating splines* (1974): sharper than between two pixels, so that what is led a
/// part of a pixel looks like what is not.
fn sampled(image: &Image, [column, row]: [usize; 2], off: [f32; 2]) -> [f32; 3] {
    let whole = off.map(f32::floor);
    let [across, down] = [0, 1].map(|axis| weights(off[axis] - whole[axis]));
    let first = [column as isize + whole[0] as isize - 1, row as isize + whole[1] as isize - 1];
    let within = |place: isize, side: usize| place.clamp(0, side as isize - 1) as usize;
    let columns: [usize; 4] = std::array::from_fn(|tap| within(first[0] + tap as isize, image.width));
    let mut light = [0.0; 3];
    for (tap, down) in down.into_iter().enumerate() {
        let start = within(first[1] + tap as isize, image.height) * image.width;
        let taps = columns.map(|column| &image.pixels[start + column]);
        for (channel, light) in light.iter_mut().enumerate() {
            let along: f32 = taps.iter().zip(across).map(|(pixel, weight)| pixel[channel] * weight).sum();
            *light += along * down;
        }
    }
    light.map(|light| light.clamp(0.0, 1.0))
}

/// Of the four pixels around a place, `x` (`0.0..=1.0`) after the second.
fn weights(x: f32) -> [f32; 4] {
    let (square, cube) = (x * x, x * x * x);
    [
        0.5 * (2.0 * square - cube - x),
        0.5 * (3.0 * cube - 5.0 * square + 2.0),
        0.5 * (4.0 * square - 3.0 * cube + x),
        0.5 * (cube - square),
    ]
}

#[cfg(test)]
mod tests;

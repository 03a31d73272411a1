//! From a film to displayable light.
//!
//! Owns gamma, vibrancy and highlights, and the order in which filters come. Never draws samples.
//!
//! Start at [`develop`]; `density.rs` has log-density and the spatial filter, `wiener.rs` and `spread.rs` smooth noise,
//! `look.rs` has what other programs make of light.
//!
//! # Source
//! Draves & Reckase, *The Fractal Flame Algorithm* (2008), log-density display, gamma, vibrancy. The constants
//! are those that make `brightness` mean what it means in flam3 files, found by comparing pictures.

use std::sync::atomic::AtomicBool;

use rayon::prelude::{IndexedParallelIterator, ParallelIterator, ParallelSlice, ParallelSliceMut};

use super::density::{self, Scale};
use super::film::Film;
use super::look::Look;
use super::spread::Spread;
use super::{Filter, FrameSetup, wiener};
use crate::genome::Tone;
use crate::genome::palette::{from_hsv, to_hsv};
use species::Image;

/// Full light in flam3's own scale of 256 steps to a byte's 255.
const WHITE: f64 = 256.0 / 255.0;

/// Displayable light of a frame.
pub(super) struct Developed {
    pub(super) image: Image,
    /// The mean square of its noise, where one is aimed at.
    pub(super) noise: Option<f64>,
}

/// How log-density becomes light.
struct Exposure<'a> {
    tone: &'a Tone,
    look: Option<Look>,
}

/// Makes displayable light of what is on `film`, which keeps its samples only where more may follow; anything, once `stop`
/// is set.
///
/// * `share` — how many samples were drawn, as a part of those that are asked for.
pub(super) fn develop(film: &mut Film, setup: &FrameSetup, share: f64, stop: &AtomicBool) -> Developed {
    let FrameSetup { genome, view, .. } = setup;
    if genome.finish.low_density == 0.0 {
        develop_by(film, setup, Scale::<false>::new(genome, view, share), stop)
    } else {
        develop_by(film, setup, Scale::<true>::new(genome, view, share), stop)
    }
}

fn develop_by<const THIN: bool>(
    film: &mut Film,
    setup: &FrameSetup,
    scale: Scale<THIN>,
    stop: &AtomicBool,
) -> Developed {
    let FrameSetup { genome, view, filter, target, .. } = setup;
    let exposure = Exposure { tone: &genome.tone, look: Look::new(&genome.finish) };
    let [width, height] = view.size;
    let image = |pixels| Image { width, height, pixels };
    if film.is_halved() {
        let mut pixels = density::of_halves(film, scale, view, stop);
        if target.is_none() {
            film.clear();
        }
        if *filter == Filter::Variance {
            pixels = wiener::denoise(pixels, view.size, stop);
        }
        let noise = target.map(|_| exposure.noise(&pixels, width));
        return Developed { image: image(exposure.light(&pixels, width)), noise };
    }
    let pixels = if *filter == Filter::Flam3 {
        let light = film.light(view.cells[0] * view.cells[1]);
        let spread = Spread::new(&light, view, &genome.sampling);
        let cells = spread.apply(&light.into_iter().map(|cell| scale.log(cell)).collect::<Vec<_>>());
        let across = view.cells[0];
        density::pixels(view, stop, |row, out| out.copy_from_slice(&cells[row * across..(row + 1) * across]))
    } else {
        density::of_film(film, scale, view, stop)
    };
    Developed { image: image(exposure.light(&pixels, width)), noise: None }
}

impl Exposure<'_> {
    /// Displayable light of pixels whose first four channels are red, green, blue and density.
    fn light<const CHANNELS: usize>(&self, pixels: &[[f32; CHANNELS]], width: usize) -> Vec<[f32; 3]> {
        match &self.look {
            None => exposed(pixels, width, |pixel| expose(pixel, self.tone)),
            Some(look) => exposed(pixels, width, |pixel| look.finished(expose(look.balanced(pixel), self.tone))),
        }
    }

    /// The mean square of the noise in displayable light.
    fn noise(&self, pixels: &[[f32; 8]], width: usize) -> f64 {
        match &self.look {
            None => noise(pixels, width, |pixel| expose(pixel, self.tone)),
            Some(look) => noise(pixels, width, |pixel| look.finished(expose(look.balanced(pixel), self.tone))),
        }
    }
}

/// What `expose` makes of each pixel.
fn exposed<const CHANNELS: usize>(
    pixels: &[[f32; CHANNELS]],
    width: usize,
    expose: impl Fn([f64; 4]) -> [f32; 3] + Sync,
) -> Vec<[f32; 3]> {
    let mut light = vec![[0.0; 3]; pixels.len()];
    light.par_chunks_mut(width).zip(pixels.par_chunks(width)).for_each(|(light, pixels)| {
        for (light, pixel) in light.iter_mut().zip(pixels) {
            *light = expose([0, 1, 2, 3].map(|channel| f64::from(pixel[channel])));
        }
    });
    light
}

/// The mean square of the noise in what `expose` makes of each pixel.
fn noise(pixels: &[[f32; 8]], width: usize, expose: impl Fn([f64; 4]) -> [f32; 3] + Sync) -> f64 {
    // Rows are added up in their order: the sum is the same for any number of threads.
    let rows = pixels.par_chunks(width).map(|pixels| {
        // With the noise and with its opposite: where light bends, both may be too dark.
        let square = |pixel: &[f32; 8]| {
            let [seen, more, less] = [0.0, 1.0, -1.0]
                .map(|part| expose([0, 1, 2, 3].map(|i| f64::from(pixel[i]) + part * f64::from(pixel[4 + i]))));
            let channel = |i: usize| f64::from(more[i] - seen[i]).powi(2) + f64::from(less[i] - seen[i]).powi(2);
            0.5 * (channel(0) + channel(1) + channel(2))
        };
        pixels.iter().map(square).sum::<f64>()
    });
    rows.collect::<Vec<f64>>().iter().sum::<f64>() / (3 * pixels.len()) as f64
}

/// Gamma, vibrancy, highlights and background of one pixel.
fn expose([red, green, blue, density]: [f64; 4], tone: &Tone) -> [f32; 3] {
    let power = 1.0 / tone.gamma;
    let alpha = if density > 0.0 { opacity(density, power, tone.gamma_threshold) } else { 0.0 };
    let vivid = if density > 0.0 { tone.vibrancy * WHITE * alpha / density } else { 0.0 };
    let covered = alpha.clamp(0.0, 1.0);
    let lit = highlights([red, green, blue], vivid, tone.highlight_power);
    std::array::from_fn(|i| {
        let plain = libm::pow([red, green, blue][i].max(0.0), power);
        let value = lit[i] + (1.0 - tone.vibrancy) * WHITE * plain + (1.0 - covered) * tone.background[i];
        // NaN, from an extreme gamma or brightness, is shown as black.
        if value > 0.0 { value.min(1.0) as f32 } else { 0.0 }
    })
}

/// Gamma with a straight beginning, so that single hits in the dark do not glare.
fn opacity(density: f64, power: f64, threshold: f64) -> f64 {
    let curve = libm::pow(density, power);
    if density >= threshold {
        return curve;
    }
    let part = density / threshold;
    (1.0 - part) * density * libm::pow(threshold, power) / threshold + part * curve
}

/// Scales a colour by `scale`; values above white are clamped, fading to white by `highlight_power`.
fn highlights(colour: [f64; 3], scale: f64, highlight_power: f64) -> [f64; 3] {
    let brightest = colour[0].max(colour[1]).max(colour[2]);
    if scale == 0.0 || brightest <= 0.0 {
        return [0.0; 3];
    }
    let held = 1.0 / brightest;
    if scale <= held {
        return colour.map(|channel| channel * scale);
    }
    if highlight_power >= 0.0 {
        let [hue, saturation, value] = to_hsv(colour.map(|channel| channel * held));
        return from_hsv([hue, saturation * libm::pow(held / scale, highlight_power), value]);
    }
    let clipped = (-highlight_power).min(1.0);
    colour.map(|channel| channel * ((1.0 - clipped) * held + clipped * scale))
}

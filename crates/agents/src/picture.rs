//! From a moment to a picture.
//!
//! Owns the order of the work, the threads, and what a frame takes, which is known before it is drawn. A sample is a look
//! at one stroke from one pixel. Never knows where anything is: `motion.rs` does.
//!
//! Start at [`Drawing`].

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::iter::{IndexedParallelIterator, ParallelIterator};
use rayon::slice::ParallelSliceMut;
use species::{Demand, Drawn, Image, Motion, RenderError, Settings, Threads, shutter};

use crate::bloom::Glow;
use crate::colour::{Screen, mixed};
use crate::error::AgentsError;
use crate::motion::{Body, Course, Scene};
use crate::raster::{Band, ROWS};
use crate::sprite::Sprites;

/// Moments in a frame, unless the settings say otherwise, and the most.
const MOMENTS: u32 = 4;
const MOST_MOMENTS: u32 = 64;
/// The most pixels along a side.
const LARGEST: u32 = 16_384;
/// Bytes of everything that is small: the jobs of threads, the lists of a scene.
const SMALL: u64 = 64 * 1024;

/// A course that is drawn.
pub(crate) struct Drawing<C>(pub(crate) C);

/// Moments in a frame. A sketch has one.
pub(crate) fn moments(settings: &Settings) -> u32 {
    if settings.spp == Some(1.0) { 1 } else { settings.temporal_samples.unwrap_or(MOMENTS).clamp(1, MOST_MOMENTS) }
}

impl<C: Course> Drawing<C> {
    /// What is seen at each moment of a frame.
    fn scenes(&self, frame: f64, settings: &Settings) -> impl Iterator<Item = Scene<'_>> {
        let (frame, moments) = (self.0.wrapped(frame), moments(settings));
        (0..moments).map(move |moment| self.0.scene(frame, shutter(moment, moments)))
    }

    /// The linear light of strokes, and the samples. Bands that come after a stop stay black.
    fn light(&self, frame: f64, settings: &Settings, threads: &Threads) -> (Vec<[f32; 3]>, u64) {
        let [width, height] = settings.size.map(|side| side as usize);
        let mut light = vec![[0.0; 3]; width * height];
        let (samples, share) = (AtomicU64::new(0), 1.0 / moments(settings) as f32);
        for scene in self.scenes(frame, settings) {
            let mut sprites = Sprites::room(&scene, settings.size);
            sprites.fill(&scene);
            let bands = light.par_chunks_mut(ROWS * width).enumerate();
            bands.for_each_init(
                || vec![0.0; ROWS * width],
                |cover, (number, light)| {
                    if !threads.are_stopped() {
                        let evaluations = Band { top: number * ROWS, width, light }.add(&sprites, share, cover);
                        samples.fetch_add(evaluations, Ordering::Relaxed);
                    }
                },
            );
        }
        (light, samples.into_inner())
    }
}

impl<C: Course> Motion for Drawing<C> {
    fn demand(&self, frame: f64, settings: &Settings) -> Result<Demand, RenderError> {
        check(settings)?;
        let [width, height] = settings.size.map(|side| side as usize);
        let (mut samples, mut most) = (0, 0);
        for scene in self.scenes(frame, settings) {
            let mut sprites = Sprites::room(&scene, settings.size);
            sprites.fill(&scene);
            samples += sprites.evaluations();
            let bodies = (scene.bodies.capacity() * size_of::<Body>()) as u64;
            most = most.max(bodies + Sprites::bytes(&scene));
        }
        let pixels = (width * height * size_of::<[f32; 3]>()) as u64;
        let glow = Glow::bytes([width, height]);
        let each = (ROWS * width * size_of::<f32>()) as u64 + Glow::bytes_of_row([width, height]);
        let bytes = pixels + most.max(glow) + each + Screen::BYTES + SMALL;
        Ok(Demand { samples, bytes, bytes_per_thread: each + SMALL })
    }

    fn frame(&self, frame: f64, settings: &Settings, threads: &Threads) -> Result<Drawn, RenderError> {
        check(settings)?;
        let [width, height] = settings.size.map(|side| side as usize);
        let (mut pixels, samples) = threads.run(|| self.light(frame, settings, threads));
        if threads.are_stopped() {
            return Err(RenderError::Stopped);
        }
        // The middle moment stands for what hardly changes.
        let (wrapped, screen) = (self.0.wrapped(frame), Screen::new());
        let scene = self.0.scene(wrapped, 0.0);
        threads.run(|| {
            let glow = Glow::of(&pixels, [width, height]);
            let rows = pixels.par_chunks_mut(width).enumerate();
            rows.for_each_init(Vec::new, |room, (row, pixels)| {
                if !threads.are_stopped() {
                    glow.add(pixels, row, scene.glow, room);
                    show(pixels, row, height, &scene.background, &screen);
                }
            });
        });
        if threads.are_stopped() {
            return Err(RenderError::Stopped);
        }
        Ok(Drawn { image: Image { width, height, pixels }, samples, psnr: None })
    }
}

/// Refuses sizes that are not possible.
fn check(settings: &Settings) -> Result<(), RenderError> {
    let [width, height] = settings.size;
    if settings.size.iter().any(|side| !(1..=LARGEST).contains(side)) {
        return Err(RenderError::Refused(Box::new(AgentsError::Size { width, height, most: LARGEST })));
    }
    Ok(())
}

/// Puts a row of light before the background, and makes it displayable.
fn show(pixels: &mut [[f32; 3]], row: usize, height: usize, [top, bottom]: &[[f32; 3]; 2], screen: &Screen) {
    let (width, down) = (pixels.len() as f32, (row as f32 + 0.5) / height as f32);
    let ground = mixed(*top, *bottom, down * down * (3.0 - 2.0 * down));
    let y = (down - 0.62) / 0.95;
    for (column, pixel) in pixels.iter_mut().enumerate() {
        let x = ((column as f32 + 0.5) / width - 0.5) / 0.8;
        // The globe is lit from within: lighter in the middle, and never black.
        let inner = (1.0 - x * x - y * y).max(0.0);
        let lit = 0.42 + 0.95 * inner * inner;
        for (light, ground) in pixel.iter_mut().zip(ground) {
            *light = screen.shown(*light + ground * lit);
        }
    }
}

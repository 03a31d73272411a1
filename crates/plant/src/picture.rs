//! From a view to a picture.
//!
//! Owns the order of the work, the threads, and what a picture takes, which is known before it is drawn. A picture is the
//! mean of the moments while the shutter is open, in light. Every band of rows is drawn for itself, so that pixels are the
//! same for any number of threads.
//!
//! Start at [`picture`].

use rayon::iter::{IndexedParallelIterator, ParallelIterator};
use rayon::slice::ParallelSliceMut;
use species::{Demand, Drawn, Image, RenderError, Settings, Threads, shutter};

use crate::colour::shown;
use crate::error::PlantError;
use crate::raster::Band;
use crate::skeleton::{Bone, Leaf, MOST_PARTS};
use crate::sky::Sky;
use crate::stand::Part;
use crate::view::{Shape, View};
use crate::wind::{Clock, Pose};

/// The most pixels along a side.
const LARGEST: u32 = 16_384;
/// Moments in a frame.
const MOMENTS: u32 = 4;
/// Rows of a band.
const ROWS: usize = 16;

/// Moments in a frame: one without motion blur.
pub(crate) fn moments(settings: &Settings) -> u32 {
    let is_sketch = settings.temporal_samples == Some(1) || settings.spp == Some(1.0);
    if is_sketch { 1 } else { MOMENTS }
}

/// What a picture takes: a sample is a pixel at a moment.
pub(crate) fn demand(settings: &Settings) -> Result<Demand, RenderError> {
    let [width, height] = settings.size;
    if settings.size.iter().any(|side| !(1..=LARGEST).contains(side)) {
        return Err(RenderError::Refused(Box::new(PlantError::Size { width, height, most: LARGEST })));
    }
    let pixels = u64::from(width) * u64::from(height);
    let moments = moments(settings);
    // A list that grows is twice as long as what is in it, and there is the old one while it is copied.
    let growing = 3 * (size_of::<Bone>() + size_of::<Leaf>()) as u64;
    let sorted = (2 * size_of::<(f64, Part)>() + size_of::<Pose>()) as u64;
    let shapes = u64::from(moments) * size_of::<Shape>() as u64;
    let light = size_of::<[f32; 3]>() as u64;
    Ok(Demand {
        samples: pixels * u64::from(moments),
        bytes: pixels * light + MOST_PARTS as u64 * (growing + sorted + shapes) + band_bytes(width) + (1 << 20),
        bytes_per_thread: band_bytes(width) + (64 << 10),
    })
}

/// Bytes of a band's sky and of its moment.
fn band_bytes(width: u32) -> u64 {
    2 * u64::from(width) * (ROWS * size_of::<[f32; 3]>()) as u64
}

/// The picture of a view, with a clock of the wind for each of its stands.
pub(crate) fn picture(
    view: &View,
    clocks: &[Clock],
    settings: &Settings,
    threads: &Threads,
) -> Result<Drawn, RenderError> {
    let samples = demand(settings)?.samples;
    let prepared = Prepared::of(view, clocks, settings.size, moments(settings));
    let [width, height] = settings.size.map(|side| side as usize);
    let mut pixels = vec![[0.0; 3]; width * height];
    threads.run(|| {
        pixels.par_chunks_mut(width * ROWS).enumerate().try_for_each(|(band, pixels)| {
            if threads.are_stopped() {
                return Err(RenderError::Stopped);
            }
            prepared.draw(band * ROWS, width, pixels);
            Ok(())
        })
    })?;
    Ok(Drawn { image: Image { width, height, pixels }, samples, psnr: None })
}

/// A small picture by the caller's own thread, at one moment.
pub(crate) fn sketch(view: &View, clocks: &[Clock], size: [u32; 2]) -> Image {
    let prepared = Prepared::of(view, clocks, size, 1);
    let [width, height] = size.map(|side| side as usize);
    let mut pixels = vec![[0.0; 3]; width * height];
    for (band, pixels) in pixels.chunks_mut(width * ROWS).enumerate() {
        prepared.draw(band * ROWS, width, pixels);
    }
    Image { width, height, pixels }
}

/// What all bands need.
struct Prepared {
    sky: Sky,
    /// The shapes of every moment.
    moments: Vec<Vec<Shape>>,
}

impl Prepared {
    fn of(view: &View, clocks: &[Clock], size: [u32; 2], moments: u32) -> Prepared {
        let moments = (0..moments).map(|moment| view.shapes(clocks, shutter(moment, moments), size)).collect();
        Prepared { sky: Sky::new(view.sky, size), moments }
    }

    /// Draws the rows from `top` on, each of `width` pixels.
    fn draw(&self, top: usize, width: usize, pixels: &mut [[f32; 3]]) {
        let place = |number: usize| (number % width, top + number / width);
        let sky: Vec<[f32; 3]> =
            (0..pixels.len()).map(|number| self.sky.at(place(number).0, place(number).1)).collect();
        let mut moment = sky.clone();
        let share = 1.0 / self.moments.len() as f32;
        for shapes in &self.moments {
            moment.copy_from_slice(&sky);
            let mut band = Band { top, width, pixels: &mut moment };
            for shape in shapes {
                band.draw(shape);
            }
            for (sum, light) in pixels.as_flattened_mut().iter_mut().zip(moment.as_flattened()) {
                *sum += light * share;
            }
        }
        for (number, pixel) in pixels.iter_mut().enumerate() {
            let (column, row) = place(number);
            *pixel = self.sky.through(*pixel, column, row).map(shown);
        }
    }
}

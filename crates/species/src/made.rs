//! Motions that are made up, for tests.
//!
//! Owns one whose pictures are a function of place and frame. Never draws a species.
//!
//! Start at [`Made`].

use crate::contract::{Demand, Drawn, Motion, RenderError, Settings};
use crate::image::Image;
use crate::threads::Threads;

/// A picture that is made up: red, green and blue at a place, `-1.0..=1.0` from left to right and from the top down, and
/// at a frame.
pub(crate) struct Made(pub(crate) fn(f32, f32, f64) -> [f32; 3]);

impl Motion for Made {
    fn demand(&self, _frame: f64, settings: &Settings) -> Result<Demand, RenderError> {
        let pixels: u64 = settings.size.map(u64::from).iter().product();
        Ok(Demand { samples: pixels, bytes: pixels * 12, bytes_per_thread: 0 })
    }

    fn frame(&self, frame: f64, settings: &Settings, _threads: &Threads) -> Result<Drawn, RenderError> {
        let [width, height] = settings.size.map(|side| side as usize);
        let place = |at: usize, side: usize| (2.0 * at as f32 + 1.0) / side as f32 - 1.0;
        let pixel = |at: usize| (self.0)(place(at % width, width), place(at / width, height), frame);
        let image = Image { width, height, pixels: (0..width * height).map(pixel).collect() };
        Ok(Drawn { image, samples: settings.size.map(u64::from).iter().product(), psnr: settings.psnr })
    }
}

//! A square of pixels.
//!
//! Owns which samples are drawn: some of every pixel, and more where those differ. A tile depends on nothing beside it, so
//! that pixels are the same for any number of threads.
//!
//! Start at [`Tile::draw`].

use crate::genome::View;
use crate::kernels::BATCH;
use crate::sampling::{ALL, FIRST, MIDDLE, Sample, samples};
use crate::tape::{Registers, Tape};

/// Pixels along a side.
pub(crate) const SIDE: usize = 32;
const PIXELS: usize = SIDE * SIDE;
/// Samples that differ by more, in any channel, are too few.
const ROUGH: f32 = 0.06;
/// Light goes over to black and to white this far from both.
const KNEE: f32 = 0.05;

/// How many samples a pixel has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Samples {
    /// One, in its middle, without motion blur: a sketch.
    One,
    /// 16, at four moments.
    Sixteen,
    /// 16, and 48 more where those differ.
    #[default]
    Adaptive,
}

/// The picture that tiles are part of.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) samples: Samples,
}

/// What is done at a moment of the shutter, and where.
#[derive(Clone, Debug)]
pub(crate) struct Moment {
    pub(crate) tape: Tape,
    pub(crate) view: View,
}

/// A part of the picture, by its left upper pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tile {
    pub(crate) left: usize,
    pub(crate) top: usize,
    pub(crate) width: usize,
    pub(crate) height: usize,
}

/// What a pixel's samples are so far.
#[derive(Clone, Copy)]
struct Seen {
    sum: [f32; 3],
    low: [f32; 3],
    high: [f32; 3],
}

impl Samples {
    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Samples::One => "one",
            Samples::Sixteen => "sixteen",
            Samples::Adaptive => "adaptive",
        }
    }

    /// The least and the most samples of a pixel.
    pub fn range(self) -> [u64; 2] {
        match self {
            Samples::One => [1; 2],
            Samples::Sixteen => [FIRST as u64; 2],
            Samples::Adaptive => [FIRST as u64, ALL as u64],
        }
    }
}

impl Frame {
    /// All tiles, row by row.
    pub(crate) fn tiles(&self) -> Vec<Tile> {
        let (width, height) = (self.width, self.height);
        let lefts = move |top: usize| (0..width).step_by(SIDE).map(move |left| (left, top));
        let tiles = (0..height).step_by(SIDE).flat_map(lefts);
        let tile = |(left, top)| Tile { left, top, width: SIDE.min(width - left), height: SIDE.min(height - top) };
        tiles.map(tile).collect()
    }

    /// The position of a place in the picture, in pixels from its left upper corner, in a view.
    fn position(&self, view: View, right: f32, down: f32) -> [f32; 2] {
        let View { scale, center: [x, y] } = view;
        let pixel = 2.0 * scale / self.height as f32;
        // No zero is negative.
        [x + (right - self.width as f32 / 2.0) * pixel + 0.0, y + (self.height as f32 / 2.0 - down) * pixel + 0.0]
    }
}

impl Tile {
    /// Pixels along a side.
    pub(crate) const SIDE: u64 = SIDE as u64;

    /// Bytes that are in use while one is drawn, beside registers.
    pub(crate) const BYTES: u64 =
        (PIXELS * (size_of::<Seen>() + 4 * size_of::<usize>() + size_of::<[f32; 3]>())) as u64;

    /// Bytes that are kept of one until the picture is put together, beside pixels: itself, and its place in lists.
    pub(crate) const KEPT: u64 = 6 * size_of::<Tile>() as u64;

    /// Its pixels, row by row; there is a set of registers for each moment: four, or one.
    pub(crate) fn draw(&self, frame: &Frame, moments: &[Moment], registers: &mut [Registers]) -> (Vec<[f32; 3]>, u64) {
        let nothing = Seen { sum: [0.0; 3], low: [f32::MAX; 3], high: [f32::MIN; 3] };
        let mut seen = vec![nothing; self.width * self.height];
        let all: Vec<usize> = (0..self.width * self.height).collect();
        let mut draw = |pixels: &[usize], sample: Sample, seen: &mut [Seen]| {
            // Without motion blur there is one moment.
            let moment = sample.moment % moments.len();
            let (moment, registers) = (&moments[moment], &mut registers[moment]);
            for batch in pixels.chunks(BATCH) {
                self.batch(frame, (moment, registers), batch, sample, seen);
            }
        };
        if frame.samples == Samples::One {
            draw(&all, MIDDLE, &mut seen);
            return (all.iter().map(|pixel| seen[*pixel].sum).collect(), all.len() as u64);
        }
        let samples = samples();
        for sample in &samples[..FIRST] {
            draw(&all, *sample, &mut seen);
        }
        let mut count = vec![FIRST; all.len()];
        if frame.samples == Samples::Adaptive {
            let rough: Vec<usize> = all.iter().copied().filter(|pixel| seen[*pixel].is_rough()).collect();
            for sample in &samples[FIRST..] {
                draw(&rough, *sample, &mut seen);
            }
            for pixel in rough {
                count[pixel] = ALL;
            }
        }
        let pixels = all.iter().map(|pixel| seen[*pixel].sum.map(|sum| sum / count[*pixel] as f32)).collect();
        (pixels, count.iter().sum::<usize>() as u64)
    }

    fn batch(
        &self,
        frame: &Frame,
        (Moment { tape, view }, registers): (&Moment, &mut Registers),
        pixels: &[usize],
        sample: Sample,
        seen: &mut [Seen],
    ) {
        let [x, y] = registers.positions();
        for ((x, y), pixel) in x.iter_mut().zip(y).zip(pixels) {
            let right = (self.left + pixel % self.width) as f32 + 0.5 + sample.offset[0];
            let down = (self.top + pixel / self.width) as f32 + 0.5 + sample.offset[1];
            [*x, *y] = frame.position(*view, right, down);
        }
        let colours = tape.run(registers, pixels.len());
        for (at, pixel) in pixels.iter().enumerate() {
            seen[*pixel].add(colours.map(|colour| light(colour[at])));
        }
    }
}

impl Seen {
    fn add(&mut self, light: [f32; 3]) {
        for (channel, light) in light.into_iter().enumerate() {
            self.sum[channel] += light;
            self.low[channel] = self.low[channel].min(light);
            self.high[channel] = self.high[channel].max(light);
        }
    }

    fn is_rough(&self) -> bool {
        self.low.iter().zip(self.high).any(|(low, high)| high - low > ROUGH)
    }
}

/// Displayable light of a result: black below 0, white above 1, with a parabola across both.
fn light(value: f32) -> f32 {
    let dark = (value + KNEE).clamp(0.0, 2.0 * KNEE);
    let bright = (1.0 + KNEE - value).clamp(0.0, 2.0 * KNEE);
    let middle = value.clamp(KNEE, 1.0 - KNEE);
    let knee = |within: f32| within * within / (4.0 * KNEE) - KNEE;
    (middle + knee(dark) - knee(bright)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_has_a_soft_knee_at_both_ends_and_is_the_value_between() {
        let near = |value: f32, wants: f32| assert!((light(value) - wants).abs() < 1e-6, "{value}: {}", light(value));
        for (value, wants) in [(-1e6, 0.0), (-0.05, 0.0), (0.0, 0.0125), (0.05, 0.05), (0.5, 0.5), (0.95, 0.95)] {
            near(value, wants);
            near(1.0 - value, 1.0 - wants);
        }
        let slopes =
            (-200..1200).map(|step| (light((step + 1) as f32 / 1000.0) - light(step as f32 / 1000.0)) * 1000.0);
        let slopes: Vec<f32> = slopes.collect();
        assert!(slopes.windows(2).all(|pair| (pair[1] - pair[0]).abs() < 0.02), "the knee has a kink");
    }
}

//! A square of pixels.
//!
//! Owns which samples are drawn: some of every pixel, and more where those differ. A tile depends on nothing beside it, so
//! that pixels are the same for any number of threads.
//!
//! Start at [`Tile::draw`].

use std::ops::Range;

use crate::genome::View;
use crate::kernels::{BATCH, vectorized};
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

/// Pixels of a tile, and what their samples are so far: an array for each number, so that loops become vector instructions.
struct Pixels {
    /// Their middles, in pixels from the left upper corner of the picture.
    right: Vec<f32>,
    down: Vec<f32>,
    channels: [Channel; 3],
}

/// The samples of one channel.
struct Channel {
    sum: Vec<f32>,
    low: Vec<f32>,
    high: Vec<f32>,
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
}

impl Tile {
    /// Pixels along a side.
    pub(crate) const SIDE: u64 = SIDE as u64;

    /// Bytes that are in use while one is drawn, beside registers: its pixels twice, which of them are rough, how many samples
    /// each has, and the colours that come out.
    pub(crate) const BYTES: u64 =
        (PIXELS * (2 * Pixels::NUMBERS * size_of::<f32>() + 4 * size_of::<usize>() + size_of::<[f32; 3]>())) as u64;

    /// Bytes that are kept of one until the picture is put together, beside pixels: itself, and its place in lists.
    pub(crate) const KEPT: u64 = 6 * size_of::<Tile>() as u64;

    /// Its pixels, row by row; there is a set of registers for each moment: four, or one.
    pub(crate) fn draw(&self, frame: &Frame, moments: &[Moment], registers: &mut [Registers]) -> (Vec<[f32; 3]>, u64) {
        let mut draw = |pixels: &mut Pixels, sample: &Sample| {
            // Without motion blur there is one moment.
            let moment = sample.moment % moments.len();
            let (moment, registers) = (&moments[moment], &mut registers[moment]);
            vectorized(
                #[inline(always)]
                || pixels.add(frame, moment, registers, sample),
            );
        };
        let mut all = self.pixels(0..self.width * self.height);
        let mut count = vec![1; all.right.len()];
        if frame.samples == Samples::One {
            draw(&mut all, &MIDDLE);
        } else {
            let samples = samples();
            samples[..FIRST].iter().for_each(|sample| draw(&mut all, sample));
            count.fill(FIRST);
            if frame.samples == Samples::Adaptive {
                let rough: Vec<usize> = (0..count.len()).filter(|pixel| all.is_rough(*pixel)).collect();
                let mut more = self.pixels(rough.iter().copied());
                for (more, all) in more.channels.iter_mut().zip(&all.channels) {
                    more.sum.iter_mut().zip(&rough).for_each(|(sum, pixel)| *sum = all.sum[*pixel]);
                }
                samples[FIRST..].iter().for_each(|sample| draw(&mut more, sample));
                for (more, all) in more.channels.iter().zip(&mut all.channels) {
                    more.sum.iter().zip(&rough).for_each(|(sum, pixel)| all.sum[*pixel] = *sum);
                }
                for pixel in rough {
                    count[pixel] = ALL;
                }
            }
        }
        let colour = |(pixel, count): (usize, &usize)| all.channels.each_ref().map(|it| it.sum[pixel] / *count as f32);
        (count.iter().enumerate().map(colour).collect(), count.iter().sum::<usize>() as u64)
    }

    /// Those of its pixels, without samples.
    fn pixels(&self, numbers: impl Iterator<Item = usize> + Clone) -> Pixels {
        let right: Vec<f32> = numbers.clone().map(|pixel| (self.left + pixel % self.width) as f32 + 0.5).collect();
        let down = numbers.map(|pixel| (self.top + pixel / self.width) as f32 + 0.5).collect();
        let of = |value: f32| vec![value; right.len()];
        let channels = [(); 3].map(|()| Channel { sum: of(0.0), low: of(f32::MAX), high: of(f32::MIN) });
        Pixels { right, down, channels }
    }
}

impl Pixels {
    /// Numbers of a pixel.
    const NUMBERS: usize = 2 + 3 * 3;

    /// Adds a sample of each.
    #[inline(always)]
    fn add(&mut self, frame: &Frame, Moment { tape, view }: &Moment, registers: &mut Registers, sample: &Sample) {
        let View { scale, center } = *view;
        let pixel = 2.0 * scale / frame.height as f32;
        let middle = [frame.width, frame.height].map(|side| side as f32 / 2.0);
        for from in (0..self.right.len()).step_by(BATCH) {
            let batch = from..self.right.len().min(from + BATCH);
            let [x, y] = registers.positions();
            // No zero is negative.
            for (x, right) in x.iter_mut().zip(&self.right[batch.clone()]) {
                *x = center[0] + (right + sample.offset[0] - middle[0]) * pixel + 0.0;
            }
            for (y, down) in y.iter_mut().zip(&self.down[batch.clone()]) {
                *y = center[1] + (middle[1] - (down + sample.offset[1])) * pixel + 0.0;
            }
            let colours = tape.run(registers, batch.len());
            for (channel, colours) in self.channels.iter_mut().zip(colours) {
                channel.add(batch.clone(), colours);
            }
        }
    }

    fn is_rough(&self, pixel: usize) -> bool {
        self.channels.iter().any(|Channel { low, high, .. }| high[pixel] - low[pixel] > ROUGH)
    }
}

impl Channel {
    /// Adds results of one sample of a range of pixels.
    #[inline(always)]
    fn add(&mut self, pixels: Range<usize>, results: &[f32]) {
        let Channel { sum, low, high } = self;
        let seen = sum[pixels.clone()].iter_mut().zip(&mut low[pixels.clone()]).zip(&mut high[pixels]);
        for (((sum, low), high), result) in seen.zip(results) {
            let light = light(*result);
            *sum += light;
            *low = if light < *low { light } else { *low };
            *high = if light > *high { light } else { *high };
        }
    }
}

/// Displayable light of a result: black below 0, white above 1, with a parabola across both.
#[inline(always)]
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

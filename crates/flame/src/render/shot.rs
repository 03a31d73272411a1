//! A frame before its first sample is drawn, as plain data.
//!
//! Owns what a renderer needs to know of a frame: a compiled genome for each moment of the exposure, the palette, how
//! many samples there are and how they are shared out. A back-end turns a shot into a histogram of whole numbers, and
//! needs nothing else.
//!
//! Start at [`Shot::new`].

use std::ops::Range;
use std::sync::Arc;

use super::RenderError;
use super::filter::Moment;
use super::histogram::{Record, UNIT};
use super::plan::Plan;
use super::pool::ORBITS;
use super::view::{View, in_range};
use crate::genome::{Finish, Genome, Palette, PaletteMode};

/// Entries of the palette over the colour coordinate: four for each colour of a genome.
const ENTRIES: usize = 4 * Palette::LEN;

/// The same where colours that follow each other differ widely: a colour that does not move would be seen as one beside it.
const FINE_ENTRIES: usize = 4 * ENTRIES;

/// Least steps before an orbit is on the attractor; they are not seen.
pub(crate) const FUSE: u64 = 20;

/// The same where samples of orbits that escape are lost. Measured on JWildfire's pictures: where a transform that leads to
/// infinity is chosen once in 26 or in 51 steps, the light is that of orbits that are seen from about this step on.
pub(crate) const LOST_FUSE: u64 = 45;

/// Least steps of an orbit there: JWildfire's go on through the whole picture, and where transforms are chosen rarely, or
/// lead far away, those of a few hundred steps have not been everywhere.
const LOST_STEPS: u64 = 8192;

/// An orbit has so many times the steps of its fuse, at least: in fewer, it would count.
const LEAST_FUSES: u64 = 12;

/// Most parts of a frame: each begins new orbits, so that all parts of a flame with several attractors are drawn, and
/// as many threads may have one each.
const MOST_PARTS: u64 = 512;

/// Most bytes of the compiled genomes of a frame's moments.
const MAX_PLANS: u64 = 2_000_000_000;

/// Most palettes of a frame whose colours change while the shutter is open.
const MOST_PALETTES: usize = 32;

/// All that is needed to draw a frame's samples.
#[derive(Clone, Debug)]
pub(crate) struct Shot {
    /// The genome at each moment of the exposure.
    pub(crate) plans: Arc<[Plan]>,
    /// Which part of the exposure is over when each moment begins.
    over: Arc<[f64]>,
    /// The step at which each moment begins.
    pub(crate) begins: Vec<u64>,
    /// Colours in histogram units: `entries` for each of several palettes.
    pub(crate) palette: Arc<[[u32; 4]]>,
    /// Steps of all parts; in each, as many samples are drawn as a pool has orbits.
    pub(crate) all_steps: u64,
    /// What all random numbers come from.
    pub(crate) seed: u64,
    /// Whether points have a z, at any moment.
    pub(crate) has_z: bool,
    /// Steps of an orbit that are not seen.
    pub(crate) fuse: u64,
}

impl Shot {
    /// The frame of at least `samples` samples that shows each of `genomes`, with a view of the same cells, at its
    /// moment. A moment gets samples as the shutter is open.
    /// Errors: [`RenderError`] names what a genome lacks or what is unknown.
    pub(crate) fn new(
        genomes: &[(Genome, View)],
        moments: &[Moment],
        samples: u64,
        seed: u64,
    ) -> Result<Shot, RenderError> {
        let count = genomes.len();
        let mut plans = Vec::with_capacity(count);
        for (genome, view) in genomes {
            let plan = Plan::new(genome, view)?;
            let fits = plan.bytes() * count as u64 <= MAX_PLANS;
            in_range("temporal_samples", count as f64, fits, "moments of at most 2e9 bytes together")?;
            plans.push(plan);
        }
        let entries = entries(genomes);
        let palette = palette(genomes, &mut plans, entries).into();
        let light: f64 = moments.iter().map(|moment| moment.light).sum();
        let mut before = 0.0;
        let mut over = |moment: &Moment| {
            let over = before / light;
            before += moment.light;
            over
        };
        let over = moments.iter().map(&mut over).collect();
        let has_z = plans.iter().any(|plan| plan.has_z);
        for plan in &mut plans {
            plan.has_z = has_z;
        }
        let fuse = plans.iter().map(|plan| plan.fuse).max().unwrap_or(FUSE);
        let plans = plans.into();
        Ok(Shot { plans, over, begins: Vec::new(), palette, all_steps: 0, seed, has_z, fuse }.again(samples, seed))
    }

    /// The same frame with at least `samples` other samples: those of `seed`.
    pub(crate) fn again(&self, samples: u64, seed: u64) -> Shot {
        let all_steps = samples.div_ceil(ORBITS as u64);
        let begins = self.over.iter().map(|over| (over * all_steps as f64).round() as u64).collect();
        Shot { begins, all_steps, seed, ..self.clone() }
    }

    /// How many samples are drawn, but for those of orbits that escape.
    pub(crate) fn samples(&self) -> u64 {
        self.all_steps * ORBITS as u64
    }

    /// How many parts the frame has; they may be drawn in any order.
    pub(crate) fn parts(&self) -> u64 {
        (self.all_steps / self.least_steps()).clamp(1, MOST_PARTS)
    }

    /// Least steps of an orbit, where there are as many.
    pub(crate) fn least_steps(&self) -> u64 {
        let loses = self.plans.iter().any(|plan| plan.begins_again < 1.0);
        let least = if loses { LOST_STEPS } else { 0 };
        (LEAST_FUSES * self.fuse).next_power_of_two().max(least)
    }

    /// The steps of part `number`.
    pub(crate) fn steps(&self, number: u64) -> Range<u64> {
        let at = |number: u64| (u128::from(self.all_steps) * u128::from(number) / u128::from(self.parts())) as u64;
        at(number)..at(number + 1)
    }

    /// The genome at a step.
    #[inline]
    pub(crate) fn plan(&self, step: u64) -> &Plan {
        &self.plans[self.begins.partition_point(|begins| *begins <= step) - 1]
    }

    /// Its size in memory.
    pub(crate) fn bytes(&self) -> u64 {
        self.plans.iter().map(Plan::bytes).sum::<u64>() + size_of_val(&self.palette[..]) as u64
    }
}

/// How many entries the palettes have over the colour coordinate. flam3's keep their number, so that pictures stay.
fn entries(genomes: &[(Genome, View)]) -> usize {
    let is_uneven = |genome: &Genome| genome.palette.as_ref().is_some_and(Palette::is_uneven);
    let needs_more = |(genome, _): &(Genome, View)| !genome.finish.has_flam3s_colours() && is_uneven(genome);
    if genomes.iter().any(needs_more) { FINE_ENTRIES } else { ENTRIES }
}

/// The colours of all genomes in histogram units. Tells each plan which of them are its own.
///
/// Where colours or the brightness of transforms change while the shutter is open, moments that follow each other share
/// the mean of theirs. Where some transforms are darker, each has entries of its own.
fn palette(genomes: &[(Genome, View)], plans: &mut [Plan], entries: usize) -> Vec<[u32; 4]> {
    let brightness = |plan: &Plan| -> Vec<f64> { plan.moves.iter().map(|chosen| chosen.brightness).collect() };
    let is_dark = plans.iter().flat_map(brightness).any(|brightness| brightness != 1.0);
    let rows = if is_dark { plans.iter().map(|plan| plan.moves.len()).max().unwrap_or(1) } else { 1 };
    let same = |i: usize| {
        let [(first, _), (other, _)] = [&genomes[0], &genomes[i]];
        let modes = |genome: &Genome| (genome.palette_mode, genome.finish.palette_span, genome.finish.palette_start);
        let same_colours = modes(first) == modes(other) && first.palette == other.palette;
        same_colours && brightness(&plans[0]) == brightness(&plans[i])
    };
    let count = plans.len();
    let palettes =
        if (1..count).all(same) { 1 } else { count.min(MOST_PALETTES).min(Record::ENTRIES / entries / rows) };
    let mut palette = Vec::with_capacity(palettes * rows * entries);
    for number in 0..palettes {
        let moments = count * number / palettes..count * (number + 1) / palettes;
        // Where nothing changes one moment is as good as all.
        let shown = if palettes == 1 { 0..1 } else { moments.clone() };
        let mut sums = vec![[0.0_f64; 4]; rows * entries];
        for i in shown.clone() {
            let colours = colours(&genomes[i].0, entries);
            for (row, sums) in sums.chunks_mut(entries).enumerate() {
                let brightness =
                    if is_dark { plans[i].moves.get(row).map_or(1.0, |chosen| chosen.brightness) } else { 1.0 };
                for (sum, colour) in sums.as_flattened_mut().iter_mut().zip(colours.as_flattened()) {
                    *sum += brightness * colour / shown.len() as f64;
                }
            }
        }
        palette.extend(sums.iter().map(|sum| sum.map(|channel| channel.round() as u32)));
        for plan in &mut plans[moments] {
            plan.entries = entries as u32;
            plan.first_entry = (number * rows * entries) as u32;
            plan.entries_on = if is_dark { entries as u32 } else { 0 };
        }
    }
    palette
}

/// A genome's palette over the colour coordinate, in histogram units.
fn colours(genome: &Genome, entries: usize) -> Vec<[f64; 4]> {
    let Some(palette) = &genome.palette else { return vec![[0.0; 4]; entries] };
    let entry = |i: usize| {
        let Finish { palette_span, palette_start, .. } = genome.finish;
        let coordinate = ((i as f64 + 0.5) / entries as f64 * palette_span + palette_start).min(1.0);
        let colour = match genome.palette_mode {
            PaletteMode::Step => palette.step(coordinate),
            PaletteMode::Linear => palette.linear(coordinate),
        };
        colour.map(|channel| channel.clamp(0.0, 255.0) / 255.0 * f64::from(UNIT))
    };
    (0..entries).map(entry).collect()
}

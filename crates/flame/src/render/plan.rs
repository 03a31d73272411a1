//! A genome compiled for iteration.
//!
//! Owns what the inner loop reads: transforms without their zero parts, tables to choose the next one, a palette in
//! histogram units. Unsupported genomes are refused here. `chaos.rs` iterates.
//!
//! Start at [`Plan::new`].

use super::RenderError;
use super::projection::Projection;
use super::shot::{FUSE, LOST_FUSE};
use super::view::{View, in_range};
use crate::genome::{Affine, Genome, Tilt, Xform};
use variations::{Compiled, Depth, Kind, Stage, Variation};

/// The darkest samples, as a part of full brightness: a histogram in whole numbers rounds darker ones too much.
const DARKEST: f64 = 1.0 / 16.0;

/// A colour that is pulled at least so far at each step, in the mean, is there early in an orbit.
const SLOW_COLOUR: f64 = 0.125;
/// The same in genomes whose pictures stay as they were: up to 7 % of a colour may be that of the beginning.
const SLOW_FLAM3_COLOUR: f64 = 0.03;
/// A colour that is pulled less than so far stays for the longest orbit: none is waited for.
const STILL_COLOUR: f64 = 5e-4;

/// Colours of formulas are nearer to 0 than this.
pub(crate) const MOST_COLOUR: f64 = 2.0;

/// A genome ready to be iterated.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    /// The transforms; symmetries are some of them.
    pub(crate) moves: Vec<CompiledXform>,
    /// The final transforms.
    pub(crate) lenses: Vec<CompiledXform>,
    /// Whether points have a z: x and y come to depend on it, or the camera does.
    pub(crate) has_z: bool,
    /// How points in space are seen.
    pub(crate) projection: Option<Projection>,
    /// From which random number on, of 2^32, each transform but the first is chosen: for each last transform where
    /// there is xaos, else once.
    pub(crate) choices: Vec<Vec<u32>>,
    /// The part of orbits that begin again where they escape: 1 in flam3, 0 in JWildfire.
    pub(crate) begins_again: f64,
    /// How many steps an orbit takes until its place and its colour are the flame's.
    pub(crate) fuse: u64,
    /// From a point to its place in cells.
    pub(crate) to_cells: Affine,
    /// Cells of the histogram, in a row and in a column.
    pub(crate) cells: [usize; 2],
    /// Entries of the palette over the colour coordinate.
    pub(crate) entries: u32,
    /// The palette's entries for the first transform.
    pub(crate) first_entry: u32,
    /// How many entries on are those for the next one.
    pub(crate) entries_on: u32,
}

/// A transform ready to be applied.
#[derive(Clone, Debug)]
pub(crate) struct CompiledXform {
    pub(crate) affine: Affine,
    pub(crate) post: Option<Affine>,
    /// What follows them in space, in rows: of a flame with depth only.
    pub(crate) tilt: Option<[[f64; 4]; 3]>,
    pub(crate) post_tilt: Option<[[f64; 4]; 3]>,
    /// What moves the point before the sum, one by one.
    pub(crate) before: Vec<Passed>,
    /// The sum.
    pub(crate) variations: Vec<Summand>,
    /// What moves the sum, one by one.
    pub(crate) after: Vec<Passed>,
    /// `c' = keep * c + pull`.
    pub(crate) keep: f64,
    pub(crate) pull: f64,
    /// Whether a variation changes the colour after that.
    pub(crate) is_in_colour: bool,
    /// How bright its samples are, `0.0..=1.0`.
    pub(crate) brightness: f64,
    /// The part of its samples that are drawn: very dark ones are rarer instead.
    pub(crate) part: f64,
    /// The part of points that a final transform takes.
    pub(crate) opacity: f64,
}

/// A variation that is applied to what has come of the point so far.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Passed {
    pub(crate) variation: Compiled,
    /// How far its result replaces what it is applied to; none where it is added.
    pub(crate) presence: Option<f64>,
    /// What z is multiplied with where its formula has none.
    pub(crate) depth_factor: Option<f64>,
}

/// A variation of a sum.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Summand {
    /// Of the point.
    Plain(Compiled),
    /// A part of one of the point.
    Part { variation: Compiled, presence: f64 },
    /// Of the sum so far, which it replaces.
    Running(Passed),
    /// So much of the point's z, of all formulas of the plane.
    Carried(f64),
}

impl Plan {
    /// Compiles `genome`, seen through `view`.
    /// Errors: [`RenderError`] names what the genome lacks or what is unknown.
    pub(crate) fn new(genome: &Genome, view: &View) -> Result<Plan, RenderError> {
        check(genome)?;
        let genome = genome.with_symmetry();
        let count = genome.xforms.len();
        in_range("xform", count as f64, count <= Genome::MAX_XFORMS, "at most 256 transforms, symmetries included")?;
        if genome.palette.is_none() {
            return Err(RenderError::NoPalette);
        }
        if genome.xforms.iter().all(|xform| xform.weight <= 0.0 || xform.weight.is_nan()) {
            return Err(RenderError::NothingToChoose { xforms: count });
        }
        let xaos = genome.xforms.iter().any(|xform| xform.chaos.iter().any(|weight| *weight != 1.0));
        let choices = if xaos {
            genome.xforms.iter().map(|from| thresholds(&weights(&genome, &from.chaos))).collect()
        } else {
            vec![thresholds(&weights(&genome, &[]))]
        };
        let has_z = needs_z(&genome);
        let floor = floor(genome.finish.lost_samples);
        let compiled = |xforms: &[Xform]| xforms.iter().map(|xform| CompiledXform::new(xform, has_z, floor)).collect();
        Ok(Plan {
            moves: compiled(&genome.xforms),
            lenses: compiled(&genome.finals),
            has_z,
            projection: Projection::new(&genome.camera.pose),
            choices,
            begins_again: begins_again(genome.finish.lost_samples),
            fuse: fuse(&genome),
            to_cells: view.to_cells,
            cells: view.cells,
            entries: 0,
            first_entry: 0,
            entries_on: 0,
        })
    }

    /// Its size in memory.
    pub(crate) fn bytes(&self) -> u64 {
        let xform = |xform: &CompiledXform| {
            let passed = size_of_val(&xform.before[..]) + size_of_val(&xform.after[..]);
            size_of::<CompiledXform>() + passed + size_of_val(&xform.variations[..])
        };
        let choices = self.choices.iter().map(|choice| size_of_val(&choice[..])).sum::<usize>();
        (size_of::<Plan>() + choices + self.moves.iter().chain(&self.lenses).map(xform).sum::<usize>()) as u64
    }

    /// From which random number on, of 2^32, each transform but the first is chosen after number `last`.
    #[inline]
    pub(crate) fn thresholds(&self, last: usize) -> &[u32] {
        if self.choices.len() == 1 { &self.choices[0] } else { &self.choices[last] }
    }

    /// The first of the palette's entries for transform `number`.
    #[inline]
    pub(crate) fn first_entry(&self, number: usize) -> u32 {
        self.first_entry + self.entries_on * number as u32
    }
}

impl CompiledXform {
    fn new(xform: &Xform, has_z: bool, floor: f64) -> CompiledXform {
        let (mut before, mut variations, mut after) = (Vec::new(), Vec::new(), Vec::new());
        let mut carried = 0.0;
        for variation in used(xform) {
            let presence = variation.stage.replaces().then_some(variation.presence);
            let compiled = Compiled { floor, ..Compiled::new(variation, &xform.affine) };
            let passed = Passed { variation: compiled, presence, depth_factor: variation.depth_factor() };
            match variation.stage {
                Stage::Before | Stage::AddedBefore => before.push(passed),
                // flam3's own.
                Stage::Sum if variation.kind == Kind::PreBlur => before.push(passed),
                Stage::Running => {
                    variations.extend(carries(&mut carried, has_z));
                    variations.push(Summand::Running(passed));
                }
                Stage::Sum => {
                    carried += variation.carried();
                    variations.push(match variation.presence {
                        1.0 => Summand::Plain(compiled),
                        presence => Summand::Part { variation: compiled, presence },
                    });
                }
                Stage::After | Stage::AddedAfter => after.push(passed),
                Stage::Never => {}
            }
        }
        variations.extend(carries(&mut carried, has_z));
        let opacity = xform.opacity.clamp(0.0, 1.0);
        let visibility = if opacity == 0.0 { 0.0 } else { libm::pow(10.0, libm::log2(opacity)) };
        let brightness = if visibility == 0.0 { 0.0 } else { visibility.max(DARKEST) };
        CompiledXform {
            affine: xform.affine,
            post: (xform.post != Affine::IDENTITY).then_some(xform.post),
            tilt: xform.tilt.rows(&xform.affine),
            post_tilt: xform.post_tilt.rows(&xform.post),
            before,
            variations,
            after,
            keep: 1.0 - xform.color_speed,
            pull: xform.color_speed * xform.color,
            is_in_colour: used(xform).any(Variation::changes_colour),
            brightness,
            part: if brightness == 0.0 { 0.0 } else { visibility / brightness },
            opacity,
        }
    }
}

/// What adds so much of z, once; nothing in a flame without z.
fn carries(carried: &mut f64, has_z: bool) -> Option<Summand> {
    let carried = std::mem::take(carried);
    (has_z && carried != 0.0).then_some(Summand::Carried(carried))
}

/// The variations of `xform` that change something.
fn used(xform: &Xform) -> impl Iterator<Item = &Variation> {
    xform.variations.iter().filter(|variation| !variation.is_absent() && variation.stage != Stage::Never)
}

/// Whether a picture of `genome` depends on z: the camera does, or x and y come to depend on a z that is made.
fn needs_z(genome: &Genome) -> bool {
    let xforms = || genome.xforms.iter().chain(&genome.finals);
    let has = |depth: Depth| xforms().flat_map(used).any(|variation| variation.kind.depth() == depth);
    let is_tilted = |xform: &Xform| [xform.tilt, xform.post_tilt] != [Tilt::NONE; 2];
    !genome.camera.pose.is_straight() || has(Depth::Reads) || xforms().any(is_tilted)
}

/// How likely each transform follows one with this chaos: a multiple of it.
fn weights(genome: &Genome, chaos: &[f64]) -> Vec<f64> {
    let after = |(i, xform): (usize, &Xform)| xform.weight.max(0.0) * chaos.get(i).map_or(1.0, |c| c.max(0.0));
    genome.xforms.iter().enumerate().map(after).collect()
}

/// The part of orbits that begin again where they escape. Between 0 and 1, the time for which an orbit is lost grows by the
/// same factor with each step towards JWildfire, so that a transition gets darker evenly.
fn begins_again(lost_samples: f64) -> f64 {
    if lost_samples < 1.0 { libm::exp2(-10.0 * lost_samples) } else { 0.0 }
}

/// What keeps divisors away from zero: in JWildfire next to nothing, so that orbits near 0 go as far away as `f64` reaches.
fn floor(lost_samples: f64) -> f64 {
    variations::TINY * libm::exp10(-290.0 * lost_samples)
}

/// How many steps an orbit takes until its place and its colour are the flame's: more where colours are pulled slowly.
fn fuse(genome: &Genome) -> u64 {
    let least = if genome.finish.lost_samples > 0.0 { LOST_FUSE } else { FUSE };
    let pulls = genome.xforms.iter().map(|xform| 1.0 - (1.0 - xform.color_speed).abs().min(1.0));
    let pulls: Vec<f64> = pulls.collect();
    let slow = if genome.finish.has_flam3s_colours() { SLOW_FLAM3_COLOUR } else { SLOW_COLOUR };
    if pulls.iter().all(|pull| *pull >= slow) {
        return least;
    }
    // How often orbits go through each transform, from step to step.
    let mut visits = shares(weights(genome, &[]));
    let next: Vec<Vec<f64>> = genome.xforms.iter().map(|xform| shares(weights(genome, &xform.chaos))).collect();
    for _ in 0..64 {
        let mut after = vec![0.0; visits.len()];
        for (share, next) in visits.iter().zip(&next) {
            after.iter_mut().zip(next).for_each(|(after, next)| *after += share * next);
        }
        // The mean with the last one, so that what alternates comes to rest.
        visits = visits.iter().zip(after).map(|(before, after)| f64::midpoint(*before, after)).collect();
    }
    let pull: f64 = visits.iter().zip(pulls).map(|(share, pull)| share * pull).sum();
    // A power of two: a fuse that grew from frame to frame would change the noise.
    let is_slow = (STILL_COLOUR..slow).contains(&pull);
    if is_slow { ((2.0 / pull) as u64).next_power_of_two().max(least) } else { least }
}

/// `weights` as parts of their sum; all weights 0 choose the first.
fn shares(mut weights: Vec<f64>) -> Vec<f64> {
    let sum: f64 = weights.iter().sum();
    if sum > 0.0 {
        for weight in &mut weights {
            *weight /= sum;
        }
    } else if let Some(first) = weights.first_mut() {
        *first = 1.0;
    }
    weights
}

/// From which number on, of 2^32, a random one chooses each index but the first, by these weights; all weights 0 choose
/// the first.
fn thresholds(weights: &[f64]) -> Vec<u32> {
    let sum: f64 = weights.iter().sum();
    let mut below = 0.0;
    let mut end = |weight: &f64| {
        below += weight;
        let part = if sum > 0.0 { below / sum } else { 1.0 };
        (part * 4_294_967_296.0).min(f64::from(u32::MAX)) as u32
    };
    weights[..weights.len() - 1].iter().map(&mut end).collect()
}

/// Refuses what cannot be drawn.
fn check(genome: &Genome) -> Result<(), RenderError> {
    let (sampling, tone) = (&genome.sampling, &genome.tone);
    in_range("quality", sampling.quality, sampling.quality > 0.0, "a number above 0")?;
    in_range("gamma", tone.gamma, tone.gamma > 0.0, "a number above 0")?;
    let reasons = genome.unsupported_at_once().refused;
    if reasons.is_empty() { Ok(()) } else { Err(RenderError::Unsupported { reasons }) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::genome::Palette;

    #[test]
    fn transforms_are_chosen_by_their_weights() {
        assert_eq!(thresholds(&[0.5, 0.0, 2.0, 1.5]), [1 << 29, 1 << 29, 5 << 29]);
        assert_eq!(thresholds(&[0.0, 0.0]), [u32::MAX]);
        assert!(thresholds(&[3.0]).is_empty());
    }

    #[test]
    fn an_unknown_variation_is_refused_by_name() {
        let text = r#"<flame><xform weight="1" coefs="1 0 0 1 0 0" waltz="0.5"/></flame>"#;
        let mut genome = Genome::parse(text).unwrap();
        genome.palette = Some(Palette::from_fn(|_| [255.0; 4]));
        let refused = Plan::new(&genome, &View::new(&genome).unwrap()).unwrap_err();
        assert_eq!(refused.to_string(), "this renderer does not draw the variation `waltz` (`0.5`, transform 0)");
    }
}

//! The mutations of a flame.
//!
//! Owns how often chance takes each, and how far it goes. Never looks at a picture.
//!
//! Start at [`Genome::mutated`].

use species::{Operator, Rng};

use super::chance::{even, happens, pick, short};
use super::limits::{LEAST_XFORMS, MOST_XFORMS, bred, reordered, within_limits};
use super::palette;
use super::random::{SYMMETRIES, lens, set_chaos, spread_colours, xform};
use super::variety::{self, SOFT, drawn};
use crate::genome::{Affine, Genome, Palette, Pose, Xform};
use variations::Variation;

/// Deviations of what is done to an affine part: radians, logarithm of size, lean in radians, shift.
const TURN: f64 = 30.0 * std::f64::consts::PI / 180.0;
const SIZE: f64 = 0.25;
const LEAN: f64 = 0.15;
const SHIFT: f64 = 0.25;
/// How much of these where all transforms are changed, and of a post part.
const SLIGHTLY: f64 = 0.1;
const OF_POST: f64 = 0.5;
/// A transform that is added has this part of the mean weight.
const NEW_WEIGHT: f64 = 0.25;
/// The most variations of a transform that gets another one.
const MOST_VARIATIONS: usize = 4;
/// Deviations of what is done to a camera in space, in radians, and of its perspective.
const TILT: f64 = 0.2;
const PERSPECTIVE: f64 = 0.05;
/// The perspective of a camera that stood straight.
const NEW_PERSPECTIVE: f64 = 0.2;
/// The least opacity that a mutation gives.
const LEAST_OPACITY: f64 = 0.2;

/// What is done to a parent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Mutation {
    /// The affine part of one transform.
    Affine,
    /// Those of all, slightly.
    Affines,
    /// The variations of one transform.
    Variations,
    /// One transform more.
    Add,
    /// One less.
    Delete,
    /// A post part.
    Post,
    /// The symmetry.
    Symmetry,
    /// The palette.
    Palette,
    /// Colour coordinates and speeds.
    Colours,
    /// The final transform, an opacity or chaos.
    Final,
    /// How the camera stands in space.
    Camera,
}

/// Each with how often of 100 chance takes it where all are possible, and what it says of itself. The first alias is the
/// name of flam3-genome's nearest mutation.
pub(super) const TABLE: [(Mutation, u32, Operator); 11] = [
    (Mutation::Affine, 20, of("affine", &["one_xform"], "turns, scales, leans and shifts one transform")),
    (Mutation::Affines, 20, of("affines", &["all_coefs"], "changes the affine parts of all transforms slightly")),
    (
        Mutation::Variations,
        15,
        of("variations", &["all_vars"], "adds, replaces or drops a variation of one transform, or changes its numbers"),
    ),
    (Mutation::Add, 5, of("add", &["add_xform"], "adds a transform with a quarter of the mean weight")),
    (Mutation::Delete, 5, of("delete", &["delete_xform"], "deletes a transform")),
    (Mutation::Post, 10, of("post", &["post_xforms"], "changes the post part of one transform")),
    (Mutation::Symmetry, 8, of("symmetry", &["add_symmetry"], "adds, changes or removes the symmetry")),
    (Mutation::Palette, 7, of("palette", &["color_palette"], "turns the hues, or takes or mixes in another palette")),
    (Mutation::Colours, 5, of("colours", &["colors"], "changes colour coordinates, or how fast they change")),
    (Mutation::Final, 5, of("final", &["final_xform"], "changes the final transform, an opacity or the chaos")),
    (Mutation::Camera, 10, of("camera", &[], "tilts and turns a camera that stands in space")),
];

const fn of(name: &'static str, aliases: &'static [&'static str], does: &'static str) -> Operator {
    Operator::mutation(name, aliases, does)
}

impl Mutation {
    /// What it is called.
    pub fn name(self) -> &'static str {
        TABLE[self as usize].2.name
    }

    /// The one that is called `name`.
    pub(super) fn named(name: &str) -> Option<Mutation> {
        TABLE.iter().find(|(_, _, operator)| operator.name == name).map(|(mutation, ..)| *mutation)
    }

    /// Whether it leaves every point where it is, so that the camera may stay.
    pub fn is_of_colours(self) -> bool {
        matches!(self, Mutation::Palette | Mutation::Colours)
    }

    /// One by chance, among those that can be done to `genome`.
    pub(super) fn drawn(genome: &Genome, rng: &mut Rng) -> Mutation {
        let share = |(mutation, share, _): &(Mutation, u32, Operator)| {
            if mutation.fits(genome) { f64::from(*share) } else { 0.0 }
        };
        let shares: Vec<f64> = TABLE.iter().map(share).collect();
        TABLE[rng.weighted(&shares).unwrap_or(0)].0
    }

    /// Whether chance may take it for `genome`: a camera that stands straight is tilted only if that is asked for.
    pub(super) fn fits(self, genome: &Genome) -> bool {
        match self {
            Mutation::Add => genome.xforms.len() < MOST_XFORMS,
            Mutation::Delete => genome.xforms.len() > LEAST_XFORMS,
            Mutation::Camera => !genome.camera.pose.is_straight(),
            Mutation::Affine
            | Mutation::Affines
            | Mutation::Variations
            | Mutation::Post
            | Mutation::Symmetry
            | Mutation::Palette
            | Mutation::Colours
            | Mutation::Final => true,
        }
    }

    /// Does it to `genome`, `strength` times as much as usual.
    fn change(self, genome: &mut Genome, strength: f64, rng: &mut Rng) {
        let one = rng.below(genome.xforms.len());
        match self {
            Mutation::Affine => genome.xforms[one].affine = moved(&genome.xforms[one].affine, strength, rng),
            Mutation::Affines => {
                for xform in &mut genome.xforms {
                    xform.affine = moved(&xform.affine, SLIGHTLY * strength, rng);
                }
            }
            Mutation::Variations => change_variations(&mut genome.xforms[one], strength, rng),
            Mutation::Add => add(genome, rng),
            Mutation::Delete => remove(genome, one),
            Mutation::Post => genome.xforms[one].post = moved(&genome.xforms[one].post, OF_POST * strength, rng),
            Mutation::Symmetry => change_symmetry(genome, rng),
            Mutation::Palette => {
                let palette = genome.palette.as_ref().map(|own| changed_palette(own, rng));
                genome.palette = Some(palette.unwrap_or_else(|| palette::drawn(rng)));
            }
            Mutation::Colours => change_colours(&mut genome.xforms, strength, rng),
            Mutation::Final => change_final(genome, one, rng),
            Mutation::Camera => change_pose(&mut genome.camera.pose, strength, rng),
        }
    }
}

impl Genome {
    /// A child by a mutation that chance takes, and which it is; `strength` (> 0) times as far as usual. Its camera stands
    /// where the parent's does.
    pub fn mutated(&self, strength: f64, rng: &mut Rng) -> (Genome, Mutation) {
        let parent = bred(self, rng);
        let mutation = Mutation::drawn(&parent, rng);
        (changed(parent, mutation, strength, rng), mutation)
    }

    /// A child by this mutation. `None` if there are too many transforms to add one, or too few to delete one.
    pub fn mutated_by(&self, mutation: Mutation, strength: f64, rng: &mut Rng) -> Option<Genome> {
        let parent = bred(self, rng);
        let is_possible = mutation == Mutation::Camera || mutation.fits(&parent);
        is_possible.then(|| changed(parent, mutation, strength, rng))
    }
}

fn changed(mut genome: Genome, mutation: Mutation, strength: f64, rng: &mut Rng) -> Genome {
    mutation.change(&mut genome, strength, rng);
    within_limits(genome)
}

/// An affine part that is turned, scaled, leans and is shifted.
fn moved(affine: &Affine, strength: f64, rng: &mut Rng) -> Affine {
    let by = |deviation: f64, rng: &mut Rng| strength * deviation * rng.normal();
    let turned = affine.turned(by(TURN, rng));
    let (size, (sin, cos)) = (libm::exp(by(SIZE, rng).clamp(-1.5, 1.5)), libm::sincos(by(LEAN, rng)));
    Affine {
        a: size * turned.a,
        d: size * turned.d,
        b: size * (cos * turned.b - sin * turned.e),
        e: size * (sin * turned.b + cos * turned.e),
        c: affine.c + by(SHIFT, rng),
        f: affine.f + by(SHIFT, rng),
    }
}

/// Adds, replaces or drops a variation, or changes all numbers: whatever of these is possible, equally often.
fn change_variations(xform: &mut Xform, strength: f64, rng: &mut Rng) {
    let variations = &mut xform.variations;
    variations.retain(|variation| variation.weight != 0.0);
    let new = drawn(&SOFT, rng)[0];
    let (count, is_new) = (variations.len(), variations.iter().all(|variation| variation.kind != new.kind));
    let ways = [is_new && count < MOST_VARIATIONS, is_new && count > 0, count > 1, count > 0];
    let way = rng.weighted(&ways.map(|is_possible| f64::from(u8::from(is_possible)))).unwrap_or(0);
    let one = rng.below(count.max(1));
    match way {
        0 => {
            let weight = even(rng, 0.2, 0.6);
            for variation in &mut *variations {
                variation.weight *= 1.0 - weight;
            }
            variations.push(Variation { weight: new.weight * weight, ..new });
        }
        1 => variations[one] = Variation { weight: variations[one].weight, ..new },
        2 => {
            let gone = variations.remove(one);
            let left: f64 = variations.iter().map(|variation| variation.weight.abs()).sum();
            // What is left is as strong as all were.
            for variation in variations {
                variation.weight *= (left + gone.weight.abs()) / left;
            }
        }
        _ => variations.iter_mut().for_each(|variation| *variation = variety::changed(variation, strength, rng)),
    }
}

/// Adds a transform behind the others: chaos counts those of the symmetry after it.
fn add(genome: &mut Genome, rng: &mut Rng) {
    let count = genome.xforms.len();
    let mean = genome.xforms.iter().map(|xform| xform.weight.max(0.0)).sum::<f64>() / count as f64;
    for xform in genome.xforms.iter_mut().filter(|xform| xform.chaos.len() > count) {
        xform.chaos.insert(count, 1.0);
    }
    genome.xforms.push(Xform { weight: NEW_WEIGHT * mean, ..xform(&SOFT, rng) });
}

/// Takes transform `one` out.
pub(super) fn remove(genome: &mut Genome, one: usize) {
    let left: Vec<usize> = (0..genome.xforms.len()).filter(|number| *number != one).collect();
    genome.xforms = reordered(&genome.xforms, &left);
}

/// Another symmetry, none, or one where there was none.
fn change_symmetry(genome: &mut Genome, rng: &mut Rng) {
    let others: Vec<i32> = SYMMETRIES.into_iter().filter(|kind| !genome.symmetries.contains(kind)).collect();
    let is_removed = !genome.symmetries.is_empty() && happens(rng, 0.5);
    genome.symmetries = if is_removed { Vec::new() } else { vec![pick(rng, &others)] };
}

fn changed_palette(own: &Palette, rng: &mut Rng) -> Palette {
    match rng.below(3) {
        0 => {
            let turn = even(rng, 20.0, 180.0);
            palette::with_hues_turned(own, if happens(rng, 0.5) { turn } else { -turn })
        }
        1 => palette::drawn(rng),
        _ => {
            let other = palette::drawn(rng);
            let crossed = palette::crossed(own, &other, rng);
            // One in thirteen never goes over.
            if crossed == *own { other } else { crossed }
        }
    }
}

fn change_colours(xforms: &mut [Xform], strength: f64, rng: &mut Rng) {
    match rng.below(3) {
        0 => spread_colours(xforms, rng),
        1 => {
            for xform in xforms {
                xform.color = (xform.color + 0.15 * strength * rng.normal()).clamp(0.0, 1.0);
            }
        }
        _ => xforms.iter_mut().for_each(|xform| xform.color_speed = even(rng, 0.2, 0.8)),
    }
}

/// A camera that is tilted and turned by chance.
fn change_pose(pose: &mut Pose, strength: f64, rng: &mut Rng) {
    if pose.is_straight() {
        pose.perspective = NEW_PERSPECTIVE;
    }
    for angle in [&mut pose.pitch, &mut pose.yaw] {
        *angle = short(*angle + TILT * strength * rng.normal());
    }
    if pose.perspective != 0.0 {
        pose.perspective = short(pose.perspective + PERSPECTIVE * strength * rng.normal());
    }
}

/// Another final transform or none, another opacity, or other preferences.
fn change_final(genome: &mut Genome, one: usize, rng: &mut Rng) {
    match rng.below(3) {
        0 => {
            let is_removed = !genome.finals.is_empty() && happens(rng, 0.5);
            genome.finals = if is_removed { Vec::new() } else { vec![lens(rng)] };
        }
        1 => {
            let xform = &mut genome.xforms[one];
            xform.opacity = if xform.opacity < 1.0 { 1.0 } else { even(rng, LEAST_OPACITY, 0.9) };
        }
        _ => {
            let has_chaos = genome.xforms.iter().any(|xform| !xform.chaos.is_empty());
            if has_chaos && happens(rng, 0.5) {
                genome.xforms.iter_mut().for_each(|xform| xform.chaos.clear());
            } else {
                set_chaos(&mut genome.xforms, rng);
            }
        }
    }
}

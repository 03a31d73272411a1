//! What every flame that is bred is like.
//!
//! Owns how many transforms it has, that symmetries are said as such, that weights are above 0, and that its file has no
//! stale name and no endless digits. Never takes anything by chance but what is missing.
//!
//! Start at [`bred`] for a parent and at [`within_limits`] for a child.

use species::Rng;

use super::chance::short;
use super::random::xform;
use super::variety::SOFT;
use crate::genome::{Affine, Genome, Palette, Xform};

/// How many transforms there are, those of a symmetry left out.
pub(super) const LEAST_XFORMS: usize = 2;
pub(super) const MOST_XFORMS: usize = 8;
/// The lightest transform, as a part of the mean weight: less is hardly ever chosen.
const LEAST_WEIGHT: f64 = 0.02;

/// A parent as breeding takes it: symmetries that are written out as transforms are said as such, and it has as many
/// transforms as a child may have. What only says who made it and how it is called is gone.
pub(super) fn bred(parent: &Genome, rng: &mut Rng) -> Genome {
    // A child is bred from what is drawn: it has nothing that anybody had to leave out.
    let mut genome = parent.with_symmetry_said().without_left_out();
    // The colours are there; a number would ask a library for others.
    (genome.name, genome.time) = (None, 0.0);
    (genome.palette_number, genome.palette_blend, genome.hue) = (None, None, 0.0);
    while genome.xforms.len() < LEAST_XFORMS {
        genome.xforms.push(xform(&SOFT, rng));
    }
    lighten(&mut genome);
    genome
}

/// A child as it may be shown to others: of 2 to 8 transforms, the lightest go; each has a weight above 0.
pub(super) fn within_limits(mut genome: Genome) -> Genome {
    lighten(&mut genome);
    let mean = genome.xforms.iter().map(|xform| xform.weight.max(0.0)).sum::<f64>() / genome.xforms.len() as f64;
    let least = if mean > 0.0 { LEAST_WEIGHT * mean } else { 1.0 };
    for xform in genome.xforms.iter_mut().chain(&mut genome.finals) {
        tidy(xform);
    }
    for xform in &mut genome.xforms {
        xform.weight = short(xform.weight.max(least));
    }
    genome
}

/// Takes out the lightest transforms where there are too many.
fn lighten(genome: &mut Genome) {
    if genome.xforms.len() <= MOST_XFORMS {
        return;
    }
    let mut heaviest: Vec<usize> = (0..genome.xforms.len()).collect();
    heaviest.sort_by(|a, b| genome.xforms[*b].weight.total_cmp(&genome.xforms[*a].weight));
    heaviest.truncate(MOST_XFORMS);
    heaviest.sort_unstable();
    genome.xforms = reordered(&genome.xforms, &heaviest);
}

/// The transforms of these numbers, with what chaos says of them. Those of a symmetry follow all others.
pub(super) fn reordered(xforms: &[Xform], numbers: &[usize]) -> Vec<Xform> {
    let of = |number: &usize| {
        let xform = &xforms[*number];
        let weight = |number: usize| xform.chaos.get(number).copied().unwrap_or(1.0);
        let all = numbers.iter().copied().chain(xforms.len()..xform.chaos.len());
        let chaos: Vec<f64> = if xform.chaos.is_empty() { Vec::new() } else { all.map(weight).collect() };
        // With nothing left to follow it, it is followed by any.
        let is_dead_end = !chaos.is_empty() && chaos.iter().all(|weight| *weight <= 0.0);
        Xform { chaos: if is_dead_end { Vec::new() } else { chaos }, ..xform.clone() }
    };
    numbers.iter().map(of).collect()
}

fn tidy(xform: &mut Xform) {
    xform.variations.retain(|variation| variation.weight != 0.0);
    for variation in &mut xform.variations {
        variation.weight = short(variation.weight);
        variation.params = variation.params.map(short);
    }
    let Xform { tilt, post_tilt, .. } = xform;
    let in_space = [&mut tilt.yz, &mut tilt.zx, &mut post_tilt.yz, &mut post_tilt.zx];
    for affine in [&mut xform.affine, &mut xform.post].into_iter().chain(in_space) {
        let Affine { a, b, c, d, e, f } = *affine;
        let [a, b, c, d, e, f] = [a, b, c, d, e, f].map(short);
        *affine = Affine { a, b, c, d, e, f };
    }
    for number in [&mut xform.color, &mut xform.color_speed, &mut xform.opacity].into_iter().chain(&mut xform.chaos) {
        *number = short(*number);
    }
}

/// A palette in whole numbers.
pub(super) fn in_bytes(palette: &Palette) -> Palette {
    Palette::from_fn(|entry| palette.entries[entry].map(|channel| channel.clamp(0.0, 255.0).round()))
}

//! Waves: what `<motion>` elements add to a transform at a moment of its loop.
//!
//! Owns the shapes of the waves and the adding. Reading them is `genome/wave.rs`'s.
//!
//! Start at [`waved`].
//!
//! # Source
//! Shapes, order and limits as `flam3-genome` prints them for the frames of a loop: a weight is never below 0, a colour
//! is in `0.0..=1.0`, and everything else is whatever the sum is.

use std::f64::consts::{PI, TAU};

use crate::genome::{Affine, Wave, WaveShape, Xform};
use variations::Variation;

/// The transform with its waves added, `part` of the loop after its start (any number), and without waves.
pub(super) fn waved(xform: &Xform, part: f64) -> Xform {
    let mut moved = Xform { motions: Vec::new(), ..xform.clone() };
    if xform.motions.is_empty() {
        return moved;
    }
    for wave in &xform.motions {
        add(&mut moved, wave, height(wave, part));
    }
    moved.weight = moved.weight.max(0.0);
    moved.color = moved.color.clamp(0.0, 1.0);
    moved
}

/// What the waves of `xform` add to its affine part, and to its post part.
pub(super) fn added_to_affines(xform: &Xform, part: f64) -> [Affine; 2] {
    let nothing = Affine { a: 0.0, e: 0.0, ..Affine::IDENTITY };
    xform.motions.iter().fold([nothing; 2], |[affine, post], wave| {
        let height = height(wave, part);
        [affine.plus(&wave.added.affine, height), post.plus(&wave.added.post, height)]
    })
}

/// The transform with a variation of weight 0 for each that only a wave gives a weight.
pub(super) fn with_kinds_of_waves(mut xform: Xform) -> Xform {
    for wave in &xform.motions {
        for variation in &wave.added.variations {
            find_or_add(&mut xform.variations, variation);
        }
    }
    xform
}

/// The height of a wave, `-1.0..=1.0`: 0 at the start of a loop.
fn height(wave: &Wave, part: f64) -> f64 {
    let turns = (f64::from(wave.frequency) * part).rem_euclid(1.0);
    match wave.shape {
        WaveShape::Sin => libm::sin(TAU * turns),
        WaveShape::Triangle => {
            if turns < 0.75 {
                1.0 - (4.0 * turns - 1.0).abs()
            } else {
                4.0 * turns - 4.0
            }
        }
        WaveShape::Hill => libm::sin(PI * turns).powi(2),
    }
}

fn add(xform: &mut Xform, wave: &Wave, height: f64) {
    let added = &wave.added;
    xform.weight += height * added.weight;
    xform.color += height * added.color;
    xform.color_speed += height * added.color_speed;
    xform.animate += height * added.animate;
    xform.opacity += height * added.opacity;
    xform.affine = xform.affine.plus(&added.affine, height);
    xform.post = xform.post.plus(&added.post, height);
    for variation in &added.variations {
        let sum = find_or_add(&mut xform.variations, variation);
        sum.weight += height * variation.weight;
        for (sum, parameter) in sum.params.iter_mut().zip(variation.params) {
            *sum += height * parameter;
        }
    }
    // flam3 reads `symmetry` here and does nothing with it; what is unknown cannot be rendered.
    let unknown = added.extra.iter().filter(|(name, _)| name != "symmetry");
    xform.extra.extend(unknown.cloned());
}

/// The variation in the place of `like`, added with weight 0 and default parameters where it is missing.
fn find_or_add<'a>(variations: &'a mut Vec<Variation>, like: &Variation) -> &'a mut Variation {
    let found = variations.iter().position(|variation| variation.slot() == like.slot());
    let index = found.unwrap_or_else(|| {
        variations.push(like.slot().absent());
        variations.len() - 1
    });
    &mut variations[index]
}

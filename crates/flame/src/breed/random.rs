//! Flames by chance.
//!
//! Owns how many transforms there are, how large they are, and the look of the picture. Never judges one.
//!
//! Start at [`Genome::random`].

use std::f64::consts::TAU;

use species::Rng;

use super::chance::{even, happens, pick};
use super::palette;
use super::variety::{Family, LENSES, SOFT, drawn, is_root, of_kind};
use crate::genome::{Affine, Camera, Genome, PaletteMode, Pose, Sampling, Tone, Xform};
use variations::Kind;

/// How many transforms, by chance.
const COUNTS: [usize; 9] = [2, 2, 3, 3, 3, 4, 4, 5, 6];
/// The most beside a symmetry, which repeats them.
const MOST_WITH_SYMMETRY: usize = 3;
/// `<symmetry kind>`, by chance.
pub(super) const SYMMETRIES: [i32; 7] = [2, 3, 4, 5, 6, -2, -3];
/// How often there is what.
const WITH_SYMMETRY: f64 = 0.2;
const WITH_POST: f64 = 0.22;
const WITH_CHAOS: f64 = 0.3;
const WITH_LENS: f64 = 0.4;

impl Genome {
    /// A flame of 2 to 6 transforms at random. Its camera and its brightness are not yet set, and it may look like anything.
    pub fn random(rng: &mut Rng) -> Genome {
        let family = Family::random(rng);
        let symmetry = happens(rng, WITH_SYMMETRY).then(|| pick(rng, &SYMMETRIES));
        let count = pick(rng, &COUNTS);
        let count = if symmetry.is_some() { count.min(MOST_WITH_SYMMETRY) } else { count };
        let mut xforms: Vec<Xform> = (0..count)
            .map(|number| {
                // Beside transforms of its family a flame has others.
                let is_other = family != Family::Any && number > 0 && happens(rng, 0.45);
                xform(if is_other { &SOFT } else { family.kinds() }, rng)
            })
            .collect();
        spread_colours(&mut xforms, rng);
        if count > 2 && happens(rng, WITH_CHAOS) {
            set_chaos(&mut xforms, rng);
        }
        Genome {
            camera: Camera {
                size: [1280, 720],
                center: [0.0; 2],
                scale: 200.0,
                zoom: 0.0,
                rotate: 0.0,
                center_turns: 1.0,
                pose: Pose::default(),
            },
            sampling: Sampling {
                quality: 400.0,
                supersample: 2,
                filter_radius: 0.9,
                temporal_samples: 64,
                estimator_radius: 6.0,
                estimator_curve: 0.5,
                ..Genome::default().sampling
            },
            tone: Tone {
                brightness: 6.0,
                gamma: 2.5,
                gamma_threshold: 0.015,
                highlight_power: 1.0,
                ..Genome::default().tone
            },
            palette: Some(palette::drawn(rng)),
            palette_mode: PaletteMode::Linear,
            symmetries: symmetry.into_iter().collect(),
            finals: happens(rng, WITH_LENS).then(|| lens(rng)).into_iter().collect(),
            xforms,
            ..Genome::default()
        }
    }
}

/// A transform with variations of `kinds`. Its colour is by chance.
pub(super) fn xform(kinds: &[Kind], rng: &mut Rng) -> Xform {
    let variations = drawn(kinds, rng);
    let roots = variations.iter().any(|variation| is_root(variation.kind));
    let weight = if roots && happens(rng, 0.5) { even(rng, 2.0, 6.0) } else { even(rng, 0.3, 2.2) };
    let largest = if roots || happens(rng, 0.4) { 1.15 } else { 0.9 };
    let skew = pick(rng, &[0.0, 0.1, 0.35]);
    let affine = affine([0.35, largest], 1.0, skew, rng);
    let post = if happens(rng, WITH_POST) { self::affine([0.5, 1.3], 0.6, 0.1, rng) } else { Affine::IDENTITY };
    let (color, color_speed) = (rng.unit(), speed(rng));
    Xform { weight, color, color_speed, affine, post, variations, ..Xform::default() }
}

/// A final transform.
pub(super) fn lens(rng: &mut Rng) -> Xform {
    let kind = pick(rng, &LENSES);
    let mut variation = of_kind(kind, 1.0, rng);
    if matches!(kind, Kind::Julian | Kind::Juliascope) {
        // Another distance would show mostly the middle.
        variation.params[1] = 1.0;
    }
    let affine = affine([0.6, 1.3], 0.5, 0.05, rng);
    Xform { color_speed: 0.0, animate: 0.0, affine, variations: vec![variation], ..Xform::default() }
}

/// A size within `sizes`, any turn, and a shift of up to `shift` in either direction; `skew` is how far columns may differ.
fn affine(sizes: [f64; 2], shift: f64, skew: f64, rng: &mut Rng) -> Affine {
    let (size, turn) = (even(rng, sizes[0], sizes[1]), even(rng, 0.0, TAU));
    let (longer, lean) = (1.0 + skew * rng.signed(), skew * rng.signed());
    let ((sin, cos), (leaning_sin, leaning_cos)) = (libm::sincos(turn), libm::sincos(turn + lean));
    Affine {
        a: size * cos,
        d: size * sin,
        b: -size * longer * leaning_sin,
        e: size * longer * leaning_cos,
        c: shift * rng.signed(),
        f: shift * rng.signed(),
    }
}

/// How far a transform pulls colours.
pub(super) fn speed(rng: &mut Rng) -> f64 {
    pick(rng, &[0.5, 0.5, 0.5, 0.35, 0.65])
}

/// Spreads the colour coordinates over the palette, in any order.
pub(super) fn spread_colours(xforms: &mut [Xform], rng: &mut Rng) {
    let last = xforms.len().saturating_sub(1).max(1) as f64;
    let mut colours: Vec<f64> =
        (0..xforms.len()).map(|number| ((number as f64 + 0.2 * rng.signed()) / last).clamp(0.0, 1.0)).collect();
    for at in (1..colours.len()).rev() {
        colours.swap(at, rng.below(at + 1));
    }
    for (xform, colour) in xforms.iter_mut().zip(colours) {
        xform.color = colour;
    }
}

/// Gives transforms preferences for the next one; each is followed by one at least.
pub(super) fn set_chaos(xforms: &mut [Xform], rng: &mut Rng) {
    let count = xforms.len();
    for (number, xform) in xforms.iter_mut().enumerate() {
        xform.chaos = (0..count).map(|_| pick(rng, &[0.0, 0.15, 0.5, 1.0, 1.0, 1.0, 2.0, 1.0])).collect();
        if xform.chaos.iter().sum::<f64>() < 0.3 {
            xform.chaos[(number + 1) % count] = 1.0;
        }
    }
}

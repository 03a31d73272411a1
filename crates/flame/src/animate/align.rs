//! Giving two genomes the same parts.
//!
//! Owns the neutral transforms that pad the shorter genome. Never interpolates: `transition.rs` does.
//!
//! Start at [`align`].
//!
//! # Source
//! The choice of neutral transforms follows what the flam3 documentation says of padding: beside a variation that is
//! discontinuous at its centre, the identity is written as a half turn of a half turn.

use super::waves::with_kinds_of_waves;
use crate::genome::{Affine, Genome, Space, Xform};
use crate::variations::{Kind, Variation};

/// The variations that are discontinuous at their centre.
const DISCONTINUOUS: [Kind; 7] =
    [Kind::Spherical, Kind::Ngon, Kind::Julian, Kind::Juliascope, Kind::Polar, Kind::WedgeSph, Kind::WedgeJulia];

/// The two genomes with symmetries written out, equally many transforms, the same variations in each pair, and
/// a final transform in both or in none. What is added changes no picture.
pub(super) fn align(from: &Genome, to: &Genome) -> [Genome; 2] {
    let mut pair = [from.with_symmetry(), to.with_symmetry()];
    let polar = from.space == Space::Log && to.space == Space::Log;
    let count = pair[0].xforms.len().max(pair[1].xforms.len());
    let finals = pair.clone().map(|genome| genome.final_xform);
    for side in 0..2 {
        let other = pair[1 - side].xforms.clone();
        let xforms = &mut pair[side].xforms;
        for partner in other.iter().skip(xforms.len()) {
            xforms.push(neutral(partner, polar));
        }
        if let (None, Some(partner)) = (&finals[side], &finals[1 - side]) {
            let still = Xform { color_speed: 0.0, animate: 0.0, ..neutral(partner, polar) };
            pair[side].final_xform = Some(still);
        }
    }
    for genome in &mut pair {
        for xform in genome.xforms.iter_mut().chain(&mut genome.final_xform) {
            *xform = with_kinds_of_waves(std::mem::take(xform));
        }
    }
    let xaos = pair.iter().flat_map(|genome| &genome.xforms).any(|xform| !xform.chaos.is_empty());
    for xform in pair.iter_mut().flat_map(|genome| &mut genome.xforms).filter(|_| xaos) {
        xform.chaos.resize(count, 1.0);
    }
    for xform in pair.iter_mut().flat_map(|genome| &mut genome.xforms) {
        // A weight below 0 is never chosen, like 0; interpolated, it would stay below 0 for longer.
        xform.weight = xform.weight.max(0.0);
    }
    let [from, to] = &mut pair;
    let firsts = from.xforms.iter_mut().chain(&mut from.final_xform);
    for (a, b) in firsts.zip(to.xforms.iter_mut().chain(&mut to.final_xform)) {
        complete(&mut a.variations, &b.variations);
        complete(&mut b.variations, &a.variations);
    }
    pair
}

/// Adds what only `other` has, with weight 0 and the same parameters, and sorts by kind.
fn complete(variations: &mut Vec<Variation>, other: &[Variation]) {
    for missing in other {
        if variations.iter().all(|variation| variation.kind != missing.kind) {
            variations.push(Variation { weight: 0.0, ..*missing });
        }
    }
    variations.sort_by_key(|variation| variation.kind);
}

/// A transform of weight 0 that leaves every point where it is and goes well with `partner`.
fn neutral(partner: &Xform, polar: bool) -> Xform {
    let has = |kinds: &[Kind]| partner.variations.iter().any(|v| v.weight != 0.0 && kinds.contains(&v.kind));
    let (affine, variations) = if polar && has(&DISCONTINUOUS) {
        let half_turn = Affine { a: -1.0, e: -1.0, ..Affine::IDENTITY };
        (half_turn, vec![Variation::new(Kind::Linear, -1.0)])
    } else {
        (Affine::IDENTITY, identities(partner))
    };
    Xform {
        weight: 0.0,
        color: partner.color,
        color_speed: partner.color_speed,
        animate: partner.animate,
        opacity: partner.opacity,
        affine,
        variations,
        ..Xform::default()
    }
}

/// The partner's own variations where parameters make them identities, sharing a weight of 1; else linear.
#[expect(clippy::wildcard_enum_match_arm, reason = "few variations can be made identities")]
fn identities(partner: &Xform) -> Vec<Variation> {
    let identity = |variation: &Variation| {
        let params: &[f64] = match variation.kind {
            Kind::Rectangles | Kind::Fan2 | Kind::Curl => &[0.0, 0.0],
            Kind::Rings2 => &[0.0],
            Kind::Blob => &[1.0, 1.0, 1.0],
            Kind::Perspective => &[0.0, variation.params[1]],
            Kind::SuperShape => &[0.0, variation.params[1], 2.0, 2.0, 2.0, 0.0],
            _ => return None,
        };
        Some(Variation::new(variation.kind, 1.0).with(params))
    };
    let mut found: Vec<Variation> = partner.variations.iter().filter_map(identity).collect();
    let share = 1.0 / found.len().max(1) as f64;
    for variation in &mut found {
        variation.weight = share;
    }
    if found.is_empty() { vec![Variation::new(Kind::Linear, 1.0)] } else { found }
}

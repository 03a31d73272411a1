//! Giving two genomes the same parts.
//!
//! Owns the neutral transforms that pad the shorter genome. Never interpolates: `transition.rs` and `keys.rs` do.
//!
//! Start at [`align`].
//!
//! # Source
//! The choice of neutral transforms follows what the flam3 documentation says of padding: beside a variation that is
//! discontinuous at its centre, the identity is written as a half turn of a half turn. What `old` leaves out was seen in
//! what `flam3-genome` prints.

use super::waves::with_kinds_of_waves;
use crate::genome::{Affine, Genome, Space, Xform};
use variations::{Kind, Slot, Stage, Variation};

/// The variations that are discontinuous at their centre.
const DISCONTINUOUS: [Kind; 7] =
    [Kind::Spherical, Kind::Ngon, Kind::Julian, Kind::Juliascope, Kind::Polar, Kind::WedgeSph, Kind::WedgeJulia];

/// The first of two parameters of lazysusan.
const CENTRE_OF_LAZYSUSAN: usize = 3;

/// Whose colours, motion and parameters has what pads a genome.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Padding {
    /// Its partner's, but where those would show: it shows nothing new while its weight grows.
    AsPartner,
    /// Those that flam3 gives it.
    AsFlam3,
}

/// The same parts for all `genomes`, whose symmetries are written out: equally many transforms, the same variations in each
/// place, and equally many final transforms. What is added changes no picture. Affine parts are to be interpolated
/// in `space`.
pub(super) fn align<const N: usize>(mut genomes: [Genome; N], space: Space, padding: Padding) -> [Genome; N] {
    let given = genomes.clone();
    // A neighbour that has the part, the one before first.
    let neighbour = |own: usize, has: &dyn Fn(&Genome) -> Option<Xform>| {
        own.checked_sub(1).and_then(|at| has(&given[at])).or_else(|| given.get(own + 1).and_then(has))
    };
    let final_count = given.iter().map(|genome| genome.finals.len()).max().unwrap_or_default();
    let count = given.iter().map(|genome| genome.xforms.len()).max().unwrap_or_default();
    for (own, genome) in genomes.iter_mut().enumerate() {
        for place in genome.xforms.len()..count {
            let partner = neighbour(own, &|other| other.xforms.get(place).cloned()).unwrap_or_default();
            genome.xforms.push(coloured(neutral(&partner, space), &partner, place, padding));
        }
        for place in genome.finals.len()..final_count {
            let partner = neighbour(own, &|other| other.finals.get(place).cloned()).unwrap_or_default();
            let still = coloured(neutral(&partner, space), &partner, count, padding);
            genome.finals.push(Xform { color_speed: 0.0, animate: 0.0, ..still });
        }
        for xform in genome.xforms.iter_mut().chain(&mut genome.finals) {
            *xform = with_kinds_of_waves(std::mem::take(xform));
        }
    }
    let xaos = genomes.iter().flat_map(|genome| &genome.xforms).any(|xform| !xform.chaos.is_empty());
    for xform in genomes.iter_mut().flat_map(|genome| &mut genome.xforms) {
        if xaos {
            xform.chaos.resize(count, 1.0);
        }
        // A weight below 0 is never chosen, like 0; interpolated, it would stay below 0 for longer.
        xform.weight = xform.weight.max(0.0);
    }
    let padded = genomes.clone();
    for (own, genome) in genomes.iter_mut().enumerate() {
        // Parameters come from the one before, of the first from the second; what only others have is as files need not say.
        let source = if own == 0 { 1 } else { own - 1 };
        for (at, other) in padded.iter().enumerate().cycle().skip(source).take(N).filter(|(at, _)| *at != own) {
            let has_params = at == source && !is_old(space);
            let parts = other.xforms.iter().chain(&other.finals);
            for (xform, other) in genome.xforms.iter_mut().chain(&mut genome.finals).zip(parts) {
                complete(&mut xform.variations, &other.variations, has_params, padding);
            }
        }
        for xform in genome.xforms.iter_mut().chain(&mut genome.finals) {
            if xform.variations.iter().all(|variation| variation.stage == Stage::Sum) {
                xform.variations.sort_by_key(Variation::slot);
            }
        }
    }
    in_one_order(&mut genomes);
    genomes
}

/// Puts variations of which some do not stand in the sum in the order of the first genome: those that only others have
/// follow the one that they follow there.
fn in_one_order<const N: usize>(genomes: &mut [Genome; N]) {
    let parts = |genome: &Genome| genome.xforms.iter().chain(&genome.finals).cloned().collect::<Vec<Xform>>();
    let all = genomes.each_ref().map(parts);
    for place in 0..all[0].len() {
        let lists = all.each_ref().map(|xforms| &xforms[place].variations[..]);
        if lists[0].iter().all(|variation| variation.stage == Stage::Sum) {
            continue;
        }
        let order = common_order(&lists);
        for genome in &mut *genomes {
            if let Some(xform) = genome.xforms.iter_mut().chain(&mut genome.finals).nth(place) {
                xform.variations.sort_by_key(|variation| order.iter().position(|slot| *slot == variation.slot()));
            }
        }
    }
}

/// The places of all variations, each once, in an order that is that of each list where the lists agree. A list has what
/// it lacked at its end: that counts only where no other list says more.
fn common_order(lists: &[&[Variation]]) -> Vec<Slot> {
    let mut order: Vec<Slot> = Vec::new();
    for list in lists {
        let mut after = 0;
        for variation in list.iter().filter(|variation| !variation.is_absent()) {
            let slot = variation.slot();
            let place = order.iter().position(|known| *known == slot).unwrap_or_else(|| {
                order.insert(after, slot);
                after
            });
            after = place + 1;
        }
    }
    order
}

/// Adds what only `other` has, with weight 0, and with its parameters if `has_params`, else those that files need not name.
fn complete(variations: &mut Vec<Variation>, other: &[Variation], has_params: bool, padding: Padding) {
    for missing in other {
        let slot = missing.slot();
        if variations.iter().all(|variation| variation.slot() != slot) {
            let mut added =
                if has_params { Variation { presence: slot.absent().presence, ..*missing } } else { slot.absent() };
            if padding == Padding::AsPartner && added.kind == Kind::Lazysusan {
                // Its centre is added to every point, whatever its weight: flam3 jumps here.
                added.params[CENTRE_OF_LAZYSUSAN..][..2].fill(0.0);
            }
            // What replaces the point comes by its presence, in the partner's own strength.
            let weight = if slot.comes_by_presence() { missing.weight } else { 0.0 };
            variations.push(Variation { weight, ..added });
        }
    }
}

fn is_old(space: Space) -> bool {
    matches!(space, Space::Old | Space::Older)
}

/// A transform of weight 0 that leaves every point where it is and goes well with `partner`.
fn neutral(partner: &Xform, space: Space) -> Xform {
    let has = |kinds: &[Kind]| partner.variations.iter().any(|v| v.weight != 0.0 && kinds.contains(&v.kind));
    let (affine, variations) = if is_old(space) {
        (Affine::IDENTITY, vec![Variation::new(Kind::Linear, 1.0)])
    } else if space == Space::Log && has(&DISCONTINUOUS) {
        let half_turn = Affine { a: -1.0, e: -1.0, ..Affine::IDENTITY };
        (half_turn, vec![Variation::new(Kind::Linear, -1.0)])
    } else {
        (Affine::IDENTITY, identities(partner))
    };
    Xform { weight: 0.0, affine, variations, ..Xform::default() }
}

/// The neutral transform number `place` with the colours that `padding` gives it.
fn coloured(neutral: Xform, partner: &Xform, place: usize, padding: Padding) -> Xform {
    match padding {
        Padding::AsPartner => Xform {
            color: partner.color,
            color_speed: partner.color_speed,
            animate: partner.animate,
            opacity: partner.opacity,
            ..neutral
        },
        Padding::AsFlam3 => Xform { color: (place & 1) as f64, ..neutral },
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

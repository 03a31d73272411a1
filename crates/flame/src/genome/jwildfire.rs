//! What attributes of a transform mean in JWildfire alone.
//!
//! Owns priorities, which say when variations are applied, and attributes that choose among ways of drawing. They are applied
//! when all variations are known, and what they said becomes a part of the variations. Never reads a weight or a parameter.
//!
//! Start at [`settle`].
//!
//! # Source
//! What JWildfire's transforms make of a point with a chosen sequence of random numbers.

use std::collections::{HashMap, HashSet};

use roxmltree::Node;

use super::Xform;
use super::parse::list;
use variations::{Kind, Part, Slot, Spelling, Stage, Variation};

/// Half of the interval in which the programs draw shifts of a falloff: in JWildfire it begins at 0.
const ABOVE: f64 = 0.5;

/// Applies what attributes of `xform` say, and forgets them. `is_own` says whether JWildfire wrote it, as `node`.
pub(super) fn settle(xform: &mut Xform, is_own: bool, node: Node) {
    if is_own {
        shift_falloffs(xform, node);
    }
    apply_priorities(xform);
    apply_choices(xform);
}

/// Has falloffs of which the file does not say where their interval lies draw as JWildfire does.
fn shift_falloffs(xform: &mut Xform, node: Node) {
    for variation in xform.variations.iter_mut().filter(|variation| variation.kind == Kind::Falloff2) {
        let parameters = variation.kind.parameters().iter().zip(&mut variation.params);
        for (parameter, value) in parameters.filter(|(parameter, _)| parameter.name == "above") {
            let says = |name: &str| {
                let spelling = Spelling::of(name).filter(|it| it.slot.kind == Kind::Falloff2);
                let Some(Part::Parameter(index)) = spelling.map(|it| it.part) else { return false };
                Kind::Falloff2.parameters()[index] == *parameter
            };
            if !node.attributes().any(|attribute| says(attribute.name())) {
                *value = ABOVE;
            }
        }
    }
}

/// Moves variations to the stages that their `_fx_priority` says, once all are known; one that is applied twice becomes
/// two. What moves none is kept as it is.
fn apply_priorities(xform: &mut Xform) {
    let of_slot = |(name, value): &(String, String)| match Spelling::of(name) {
        Some(Spelling { slot, part: Part::Priority }) => Some((slot, stages_of(slot, value)?)),
        _ => None,
    };
    let moves: HashMap<Slot, (Stage, Option<Stage>)> = xform.extra.iter().filter_map(of_slot).collect();
    let mut moved = HashSet::new();
    // In the order of the variations, which writing keeps: two of a kind keep their order.
    let mut at = 0;
    while at < xform.variations.len() {
        let slot = xform.variations[at].slot();
        if let Some(&(first, second)) = moves.get(&slot)
            && let Some(number) = number_of(xform, slot.kind, first)
        {
            let again = second.and_then(|stage| Some((stage, number_of(xform, slot.kind, stage)?)));
            (xform.variations[at].stage, xform.variations[at].number) = (first, number);
            if let Some((stage, number)) = again {
                at += 1;
                xform.variations.insert(at, Variation { stage, number, ..xform.variations[at - 1] });
            }
            moved.insert(slot);
        }
        at += 1;
    }
    let is_kept = |it: &(String, String)| of_slot(it).is_none_or(|(slot, _)| !moved.contains(&slot));
    xform.extra.retain(is_kept);
}

/// The number of one more variation of `kind` in `stage`.
fn number_of(xform: &Xform, kind: Kind, stage: Stage) -> Option<u8> {
    let of_stage = |other: &&Variation| (other.kind, other.stage) == (kind, stage);
    u8::try_from(xform.variations.iter().filter(of_stage).count()).ok()
}

/// The stages to which a priority of `value` moves the variation in `slot`, if it moves it.
fn stages_of(slot: Slot, value: &str) -> Option<(Stage, Option<Stage>)> {
    let stages = Spelling::stages_of_priority(slot, value.trim().parse().ok()?)?;
    Some(stages).filter(|stages| *stages != (slot.stage, None))
}

/// Applies attributes of JWildfire that choose among ways of drawing, and forgets them: which formula of `elliptic`, whose
/// precise mode differs in nothing that is seen, and whether colours change.
fn apply_choices(xform: &mut Xform) {
    let Xform { variations, extra, color_speed, .. } = xform;
    for variation in variations.iter_mut().filter(|variation| variation.kind == Kind::Elliptic) {
        let name = variation.parameter_attribute("mode");
        let Some(at) = extra.iter().position(|(known, _)| *known == name) else { continue };
        match list::<f64>(&extra[at].1).as_deref() {
            Some([1.0]) => variation.kind = Kind::EllipticMirrored,
            Some([0.0 | 2.0]) => {}
            _ => continue,
        }
        extra.remove(at);
    }
    let before = extra.len();
    extra.retain(|(name, value)| name != "color_type" || value != "NONE");
    if extra.len() < before {
        *color_speed = 0.0;
    }
}

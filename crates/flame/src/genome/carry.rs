//! How much of a point's z the formulas of the plane carry.
//!
//! Owns the usual share, by the program that wrote a genome: none in flam3 and Apophysis, that of some formulas in
//! Fractorium, that of one in JWildfire, that of all there with `preserve_z`; and the attributes that say another one.
//! Never draws.
//!
//! Start at [`Carrier`].

use variations::{Depth, Kind, Part, Spelling};

use super::origin::attribute;
use super::parse::list;
use super::{Genome, Program, Xform};

/// Which formulas of the plane carry z where a transform does not say it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Carrier {
    All,
    Fractoriums,
    JWildfires,
    None,
}

impl Carrier {
    /// In `genome`.
    pub(super) fn of(genome: &Genome) -> Carrier {
        let preserved = attribute(&genome.extra, "preserve_z").and_then(list::<f64>);
        if preserved.is_some_and(|values| values.iter().any(|value| *value != 0.0)) {
            Carrier::All
        } else {
            match genome.program() {
                Some(Program::Fractorium) => Carrier::Fractoriums,
                Some(Program::JWildfire) => Carrier::JWildfires,
                _ => Carrier::None,
            }
        }
    }

    /// How much of its z `kind` carries.
    pub(super) fn usual(self, kind: Kind) -> f64 {
        let carries = match self {
            // What comes before the sum has no z of its own there.
            Carrier::All => kind.depth() == Depth::None && kind != Kind::PreBlur,
            Carrier::Fractoriums => kind.carries_z_in_fractorium(),
            // Of 149 in JWildfire's public examples, each seen from the side.
            Carrier::JWildfires => kind == Kind::TileLog,
            Carrier::None => false,
        };
        if carries { 1.0 } else { 0.0 }
    }
}

/// Has each variation of `xform` carry what is usual, or what its attribute says, which is taken out.
pub(super) fn settle(xform: &mut Xform, carrier: Carrier) {
    for variation in &mut xform.variations {
        variation.carry = carrier.usual(variation.kind);
    }
    let mut extra = std::mem::take(&mut xform.extra);
    extra.retain(|(name, value)| !says(xform, name, value));
    xform.extra = extra;
}

/// Whether the attribute said how much a variation of `xform` carries.
fn says(xform: &mut Xform, name: &str, value: &str) -> bool {
    let Some(Spelling { slot, part: Part::Carry }) = Spelling::of(name) else { return false };
    let Some(Ok([carry])) = list::<f64>(value).map(<[f64; 1]>::try_from) else { return false };
    let Some(variation) = xform.variations.iter_mut().find(|variation| variation.slot() == slot) else { return false };
    variation.carry = carry;
    true
}

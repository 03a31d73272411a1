//! When a variation is applied.
//!
//! Owns the order inside a transform: the affine part; what comes before, one by one; the sum; what comes after, one by
//! one; the affine part after the variations. `render` keeps that order.
//!
//! Start at [`Stage`].

use super::{Kind, Variation};

/// When a variation is applied, and whether its result is added or replaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stage {
    /// Before the sum: its result replaces the point. `pre_X`.
    Before,
    /// Before the sum: its result is added to the point. JWildfire's priority -1, and `pre_X` of what ignores its point.
    AddedBefore,
    /// In the sum.
    #[default]
    Sum,
    /// In the sum, at its place: its result replaces the sum so far. JWildfire's priority 0 of `post_X`.
    Running,
    /// After the sum, which its result replaces. `post_X`.
    After,
    /// After the sum, to which its result is added. JWildfire's priority 1, and `post_X` of what ignores its point.
    AddedAfter,
    /// Never. JWildfire's priority 0 of `pre_X`.
    Never,
}

/// The place of a variation among those of a transform.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Slot {
    /// When it is applied.
    pub stage: Stage,
    /// Which formula.
    pub kind: Kind,
    /// Which of several of its kind and stage, from 0.
    pub number: u8,
}

impl Stage {
    /// Whether the result replaces what it is applied to.
    pub fn replaces(self) -> bool {
        matches!(self, Stage::Before | Stage::Running | Stage::After)
    }
}

/// Variations that a weight of 0 does not take out: it is the angle of some, and others have a part or a colour without it.
const WEIGHTLESS: [Kind; 17] = [
    Kind::AxisSymmetryWf,
    Kind::Circlize,
    Kind::DcLinear,
    Kind::Falloff2,
    Kind::Falloff3,
    Kind::FractJuliaWf,
    Kind::Gaussian,
    Kind::Kaleidoscope,
    Kind::PointSymmetryWf,
    Kind::RotateX,
    Kind::RotateY,
    Kind::RotateZ,
    Kind::Stwin,
    Kind::Target,
    Kind::TargetSp,
    Kind::Taurus,
    Kind::Truchet,
];

impl Slot {
    /// Whether a variation here comes from nothing by its presence; else by its weight.
    pub fn comes_by_presence(self) -> bool {
        self.stage.replaces() || WEIGHTLESS.contains(&self.kind)
    }

    /// A variation in this place that changes nothing.
    pub fn absent(self) -> Variation {
        let presence = if self.comes_by_presence() { 0.0 } else { 1.0 };
        Variation { stage: self.stage, number: self.number, presence, ..Variation::new(self.kind, 0.0) }
    }
}

//! Which formulas of the plane carry a point's z.
//!
//! Owns the list for Fractorium. Never says whether a flame has a z: `flame` does.
//!
//! Start at [`Kind::carries_z_in_fractorium`].
//!
//! # Source
//! Pictures of Fractorium's renderer: a flame of one variation behind a transform that spreads z, seen by a camera that is
//! pitched, and the same flame without that z. The pictures differ (10 to 28 dB, others 35 dB and more) where z is carried.

use super::Kind;

/// Those whose z is that of the point, times the weight; the others of the plane give 0.
const CARRYING: [Kind; 43] = [
    Kind::Auger,
    Kind::Bipolar,
    Kind::Blur,
    Kind::BlurCircle,
    Kind::BlurZoom,
    Kind::Bwraps,
    Kind::Circlecrop,
    Kind::Crop,
    Kind::Cross,
    Kind::Disc,
    Kind::Escher,
    Kind::Eyefish,
    Kind::Fan2,
    Kind::Flux,
    Kind::Foci,
    Kind::GaussianBlur,
    Kind::Horseshoe,
    Kind::Hyperbolic,
    Kind::Julian,
    Kind::Juliascope,
    Kind::Lazysusan,
    Kind::Linear,
    Kind::Log,
    Kind::Loonie,
    Kind::Mobius,
    Kind::Ngon,
    Kind::Noise,
    Kind::Pdj,
    Kind::Polar,
    Kind::Polar2,
    Kind::RadialBlur,
    Kind::Rectangles,
    Kind::Rings2,
    Kind::Separation,
    Kind::Shredlin,
    Kind::Sinusoidal,
    Kind::Spherical,
    Kind::Spiral,
    Kind::Splits,
    Kind::Square,
    Kind::Swirl,
    Kind::Waves2,
    Kind::Wedge,
];

impl Kind {
    /// Whether Fractorium gives the point's z, times the weight, with this formula of the plane.
    pub fn carries_z_in_fractorium(self) -> bool {
        CARRYING.contains(&self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Depth, Variation};

    #[test]
    fn only_formulas_of_the_plane_carry_z() {
        assert!(CARRYING.iter().all(|kind| kind.depth() == Depth::None));
        let carrying = Variation { carry: 1.0, ..Variation::new(Kind::Linear, 0.25) };
        assert_eq!((carrying.carried(), carrying.depth_factor()), (0.25, Some(0.25)));
        let flat = Variation { carry: 0.0, ..carrying };
        assert_eq!((flat.carried(), flat.depth_factor()), (0.0, Some(1.0)));
        let half = Variation { presence: 0.5, ..carrying };
        assert_eq!((half.carried(), half.depth_factor()), (0.125, Some(0.625)));
        let solid = Variation { kind: Kind::Hemisphere, ..carrying };
        assert_eq!((solid.carried(), solid.depth_factor()), (0.0, None));
    }
}

//! `<symmetry kind>`: the transforms that make a flame symmetric.
//!
//! Owns their construction. Never draws them: they are transforms like any other.
//!
//! Start at [`Genome::with_symmetry`].

use std::f64::consts::TAU;

use super::{Affine, Genome, Xform};
use crate::variations::{Kind, Variation};

impl Genome {
    /// How many transforms a flame may have to be rendered, those of its symmetries included.
    pub const MAX_XFORMS: usize = 256;

    /// The same flame with its symmetries written out as transforms.
    ///
    /// `n >= 2` adds the rotations by 360 k/n degrees, `n < 0` a reflection in the vertical axis and the
    /// rotations of `-n`; 0 and 1 add nothing. The added ones have weight 1, keep colours and never turn. One more than
    /// [`Genome::MAX_XFORMS`] is as many as it adds: what is beyond cannot be rendered anyway.
    #[must_use]
    pub fn with_symmetry(&self) -> Genome {
        let mut written = self.clone();
        for kind in std::mem::take(&mut written.symmetries) {
            if kind < 0 {
                written.xforms.push(still(Affine { a: -1.0, ..Affine::IDENTITY }));
            }
            let order = kind.unsigned_abs();
            for k in 1..order {
                if written.xforms.len() > Genome::MAX_XFORMS {
                    return written;
                }
                written.xforms.push(still(Affine::IDENTITY.turned(TAU * f64::from(k) / f64::from(order))));
            }
        }
        written
    }
}

/// A transform of weight 1 that moves points by `affine` and leaves their colour.
fn still(affine: Affine) -> Xform {
    Xform {
        weight: 1.0,
        color_speed: 0.0,
        animate: 0.0,
        affine,
        variations: vec![Variation::new(Kind::Linear, 1.0)],
        ..Xform::default()
    }
}

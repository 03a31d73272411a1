//! `<symmetry kind>`: the transforms that make a flame symmetric.
//!
//! Owns their construction. Never draws them: they are transforms like any other.
//!
//! Start at [`Genome::with_symmetry`].

use std::f64::consts::TAU;

use super::{Affine, Genome, Xform};
use variations::{Kind, Variation};

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

/// By how much the numbers of a written-out symmetry may be rounded.
const ROUNDED: f64 = 1e-4;

impl Genome {
    /// The same flame with transforms at its end that make a symmetry as flam3 writes them said as a `<symmetry kind>`:
    /// what [`Genome::with_symmetry`] writes out, but for rounding. Unchanged if it has none, or says one already.
    #[must_use]
    pub fn with_symmetry_said(&self) -> Genome {
        let still = self.xforms.iter().rev().take_while(|xform| is_still(xform)).count();
        for count in (1..=still).rev() {
            let (others, last) = self.xforms.split_at(self.xforms.len() - count);
            let kinds = [count as i32 + 1, -(count as i32)];
            let said = kinds.into_iter().find(|kind| {
                let alone = Genome { symmetries: vec![*kind], ..Genome::default() }.with_symmetry();
                alone.xforms.iter().zip(last).all(|(written, found)| near(&written.affine, &found.affine))
            });
            if let Some(kind) = said.filter(|_| self.symmetries.is_empty() && !others.is_empty()) {
                return Genome { xforms: others.to_vec(), symmetries: vec![kind], ..self.clone() };
            }
        }
        self.clone()
    }
}

/// Whether a transform is one of a symmetry, but for its affine part.
fn is_still(xform: &Xform) -> bool {
    let wanted = still(xform.affine);
    let variations: Vec<&Variation> = xform.variations.iter().filter(|variation| variation.weight != 0.0).collect();
    let is_linear = matches!(variations[..], [only] if *only == wanted.variations[0]);
    is_linear
        && Xform { color: wanted.color, color2: None, variations: wanted.variations.clone(), ..xform.clone() } == wanted
}

fn near(a: &Affine, b: &Affine) -> bool {
    let off = a.plus(b, -1.0);
    [off.a, off.b, off.c, off.d, off.e, off.f].iter().all(|number| number.abs() < ROUNDED)
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

//! The affine parts of a transform in the two other planes of space.
//!
//! Owns their spelling and what they make of a point together with the part in the plane of x and y. Never knows whether a
//! picture has depth: `render` does.
//!
//! Start at [`Tilt`].
//!
//! # Source
//! The order in which `JWildfire` applies its planes: xy, yz, zx, and all translations at last.

use super::parse::{Read, affine};
use super::{Affine, Element};

/// The affine parts in the planes of y and z, and of z and x. The first coordinate of `zx` is x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tilt {
    /// `yzCoefs`, or `yzPost`: y and z by y and z.
    pub yz: Affine,
    /// `zxCoefs`, or `zxPost`: x and z by x and z.
    pub zx: Affine,
}

impl Tilt {
    /// Leaves every point where it is.
    pub const NONE: Tilt = Tilt { yz: Affine::IDENTITY, zx: Affine::IDENTITY };

    /// The one that is `part` of the way from `a` to `b`.
    #[must_use]
    pub fn between(a: &Tilt, b: &Tilt, part: f64) -> Tilt {
        let mix = |from: &Affine, to: &Affine| to.plus(from, 1.0 - part).plus(to, part - 1.0);
        Tilt { yz: mix(&a.yz, &b.yz), zx: mix(&a.zx, &b.zx) }
    }

    /// Three rows of four: what it makes of a point to which `flat` was applied. `None` if it leaves every point where it is.
    pub(crate) fn rows(&self, flat: &Affine) -> Option<[[f64; 4]; 3]> {
        if *self == Tilt::NONE {
            return None;
        }
        let Tilt { yz, zx } = self;
        let linear = [[zx.a, zx.b * yz.d, zx.b * yz.e], [0.0, yz.a, yz.b], [zx.d, zx.e * yz.d, zx.e * yz.e]];
        let moved = [flat.c, flat.f, 0.0];
        let own = [zx.c, yz.c, yz.f + zx.f];
        Some(std::array::from_fn(|axis| {
            let [x, y, z] = linear[axis];
            [x, y, z, moved[axis] + own[axis] - (x * moved[0] + y * moved[1])]
        }))
    }

    pub(super) fn read(&mut self, plane: &str, value: &str) -> Read {
        match plane {
            "yz" => affine(&mut self.yz, value),
            _ => affine(&mut self.zx, value),
        }
    }

    /// Writes what is not neutral, as `yzCoefs` where `stage` is `Coefs`.
    pub(super) fn write(&self, stage: &str, element: &mut Element) {
        for (plane, part) in [("yz", self.yz), ("zx", self.zx)] {
            if part != Affine::IDENTITY {
                element.set_all(&format!("{plane}{stage}"), part.columns());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_follow_each_other_and_translations_come_last() {
        let flat = Affine { a: 0.5, b: -0.3, c: 0.7, d: 0.2, e: 1.1, f: -0.4 };
        let yz = Affine { a: 0.9, b: 0.4, c: 0.3, d: -0.6, e: 0.8, f: -0.2 };
        let zx = Affine { a: 1.2, b: -0.5, c: -0.1, d: 0.3, e: 0.7, f: 0.6 };
        let rows = Tilt { yz, zx }.rows(&flat).unwrap();
        let [x, y, z] = [0.3, -1.4, 0.8];
        let still = |map: Affine| Affine { c: 0.0, f: 0.0, ..map };
        let (px, py) = still(flat).apply(x, y);
        let (py, pz) = still(yz).apply(py, z);
        let (px, pz) = still(zx).apply(px, pz);
        let expected = [px + flat.c + zx.c, py + flat.f + yz.c, pz + yz.f + zx.f];
        let (x, y) = flat.apply(x, y);
        for (row, expected) in rows.iter().zip(expected) {
            let found = row[0] * x + row[1] * y + row[2] * z + row[3];
            assert!((found - expected).abs() < 1e-12, "{found}, not {expected}");
        }
        assert_eq!(Tilt::NONE.rows(&flat), None);
        let middle = Tilt::between(&Tilt::NONE, &Tilt { yz, zx }, 0.25);
        assert!((middle.yz.b - 0.1).abs() < 1e-12 && (middle.zx.a - 1.05).abs() < 1e-12);
    }
}

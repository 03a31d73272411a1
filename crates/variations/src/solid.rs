//! Formulas that give a z.
//!
//! Owns those that change nothing but z, the plain ones of space, and V28 and V29, which are made flat in flam3. The letters are those of `plain.rs`, with the third
//! coordinate `z`.
//!
//! # Source
//! What JWildfire, Fractorium and Apophysis plugins of these names compute, in their authors' descriptions.

use super::chance::bell;
use super::formulas::{over, radius, solids, square_of_radius};

solids! {
    Bubble Makes(v, x, y, _z) {
        let s = over(v.w, square_of_radius(x, y) * 0.25 + 1.0);
        [s * x, s * y, s * 2.0 - v.w]
    }

    Cylinder Makes(v, x, y, _z) {
        let (s, c) = x.sin_cos();
        [s * v.w, y * v.w, c * v.w]
    }

    Linear3D Makes(v, x, y, z) {
        [x * v.w, y * v.w, z * v.w]
    }

    Flatten Makes(_v, x, y, z) {
        [x, y, z.like(0.0)]
    }

    Zscale Makes(v, _x, _y, z) {
        [z.like(0.0), z.like(0.0), z * v.w]
    }

    Ztranslate Makes(v, _x, _y, z) {
        [z.like(0.0), z.like(0.0), z.like(v.w)]
    }

    Zcone Makes(v, x, y, _z) {
        [x.like(0.0), x.like(0.0), radius(x, y) * v.w]
    }

    Zblur Makes(v, _x, _y, z, random) {
        let zero = z.like(0.0);
        [zero, zero, bell(random) * v.w]
    }
}

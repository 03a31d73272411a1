//! Formulas of space that other programs have: the point is (x, y, z).
//!
//! Owns those that read or make z and are not in `solid.rs`. The letters are those of `plain.rs` and `solid.rs`.
//!
//! # Source
//! What `JWildfire`, Fractorium and Apophysis plugins of these names compute, in their authors' descriptions.
//! `Poincare3D` is the hyperbolic translation of Poincaré's ball.

use std::f64::consts::{PI, TAU};

use super::chance::bell;
use super::formulas::{at_angle, over, radius, solids, square_of_radius};
use super::roots::{NEAREST, root};
use crate::number::Number;

/// 4/√(3π): a butterfly of it has the area of the unit disc.
const BUTTERFLY: f64 = 1.302_940_031_741_12;

solids! {
    Spherical3D Reads(v, x, y, z) {
        let k = over(v.w, square_in_space(x, y, z) + v.floor);
        [k * x, k * y, k * z]
    }

    Spherical3DWf Reads(v, x, y, z) {
        let k = (square_in_space(x, y, z) + v.floor).pow(x.like(v.p[0])) * (v.p[1] * v.w);
        [k * x, k * y, k * z]
    }

    Hemisphere Makes(v, x, y, _z) {
        let k = over(v.w, (square_of_radius(x, y) + 1.0).sqrt());
        [k * x, k * y, k]
    }

    Julia3D Reads(v, x, y, z, random) {
        let [count, turn, exponent, ..] = v.p;
        let z = z / count;
        let r2 = square_of_radius(x, y);
        let k = (r2 + z * z).max(z.like(NEAREST)).pow(z.like(exponent)) * v.w;
        let (c, s) = at_angle(root(y.atan2(x), count, turn, random), k * r2.sqrt());
        [c, s, k * z]
    }

    Julia3Dz Makes(v, x, y, z, random) {
        let [count, turn, exponent, ..] = v.p;
        let r2 = square_of_radius(x, y).max(z.like(NEAREST));
        let k = r2.pow(z.like(exponent)) * v.w;
        let (c, s) = at_angle(root(y.atan2(x), count, turn, random), k);
        [c, s, k * z / (r2.sqrt() * count)]
    }

    Julian3Dx Reads(v, x, y, z, random) {
        let [count, turn, exponent, a, b, c, d, e, f, ..] = v.p;
        let z = z / count;
        let r2 = square_of_radius(x, y);
        let k = (r2 + z * z).max(z.like(NEAREST)).pow(z.like(exponent)) * v.w;
        let phi = (x * c + y * d + f).atan2(x * a + y * b + e);
        let (c, s) = at_angle(root(phi, count, turn, random), k * r2.sqrt());
        [c, s, k * z]
    }

    Blur3D Makes(v, _x, _y, _z, random) {
        let rho = bell(random) * v.w;
        let (along, around) = (random.unit() * PI, random.unit() * TAU);
        let (s, c) = along.sin_cos();
        let (x, y) = at_angle(around, rho * s);
        [x, y, rho * c]
    }

    Curl3D Reads(v, x, y, z) {
        let [cx, cy, cz, square, ..] = v.p;
        let r2 = square_in_space(x, y, z);
        let k = over(v.w, r2 * square + (x * cx - y * cy + z * cz) * 2.0 + 1.0);
        [k * (x + r2 * cx), k * (y - r2 * cy), k * (z + r2 * cz)]
    }

    Blob3D Makes(v, x, y, _z) {
        let [low, span, waves, ..] = v.p;
        let wave = (x.atan2(y) * waves).sin();
        let k = ((wave * 0.5 + 0.5) * span + low) * v.w;
        [k * x, k * y, k * radius(x, y) * wave]
    }

    LinearT3D Makes(v, x, y, z) {
        [bent(x, v.p[0]) * v.w, bent(y, v.p[1]) * v.w, bent(z, v.p[2]) * v.w]
    }

    Poincare3D Reads(v, x, y, z) {
        let [cx, cy, cz, square, ..] = v.p;
        let (r2, along) = (square_in_space(x, y, z), x * cx + y * cy + z * cz);
        let k = over(v.w, r2 * square - along * 2.0 + 1.0);
        // What multiplies the centre, where each coordinate's own part of `along` is taken out again.
        let pull = along * 2.0 - r2 - 1.0;
        let part = |value: N, centre: f64| {
            let own = 1.0 + 2.0 * centre * centre - square;
            k * (value * own + (pull - value * (2.0 * centre)) * centre)
        };
        [part(x, cx), part(y, cy), part(z, cz)]
    }

    Bubble2 Reads(v, x, y, z) {
        let t = over(v.w, square_in_space(x, y, z) * 0.25 + 1.0);
        let lift = z.like(v.p[2]);
        let lift = N::select(z.less(z.like(0.0)), -lift, lift);
        [x * v.p[0] * t, y * v.p[1] * t, (z + lift) * v.w + z * v.p[2] * t]
    }

    RotateX Reads(v, x, y, z) {
        let [sin, cos, ..] = v.p;
        [x, y * cos + z * sin, z * cos - y * sin]
    }

    RotateZ Makes(v, x, y, z) {
        let [sin, cos, ..] = v.p;
        [x * cos + y * sin, y * cos - x * sin, z]
    }

    RotateY Reads(v, x, y, z) {
        let [sin, cos, ..] = v.p;
        [x * cos - z * sin, y, x * sin + z * cos]
    }

    Waves2In3D Makes(v, x, y, z) {
        let [frequency, scale, ..] = v.p;
        let waved = |value: N, along: N| (value + (along * frequency).sin() * scale) * v.w;
        [waved(x, y), waved(y, x), waved(z, (x + y) * 0.5)]
    }

    Affine3D Reads(v, x, y, z) {
        let row = |at: usize| (x * v.p[at] + y * v.p[at + 1] + z * v.p[at + 2] + v.p[at + 3]) * v.w;
        [row(0), row(4), row(8)]
    }

    Butterfly3D Makes(v, x, y, _z) {
        let square = (x * x + y * y * 4.0).max(x.like(NEAREST));
        let k = ((x * y).abs() / square).sqrt() * (BUTTERFLY * v.w);
        [k * x, k * y * 2.0, k * y.abs() * radius(x, y) * 0.5]
    }

    Ennepers2 Makes(v, x, y, _z) {
        let [a, b, c, ..] = v.p;
        let r2 = square_of_radius(x, y).max(x.like(NEAREST));
        let slope = x * x * (a * a) - y * y * (b * b);
        let part = |value: N, square: f64| value * (-(slope / r2) - value.abs().sqrt() * c + square) * v.w;
        [part(x, a * a), part(y, b * b), slope / r2.sqrt() * (0.5 * v.w)]
    }

    Sph3D Reads(v, x, y, z) {
        let [across, along, ..] = v.p;
        // Its author scales z as x.
        let k = over(v.w, square_in_space(x * across, y * along, z * across).max(x.like(NEAREST)));
        [k * x, k * y, k * z]
    }

    Tanhq Reads(v, x, y, z) {
        let side2 = square_of_radius(y, z).max(x.like(NEAREST));
        let side = side2.sqrt();
        let ((s, c), (sinh, cosh)) = (side.sin_cos(), x.sinh_cosh());
        let k = over(v.w, x * x + side2);
        let around = k * s * c / side;
        [k * sinh * cosh, around * y, around * z]
    }

    Taurus Makes(v, x, y, _z) {
        let [size, count, even, flat, ..] = v.p;
        let ((s, c), (sin, cos)) = (x.sin_cos(), y.sin_cos());
        let far = ((x * count).cos() * ((1.0 - even) * size) + even * size + sin) * v.w;
        [c * far, s * far, cos * (v.w * flat) + y * (1.0 - flat)]
    }

    WhitneyUmbrella Makes(v, x, y, _z) {
        [x * y * v.w, x * v.w, y * y * v.w]
    }

    Seashell3D Makes(v, _x, _y, _z, random) {
        let [size, height, inner, spirals, ..] = v.p;
        let (wound, around) = (random.unit(), random.unit() * TAU);
        let rim = -(wound - 1.0) * size;
        let (sin, cos) = around.sin_cos();
        let (x, y) = at_angle(wound * (spirals * TAU), (rim * (cos + 1.0) + inner) * v.w);
        [x, y, (wound * height + rim * sin) * v.w]
    }

    Cone Makes(v, x, y, _z, random) {
        let [radius1, radius2, size1, size2, y_wave, x_wave, height, warp, count, ..] = v.p;
        let far = over(v.w * size2, (x * x * warp + y * y + size1).sqrt());
        let angle = x.atan2(y) * radius1 + (random.unit() * count).trunc() * (PI * radius2);
        [(angle * x_wave).cos() * far, (angle * y_wave).sin() * far, far * height]
    }

    Hypertile3D Reads(v, x, y, z) {
        let [cx, cy, square, ..] = v.p;
        let r2 = square_in_space(x, y, z) + 1.0;
        let along = x * cx - y * cy;
        let k = over(v.w, r2 * square + along * 2.0 + (1.0 - square));
        let pull = r2 + along * 2.0;
        [k * (x * (1.0 - square) + pull * cx), k * (y * (1.0 - square) - pull * cy), k * z * (1.0 - square)]
    }
}

/// R², the square of the distance from the origin.
#[inline(always)]
pub(super) fn square_in_space<N: Number>(x: N, y: N, z: N) -> N {
    square_of_radius(x, y) + z * z
}

/// The absolute value to a power, with the sign of `value`.
#[inline(always)]
pub(super) fn bent<N: Number>(value: N, exponent: f64) -> N {
    value.abs().pow(value.like(exponent)).copysign(value)
}

//! Vectors in space: x to the right, y up, z towards the viewer.
//!
//! Owns their arithmetic. Pure.
//!
//! Start at [`Vector`].

/// A place or a direction.
pub(crate) type Vector = [f64; 3];

pub(crate) fn added(a: Vector, b: Vector, times: f64) -> Vector {
    [a[0] + b[0] * times, a[1] + b[1] * times, a[2] + b[2] * times]
}

pub(crate) fn scaled(a: Vector, times: f64) -> Vector {
    a.map(|part| part * times)
}

pub(crate) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The direction of `a`; `otherwise` if it has none.
pub(crate) fn unit(a: Vector, otherwise: Vector) -> Vector {
    let length = dot(a, a).sqrt();
    if length > 1e-9 { scaled(a, 1.0 / length) } else { otherwise }
}

/// The part of `a` across the direction `along`, with length 1.
pub(crate) fn across(a: Vector, along: Vector, otherwise: Vector) -> Vector {
    unit(added(a, along, -dot(a, along)), otherwise)
}

/// `a` turned in the plane of the picture by an angle with this sine and cosine.
pub(crate) fn turned(a: Vector, [sine, cosine]: [f64; 2]) -> Vector {
    [a[0] * cosine - a[1] * sine, a[0] * sine + a[1] * cosine, a[2]]
}

/// 0 up to 0, 1 from 1 on, without a bend between them.
pub(crate) fn smooth(part: f64) -> f64 {
    let part = part.clamp(0.0, 1.0);
    part * part * (3.0 - 2.0 * part)
}

/// From `a` to `b`; at 0 and 1 exactly these.
pub(crate) fn between(a: f64, b: f64, part: f64) -> f64 {
    if part == 1.0 { b } else { a + (b - a) * part }
}

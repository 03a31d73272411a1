//! Formulas of other programs that divide the plane into cells, bars or sectors.
//!
//! Owns what they do with the parts: shift, twist, narrow, mirror. The letters are those of `plain.rs`.
//!
//! # Source
//! What `JWildfire`, Fractorium and Apophysis plugins of these names compute, in their authors' descriptions.

use std::f64::consts::{PI, TAU};

use super::formulas::{TINY, formulas, over, square_of_radius};
use super::roots::NEAREST;
use crate::number::Number;

formulas! {
    Bwraps(v, x, y) {
        let [size, square, stretch, flatness, inner, outer, ..] = v.p;
        in_circles([x, y], size, square, v.w, |off_x, off_y, off2| {
            let k = over(stretch, off2 * flatness + 1.0);
            let t = off2 * k * k / square;
            turned(off_x * k, off_y * k, t * (outer - inner) + inner)
        })
    }

    Boarders2(v, x, y, random) {
        let [kept, push, chance, ..] = v.p;
        let (middle_x, middle_y) = (x.round(), y.round());
        let (off_x, off_y) = (x - middle_x, y - middle_y);
        let longest = off_x.abs().max(off_y.abs()).max(x.like(TINY));
        let unit = random.unit();
        let moved = N::select(unit.less(unit.like(chance)), over(push, longest), unit.like(0.0)) + kept;
        ((moved * off_x + middle_x) * v.w, (moved * off_y + middle_y) * v.w)
    }

    TileLog(v, x, y, random) {
        // Never the logarithm of 0.
        let far = (-(random.unit() - 1.0)).ln() * v.p[0];
        let far = N::select(random.coin(), far, -far);
        ((x + far.round()) * v.w, y * v.w)
    }

    TileHlp(v, x, y, random) {
        let width = v.p[0];
        let cells = x / width;
        let part = cells - cells.trunc();
        let is_moved = (part * PI).cos().less(random.unit() * 2.0 - 1.0);
        let zero = x.like(0.0);
        let step = N::select(zero.less(cells), x.like(-width), x.like(width));
        ((x + N::select(is_moved, step, zero)) * v.w, y * v.w)
    }

    Shredlin(v, x, y) {
        (shred(x, v.p[0], v.p[1]) * v.w, shred(y, v.p[2], v.p[3]) * v.w)
    }

    PointSymmetryWf(v, x, y, random) {
        let [centre_x, centre_y, order, ..] = v.p;
        let (off_x, off_y) = ((x - centre_x) * v.w, (y - centre_y) * v.w);
        let (s, c) = ((random.unit() * order).trunc() * (TAU / order)).sin_cos();
        (off_x * c + off_y * s + centre_x, off_y * c - off_x * s + centre_y)
    }

    Kaleidoscope(v, x, y) {
        let [cos, sin, across, above, below, ..] = v.p;
        let shift = N::select(x.like(0.0).less(y), x.like(above), x.like(below));
        (x * cos - y * sin + across, y * cos + x * sin + shift)
    }

    Gnarly(v, x, y) {
        let [size, twist, square, ..] = v.p;
        in_circles([x, y], size, square, v.w, |off_x, off_y, off2| {
            turned(off_x, off_y, (off2 / square).max(off2.like(NEAREST)).ln() * twist)
        })
    }

    Waffle(v, _, _, random) {
        let [slices, across, along, sin, cos, ..] = v.p;
        // Five sets of bars: where in a slice they begin, and how wide they are.
        let bars = [
            [0.0, across, 0.0, along],
            [0.0, 1.0, along, 0.0],
            [across, 0.0, 0.0, 1.0],
            [0.0, 1.0, along, 1.0 - along],
            [across, 1.0 - across, 0.0, 1.0],
        ];
        let which = random.unit() * 5.0;
        let of = |part: usize| {
            let first = which.like(bars[0][part]);
            (1..5).fold(first, |so_far, bar| {
                N::select(which.less(which.like(bar as f64)), so_far, which.like(bars[bar][part]))
            })
        };
        let mut place = |begin: N, width: N| {
            let slice = (random.unit() * slices).trunc();
            (slice + begin + random.unit() * width) / slices
        };
        let (a, r) = (place(of(0), of(1)), place(of(2), of(3)));
        (a * cos + r * sin, r * cos - a * sin)
    }
}

/// A coordinate whose cells of the length `distance` are narrowed to a share `width` of it.
#[inline(always)]
fn shred<N: Number>(value: N, distance: f64, width: f64) -> N {
    let cells = value / distance;
    let whole = cells.trunc();
    let zero = value.like(0.0);
    let side = N::select(value.less(zero), value.like(-0.5), value.like(0.5));
    ((cells - whole) * width + whole + side * (1.0 - width)) * distance
}

/// The point, times `weight`, where in the circle of each cell of the width `size` the offset from its middle, whose square is
/// at most `square`, becomes what `bend` makes of it and of its square.
#[inline(always)]
fn in_circles<N: Number>(
    [x, y]: [N; 2],
    size: f64,
    square: f64,
    weight: f64,
    bend: impl FnOnce(N, N, N) -> (N, N),
) -> (N, N) {
    if size == 0.0 {
        return (x * weight, y * weight);
    }
    let middle = |value: N| ((value / size).floor() + 0.5) * size;
    let (middle_x, middle_y) = (middle(x), middle(y));
    let (off_x, off_y) = (x - middle_x, y - middle_y);
    let off2 = square_of_radius(off_x, off_y);
    let (bent_x, bent_y) = bend(off_x, off_y, off2);
    let is_outside = off2.like(square).less(off2);
    (N::select(is_outside, x, middle_x + bent_x) * weight, N::select(is_outside, y, middle_y + bent_y) * weight)
}

/// A point, turned clockwise.
#[inline(always)]
fn turned<N: Number>(x: N, y: N, angle: N) -> (N, N) {
    let (s, c) = angle.sin_cos();
    (x * c + y * s, y * c - x * s)
}

//! Formulas of other programs that divide the plane into cells, bars or sectors.
//!
//! Owns what they do with the parts: shift, twist, narrow, mirror. The letters are those of `plain.rs`.
//!
//! # Source
//! What `JWildfire`, Fractorium and Apophysis plugins of these names compute, in their authors' descriptions.

use std::f64::consts::PI;

use super::MAX_PARAMETERS;
use super::formulas::{TINY, at_angle, formulas, over, square_of_radius, values};
use super::roots::NEAREST;
use crate::Compiled;
use crate::number::{Number, Random};

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

    Truchet(v, x, y) {
        let [scale, norm, width, size, ..] = v.p;
        let part = |value: N| value * scale - (value * scale + 0.5).floor();
        let wrapped = |part: N| N::select(part.less(part.like(0.0)), part + 1.0, part);
        let (part_x, part_y) = (wrapped(part(x)), wrapped(part(y)));
        let is_crossed = is_crossed(v, (x + 0.5).floor(), (y + 0.5).floor());
        let zero = x.like(0.0);
        // An arc about each of two corners that face each other.
        let arc = |corner_x: N, corner_y: N| {
            let far = |off: N| off.abs().pow(off.like(norm));
            let rho = (far(part_x - corner_x) + far(part_y - corner_y)).pow(x.like(1.0 / norm));
            N::select((rho - 0.5).abs().less(x.like(width)), x.like(size), zero)
        };
        let corner = N::select(is_crossed, x.like(1.0), zero);
        let arcs = arc(corner, zero) + arc(-(corner - 1.0), x.like(1.0));
        // Where no arc is, nothing is added, however far away the point lies.
        let kept = |value: N| N::select(zero.less(arcs), value * arcs, zero);
        (kept(part_x + x.floor()), kept(part_y + y.floor()))
    }

    Xtrb(v, x, y, random) {
        let [r, sin, cos, count, power, exponent, ..] = v.p;
        let [side_a, side_b, side_c, area] = [v.p[6], v.p[7], v.p[8], v.p[9]];
        let (high_a, high_b) = (area / side_a, area / side_b);
        let (a, b) = (y + r, x * sin - y * cos + r);
        let (row, column) = ((a / high_a).floor() * high_a, (b / high_b).floor() * high_b);
        let (a, b) = (a - row, b - column);
        let c = (-(a * side_a + b * side_b - area)) / side_c;
        // The other half of a parallelogram.
        let is_upper = !x.like(0.0).less(c);
        let turned = |value: N, high: f64| N::select(is_upper, -(value - high), value);
        let (a, b) = in_hexagon(v, [turned(a, high_a), turned(b, high_b), c.abs()], random);
        let (a, b) = (turned(a, high_a) + row - r, turned(b, high_b) + column - r);
        let x = (b + a * cos) / sin;
        let angle = (a.atan2(x) + (random.unit() * count).trunc() * (2.0 * PI)) / power;
        // The weight counts twice.
        at_angle(angle, square_of_radius(x, a).max(x.like(NEAREST)).pow(x.like(exponent)) * (v.w * v.w))
    }
}

/// What `truchet` reads, of its weight and its parameters: those of its hash last.
pub(super) fn truchet_values(weight: f64, q: &[f64; MAX_PARAMETERS]) -> [f64; MAX_PARAMETERS] {
    let norm = q[1].clamp(0.001, 2.0);
    let width = (libm::exp2(1.0 / norm) - 1.0) * q[2].clamp(0.001, 1.0) / 2.0;
    let scale = (libm::cos(q[3]) + libm::sin(q[3])) / weight;
    let seed = q[5].abs();
    let hash = if seed == 0.0 || seed == 1.0 {
        [seed, 0.0, 0.0]
    } else {
        let g = (1.5 * seed).sqrt() / (0.5 * seed) * 0.25;
        let k = g * 0.5 * 32_747.0;
        [seed * k + 12_345.0, k * g, k * g * g]
    };
    values([scale, norm, width, q[4].clamp(0.001, 10.0), hash[0], hash[1], hash[2]])
}

/// What `xtrb` reads: the sides of its triangles and the area of one, twice.
pub(super) fn xtrb_values(q: &[f64; MAX_PARAMETERS]) -> [f64; MAX_PARAMETERS] {
    let power = q[0].round();
    let (b, c) = (0.047 + q[4], 0.047 + q[5]);
    let [half_a, half_b, half_c] = [PI - b - c, b, c].map(|angle| libm::tan(angle / 2.0));
    let sides = [half_b + half_c, half_a + half_c, half_a + half_b].map(|side| side * q[1]);
    let area = q[1] * sides.iter().sum::<f64>();
    let (sin, cos) = libm::sincos(c);
    let [side_a, side_b, side_c] = sides;
    let (exponent, share) = (q[3] / power / 2.0, 1.0 - q[2] * q[2]);
    values([q[1], sin, cos, power.abs(), power, exponent, side_a, side_b, side_c, area, q[2], share])
}

/// Whether the arcs of a truchet tile are about the corners at the lower right and the upper left.
///
/// A hash, h = ((s + (i + j) g + i j g²) k + 12345) modulo 65535, is in the upper half of its last two units. Each part is
/// first taken modulo 2, so that `f32` has room for the rest.
#[inline(always)]
fn is_crossed<N: Number>(v: &Compiled, i: N, j: N) -> N::Mask {
    let [first, sum, product] = [v.p[4], v.p[5], v.p[6]];
    if product == 0.0 {
        return N::less(i.like(0.5), i.like(first));
    }
    let (both, square) = (i + j, i * j);
    let hash = both * sum + square * product + first;
    // 65535 is odd: each turn changes halves.
    let fine = both * (sum % 2.0) + square * (product % 2.0) + first % 2.0 + (hash / 65_535.0).trunc();
    let parity = fine - (fine * 0.5).floor() * 2.0;
    let one = i.like(1.0);
    !parity.less(one) & !hash.less(i.like(0.0))
}

/// The trilinear coordinates of a point in a triangle, moved to a hexagon in its middle or to one of its corners: those of the
/// first two sides.
#[inline(always)]
fn in_hexagon<N: Number, R: Random<N>>(v: &Compiled, [a, b, c]: [N; 3], random: &mut R) -> (N, N) {
    let [sides @ .., area] = [v.p[6], v.p[7], v.p[8], v.p[9]];
    let [width, share] = [v.p[10], v.p[11]];
    let (b_is_above_a, c_is_above_a, c_is_above_b) = (a.less(b), a.less(c), b.less(c));
    let (a_is_most, b_is_most) = (!b_is_above_a & !c_is_above_a, b_is_above_a & !c_is_above_b);
    let (a_is_least, b_is_least) = (b_is_above_a & c_is_above_a, !b_is_above_a & c_is_above_b);
    let of = |is_a: N::Mask, is_b: N::Mask| {
        let [of_a, of_b, of_c] = sides.map(|side| a.like(side));
        N::select(is_a, of_a, N::select(is_b, of_b, of_c))
    };
    let (most, least) = (of(a_is_most, b_is_most), of(a_is_least, b_is_least));
    let between = -(most + least - (sides[0] + sides[1] + sides[2]));
    let lower = a.min(b).min(c);
    let middle = a.min(b).max(a.max(b).min(c));
    let ratio = lower / middle.max(a.like(TINY));
    let is_inner = random.unit().less(a.like(share));
    let inner_low = lower * (1.0 - width) + over(area * width / 3.0, least) * ratio;
    let inner_middle = middle * (1.0 - width) + over(area * width / 3.0, most + between) * -(ratio - 3.0);
    let lower = N::select(is_inner, inner_low, lower * width);
    let middle = N::select(is_inner, inner_middle, middle * width);
    let upper = -(least * lower + between * middle - area) / most;
    let placed = |is_most, is_least| N::select(is_most, upper, N::select(is_least, lower, middle));
    (placed(a_is_most, a_is_least), placed(b_is_most, b_is_least))
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

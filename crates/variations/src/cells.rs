//! Formulas that draw cells around sites that a hash puts in place.
//!
//! Owns the noise that moves sites: its own, for that of the programs is a table of numbers that cannot be read off their
//! pictures. Cells are of the same size and as irregular, but lie elsewhere. The letters are those of `plain.rs`.
//!
//! # Source
//! `Crackle`: what Apophysis' plugin and `JWildfire` compute where nothing is distorted, by the number. The hash is the
//! permutation polynomial (34 x + 1) x modulo 289 of Gustavson and `McEwan`, *Efficient computational noise in GLSL* (2012):
//! exact in `f32`.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::MAX_PARAMETERS;
use super::formulas::{TINY, formulas, values};
use crate::number::Number;

/// How many different cells there are.
const CELLS: f64 = 289.0;

/// The length of the interval of shifts whose standard deviation is that of simplex noise at such points, 0.3.
const SPREAD: f64 = 1.04;

formulas! {
    Crackle(v, _, _, random) {
        let [size, power, distort, scale, layer, share, next_share, ..] = v.p;
        let far = (random.unit() + random.unit()) * 0.5 + (random.unit() - 0.5) * 0.25;
        let (sin, cos) = (random.unit() * TAU).sin_cos();
        let (x, y) = (far * sin, far * cos);
        if size == 0.0 {
            return (x.like(0.0), x.like(0.0));
        }
        let site = |i: N, j: N| {
            let (shift_x, shift_y) = shift(i, j, layer);
            if next_share == 0.0 {
                return ((shift_x * distort + i) * size, (shift_y * distort + j) * size);
            }
            let (next_x, next_y) = shift(i, j, layer + 1.0);
            let mixed = |now: N, next: N| (now * share + next * next_share) * distort;
            ((mixed(shift_x, next_x) + i) * size, (mixed(shift_y, next_y) + j) * size)
        };
        let (own_x, own_y, i, j) = nearest((x, y), ((x / size).floor(), (y / size).floor()), site);
        let (off_x, off_y) = (x - own_x, y - own_y);
        // 0 at the site, 1 half-way to the next one.
        let mut edge = x.like(TINY);
        for (across, up) in AROUND {
            let (other_x, other_y) = site(i + across, j + up);
            let (to_x, to_y) = (other_x - own_x, other_y - own_y);
            edge = edge.max((off_x * to_x + off_y * to_y) * 2.0 / (to_x * to_x + to_y * to_y));
        }
        let k = edge.pow(x.like(power - 1.0)) * scale;
        ((k * off_x + own_x) * v.w, (k * off_y + own_y) * v.w)
    }
}

/// What `crackle` reads: its layers of noise are 0.4 of its `z` apart, and the two about it are mixed.
pub(super) fn crackle_values(q: &[f64; MAX_PARAMETERS]) -> [f64; MAX_PARAMETERS] {
    let layer = 2.5 * q[4];
    let below = layer.floor();
    let (next_share, share) = libm::sincos((layer - below) * FRAC_PI_2);
    values([q[0] / 2.0, q[1], q[2], q[3], below, share, next_share])
}

/// The neighbours of a cell.
const AROUND: [(f64, f64); 8] =
    [(-1.0, -1.0), (0.0, -1.0), (1.0, -1.0), (-1.0, 0.0), (1.0, 0.0), (-1.0, 1.0), (0.0, 1.0), (1.0, 1.0)];

/// The nearest of the sites of a cell and of its neighbours, and its cell.
#[inline(always)]
fn nearest<N: Number>((x, y): (N, N), (i, j): (N, N), site: impl Fn(N, N) -> (N, N)) -> (N, N, N, N) {
    let square = |(to_x, to_y): (N, N)| (to_x - x) * (to_x - x) + (to_y - y) * (to_y - y);
    let own = site(i, j);
    let (mut found, mut least) = ((own.0, own.1, i, j), square(own));
    for (across, up) in AROUND {
        let (other_i, other_j) = (i + across, j + up);
        let other = site(other_i, other_j);
        let far = square(other);
        let is_nearer = far.less(least);
        found = (
            N::select(is_nearer, other.0, found.0),
            N::select(is_nearer, other.1, found.1),
            N::select(is_nearer, other_i, found.2),
            N::select(is_nearer, other_j, found.3),
        );
        least = far.min(least);
    }
    found
}

/// How far the site of a cell is moved in a layer, in cells.
#[inline(always)]
fn shift<N: Number>(i: N, j: N, layer: f64) -> (N, N) {
    let first = mixed(modulo(i) + (layer - (layer / CELLS).floor() * CELLS));
    let across = mixed(mixed(first + modulo(j)) + 1.0);
    let up = mixed(across + 1.0);
    let shift = |hash: N| (hash / (CELLS - 1.0) - 0.5) * SPREAD;
    (shift(across), shift(up))
}

/// A permutation of whole numbers below [`CELLS`], of ones up to twice that.
#[inline(always)]
fn mixed<N: Number>(number: N) -> N {
    modulo((number * 34.0 + 1.0) * number)
}

#[inline(always)]
fn modulo<N: Number>(number: N) -> N {
    number - (number / CELLS).floor() * CELLS
}

//! Interpolation from one affine part to another, while both turn.
//!
//! Owns the angles: how many whole turns a transition makes, and its speed at every moment. Weights and variations are
//! in `transition.rs`.
//!
//! Start at [`AffinePath`].
//!
//! # Source
//! Lengths and angles of the columns as in flam3; the speeds at both ends are those of the loops, by a cubic
//! Hermite curve in the angle, with the whole turns that come nearest to the mean speed.

use std::f64::consts::{PI, TAU};

use super::transition::{Moment, mix};
use crate::genome::Affine;

/// Lengths below this are interpolated linearly: their logarithm is too large.
const SHORT: f64 = 4.5e-5;

/// Interpolation from one affine part to another.
#[derive(Clone, Debug)]
pub(crate) enum AffinePath {
    /// By the lengths and angles of the columns.
    Polar(Polar),
    /// Entry by entry, each end turning as in its loop.
    Straight {
        /// Both ends.
        ends: [Affine; 2],
        /// Radians per frame at both ends.
        speeds: [f64; 2],
        /// Frames of the transition.
        frames: f64,
    },
}

/// Interpolation by lengths and angles.
#[derive(Clone, Debug)]
pub(crate) struct Polar {
    /// Lengths of the first and the second column, at both ends.
    lengths: [[f64; 2]; 2],
    /// Angle of the first column at the start, in radians.
    angle: f64,
    /// Its total change.
    travel: f64,
    /// From the first column's angle to the second's: at the start, and what it grows by.
    spread: [f64; 2],
    /// Radians per frame at both ends.
    speeds: [f64; 2],
    /// The translation at both ends.
    offsets: [[f64; 2]; 2],
    /// Frames of the transition.
    frames: f64,
}

impl Polar {
    /// Interpolates from `ends[0]`, turning by `speeds[0]` radians per frame, to `ends[1]`, turning by `speeds[1]`.
    pub(crate) fn new(ends: [Affine; 2], speeds: [f64; 2], frames: f64) -> Polar {
        let lengths = ends.map(|end| [libm::hypot(end.a, end.d), libm::hypot(end.b, end.e)]);
        let angles = |column: usize| {
            let of = |end: usize| match column {
                0 => libm::atan2(ends[end].d, ends[end].a),
                _ => libm::atan2(ends[end].e, ends[end].b),
            };
            // A column of length 0 has no angle: it takes the other end's.
            match [lengths[0][column] > 0.0, lengths[1][column] > 0.0] {
                [true, false] => [of(0), of(0)],
                [false, true] => [of(1), of(1)],
                [true, true] | [false, false] => [of(0), of(1)],
            }
        };
        let (first, second) = (angles(0), angles(1));
        let shortest = first[1] - first[0];
        let due = frames * (speeds[0] + speeds[1]) / 2.0;
        let travel = shortest + TAU * ((due - shortest) / TAU).round();
        let spread = [second[0] - first[0], second[1] - first[1]];
        let growth = (spread[1] - spread[0] + PI).rem_euclid(TAU) - PI;
        let offsets = ends.map(|end| [end.c, end.f]);
        Polar { lengths, angle: first[0], travel, spread: [spread[0], growth], speeds, offsets, frames }
    }

    fn at(&self, moment: Moment) -> Affine {
        let first = self.angle + self.turned(moment);
        let second = first + self.spread[0] + self.spread[1] * moment.eased;
        let length = |column: usize| {
            let [from, to] = [self.lengths[0][column], self.lengths[1][column]];
            if from > SHORT && to > SHORT {
                libm::exp(mix(libm::log(from), libm::log(to), moment.eased))
            } else {
                mix(from, to, moment.eased)
            }
        };
        let offset = |axis: usize| mix(self.offsets[0][axis], self.offsets[1][axis], moment.eased);
        Affine {
            a: length(0) * libm::cos(first),
            d: length(0) * libm::sin(first),
            b: length(1) * libm::cos(second),
            e: length(1) * libm::sin(second),
            c: offset(0),
            f: offset(1),
        }
    }

    /// How far the first column has turned, in radians.
    fn turned(&self, moment: Moment) -> f64 {
        let b = (moment.frame / self.frames).clamp(0.0, 1.0);
        let outside = moment.frame - b * self.frames;
        let leaving = b * (1.0 - b) * (1.0 - b) * self.frames * self.speeds[0];
        let arriving = b * b * (b - 1.0) * self.frames * self.speeds[1];
        let drifting = outside * if outside < 0.0 { self.speeds[0] } else { self.speeds[1] };
        leaving + self.travel * moment.eased + arriving + drifting
    }
}

impl AffinePath {
    /// The affine part at `moment`.
    pub(crate) fn at(&self, moment: Moment) -> Affine {
        match self {
            AffinePath::Polar(polar) => polar.at(moment),
            AffinePath::Straight { ends, speeds, frames } => {
                let from = ends[0].turned(speeds[0] * moment.frame);
                let to = ends[1].turned(speeds[1] * (moment.frame - frames));
                let blend = |entry: fn(&Affine) -> f64| mix(entry(&from), entry(&to), moment.eased);
                Affine {
                    a: blend(|affine| affine.a),
                    b: blend(|affine| affine.b),
                    c: blend(|affine| affine.c),
                    d: blend(|affine| affine.d),
                    e: blend(|affine| affine.e),
                    f: blend(|affine| affine.f),
                }
            }
        }
    }
}

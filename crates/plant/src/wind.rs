//! Where the wind takes a skeleton.
//!
//! Owns the wind: whole harmonics of the loop, later the further out a part is. A part turns in the plane of the picture
//! alone, so that what is in front stays in front. Never draws.
//!
//! Start at [`Posed::of`].

use std::f64::consts::TAU;

use crate::skeleton::{GROUND, Skeleton, Sway};
use crate::vector::{Vector, added, turned};

/// Waves of the wind: the harmonic, how strong it is, and how much of a part's own lag it has.
const WAVES: [(f64, f64, f64); 3] = [(1.0, 0.6, 0.0), (2.0, 0.4, 1.0), (3.0, 0.2, -1.7)];
/// Harmonics of a leaf's flutter.
const FLUTTERS: [f64; 2] = [4.0, 7.0];

/// A clock of the wind: turns at the middle of a frame, and turns a frame while the shutter is open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Clock {
    pub(crate) turns: f64,
    pub(crate) turns_per_frame: f64,
}

impl Clock {
    /// Radians, `shutter` frames from the middle of the frame.
    pub(crate) fn at(self, shutter: f64) -> f64 {
        // Whole turns go first, so that equal fractions stay equal.
        let turns = (self.turns - self.turns.floor()) + self.turns_per_frame * shutter;
        TAU * (turns - turns.floor())
    }
}

/// A skeleton in the wind: of every bone the ends, and how far it is turned.
#[derive(Debug)]
pub(crate) struct Posed {
    pub(crate) bones: Vec<Pose>,
}

/// A bone in the wind.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pose {
    pub(crate) ends: [Vector; 2],
    angle: f64,
}

impl Posed {
    /// The skeleton at a moment of the wind, in radians.
    pub(crate) fn of(skeleton: &Skeleton, moment: f64) -> Posed {
        let mut bones: Vec<Pose> = Vec::with_capacity(skeleton.bones.len());
        for bone in &skeleton.bones {
            let (start, angle) = if bone.on == GROUND {
                (bone.start, 0.0)
            } else {
                let on: &Pose = &bones[bone.on as usize];
                (along(on.ends, bone.at), on.angle)
            };
            let angle = angle + bone.sway.most * gust(&bone.sway, moment);
            let (sine, cosine) = libm::sincos(angle);
            let end = added(start, turned(bone.direction, [sine, cosine]), bone.length);
            bones.push(Pose { ends: [start, end], angle });
        }
        Posed { bones }
    }

    /// A leaf's stalk, direction and normal.
    pub(crate) fn leaf(&self, skeleton: &Skeleton, leaf: usize, moment: f64, flutter: f64) -> [Vector; 3] {
        let leaf = &skeleton.leaves[leaf];
        let on = &self.bones[leaf.on as usize];
        let [slow, fast] = FLUTTERS;
        let wave = 0.7 * libm::sin(slow * moment - leaf.lag) + 0.3 * libm::sin(fast * moment - 1.9 * leaf.lag);
        let (sine, cosine) = libm::sincos(on.angle + flutter * wave);
        [along(on.ends, leaf.at), turned(leaf.direction, [sine, cosine]), turned(leaf.normal, [sine, cosine])]
    }
}

fn along([from, to]: [Vector; 2], part: f64) -> Vector {
    [0, 1, 2].map(|axis| from[axis] + (to[axis] - from[axis]) * part)
}

fn gust(sway: &Sway, moment: f64) -> f64 {
    WAVES.iter().map(|(n, much, own)| much * libm::sin(n * moment - n * sway.lag * 0.8 - own * sway.own)).sum()
}

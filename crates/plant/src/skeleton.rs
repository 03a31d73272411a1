//! What has grown: bones and leaves, at rest.
//!
//! Owns the parts of a skeleton and where they are when no wind blows. How they came to be is told by `growth.rs`, where
//! the wind takes them by `wind.rs`.
//!
//! Start at [`Skeleton`].

use crate::vector::{Vector, added};

/// The most bones and leaves of a picture, together.
pub const MOST_PARTS: usize = 20_000;

/// The bone of which a stem's first one is a continuation.
pub(crate) const GROUND: u32 = u32::MAX;

/// A piece of a branch: straight, and round.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bone {
    /// The bone that it starts on, or [`GROUND`].
    pub(crate) on: u32,
    /// Where on that one, `0.0..=1.0`.
    pub(crate) at: f64,
    pub(crate) direction: Vector,
    /// In heights of the tallest stem, as all lengths here.
    pub(crate) length: f64,
    pub(crate) radii: [f64; 2],
    /// How far from the ground it is in the order of branches, `0.0..=1.0` for the bark's colour.
    pub(crate) youth: f64,
    pub(crate) sway: Sway,
    /// Where it starts.
    pub(crate) start: Vector,
    pub(crate) stem: u8,
}

/// How wind takes a bone.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sway {
    /// The most that it turns in the wind, radians.
    pub(crate) most: f64,
    /// How late it does, radians of the slowest wave.
    pub(crate) lag: f64,
    /// How late the faster waves are besides.
    pub(crate) own: f64,
}

/// A leaf.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Leaf {
    pub(crate) on: u32,
    pub(crate) at: f64,
    pub(crate) direction: Vector,
    /// The direction that its upper side looks to.
    pub(crate) normal: Vector,
    pub(crate) length: f64,
    /// Half of its width, of its length.
    pub(crate) width: f64,
    /// 0 for one near the start of the plant, 1 for one at the tip of a twig.
    pub(crate) age: f64,
    /// `-1.0..1.0`.
    pub(crate) own: f64,
    /// Radians, by which its flutter is late.
    pub(crate) lag: f64,
    pub(crate) start: Vector,
    pub(crate) stem: u8,
}

/// All parts; a bone comes after the one that it starts on.
#[derive(Clone, Debug, Default)]
pub(crate) struct Skeleton {
    pub(crate) bones: Vec<Bone>,
    pub(crate) leaves: Vec<Leaf>,
    /// Of every stem, the box around its parts at rest: left, bottom, right, top.
    pub(crate) boxes: Vec<[f64; 4]>,
    /// Of every stem, the middle of its crown.
    pub(crate) crowns: Vec<Vector>,
}

impl Skeleton {
    /// Where a bone ends.
    pub(crate) fn end(&self, bone: u32) -> Vector {
        let bone = &self.bones[bone as usize];
        added(bone.start, bone.direction, bone.length)
    }

    /// The place `at` on a bone.
    pub(crate) fn place(&self, bone: u32, at: f64) -> Vector {
        let bone = &self.bones[bone as usize];
        added(bone.start, bone.direction, bone.length * at)
    }

    /// Bones and leaves.
    pub(crate) fn parts(&self) -> usize {
        self.bones.len() + self.leaves.len()
    }
}

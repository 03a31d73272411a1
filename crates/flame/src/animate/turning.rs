//! Loops: a genome whose transforms turn once round.
//!
//! Owns the rotation and its speed. Never changes anything else of a genome.
//!
//! Start at [`Loop`].

use std::f64::consts::TAU;

use super::Motion;
use crate::genome::{Genome, Xform};

/// A sheep's loop: in `frames` frames the 2x2 part of every animated transform turns by 360 degrees.
///
/// Frame 0 is the genome itself, and so is frame `frames`: the end meets the start.
#[derive(Clone, Debug)]
pub struct Loop {
    genome: Genome,
    frames: f64,
}

impl Loop {
    /// The loop of `genome` over `frames` frames (> 0).
    pub fn new(genome: &Genome, frames: f64) -> Loop {
        Loop { genome: genome.clone(), frames }
    }

    /// The genome of frame 0.
    pub fn genome(&self) -> &Genome {
        &self.genome
    }

    /// How fast `xform` turns, in radians per frame: 0 where it does not.
    pub(crate) fn speed(&self, xform: &Xform) -> f64 {
        if xform.animate == 0.0 { 0.0 } else { TAU / self.frames }
    }
}

impl Motion for Loop {
    fn at(&self, frame: f64) -> Genome {
        let mut genome = self.genome.clone();
        let frame = frame.rem_euclid(self.frames);
        for xform in &mut genome.xforms {
            xform.affine = xform.affine.turned(self.speed(xform) * frame);
        }
        genome
    }
}

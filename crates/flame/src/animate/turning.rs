//! Loops: a genome whose transforms turn once round.
//!
//! Owns the rotation. Never changes anything else of a genome.
//!
//! Start at [`Loop`].

use std::f64::consts::TAU;

use super::Motion;
use crate::genome::Genome;

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
}

impl Motion for Loop {
    fn at(&self, frame: f64) -> Genome {
        let mut genome = self.genome.clone();
        let turn = (frame / self.frames).rem_euclid(1.0) * TAU;
        for xform in genome.xforms.iter_mut().filter(|xform| xform.animate != 0.0) {
            xform.affine = xform.affine.turned(turn);
        }
        genome
    }
}

//! Loops: a genome whose transforms turn once round, and wave as its `<motion>` elements say, before a camera that may go
//! round.
//!
//! Owns the rotation and its speed; `waves.rs` has the waves, which come first. Never changes anything else of a genome.
//!
//! Start at [`Loop`].

use std::f64::consts::TAU;

use super::Motion;
use super::waves::waved;
use crate::genome::{Genome, Xform};

/// A sheep's loop: in `frames` frames the 2x2 part of every animated transform turns by 360 degrees, and what waves add
/// to it goes through whole waves.
///
/// Frame 0 is the genome itself at rest, and so is frame `frames`: the end meets the start.
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

    /// How far the loop has come at `frame`, as a part of it; below 0 or above 1 outside of its first turn.
    pub(crate) fn part(&self, frame: f64) -> f64 {
        frame / self.frames
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
        for xform in genome.xforms.iter_mut().chain(&mut genome.finals) {
            *xform = waved(xform, self.part(frame));
        }
        genome.camera.pose.yaw += genome.camera.pose.turned(self.part(frame));
        for xform in &mut genome.xforms {
            xform.affine = xform.affine.turned(self.speed(xform) * frame);
        }
        genome
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::genome::Affine;

    #[test]
    fn a_loop_turns_the_way_flam3_genome_rotates() {
        let affine = Affine { a: -0.718_297, d: -0.415_62, b: 0.2326, e: -0.534_669, c: 0.750_421, f: -0.287_476 };
        let genome = Genome { xforms: vec![Xform { affine, ..Xform::default() }], ..Genome::default() };
        let turned = Loop::new(&genome, 8.0).at(1.0).xforms[0].affine;
        // Printed by `rotate=FILE frame=1 nframes=8 flam3-genome`.
        let expected = [-0.214_025, -0.8018, 0.542_541, -0.213_595, 0.750_421, -0.287_476];
        for (ours, theirs) in [turned.a, turned.d, turned.b, turned.e, turned.c, turned.f].iter().zip(expected) {
            assert!((ours - theirs).abs() < 1e-5, "{turned:?}");
        }
    }
}

//! Motion: loops and transitions.
//!
//! Owns how a genome changes over the frames of a clip. Never renders.
//!
//! Start at [`Motion`]. A [`Loop`] turns (`turning.rs`) and waves (`waves.rs`); a [`Transition`] leads from one loop to another (`transition.rs`),
//! over affine parts (`affine.rs`) and palettes (`palette.rs`, `oklab.rs`) once transforms have partners (`pairing.rs`) and
//! both genomes the same parts (`align.rs`). [`KeyFrames`] are a file of flames with times (`keys.rs`).

mod affine;
mod align;
mod keys;
pub(crate) mod oklab;
mod pairing;
mod palette;
mod transition;
mod turning;
mod waves;

pub use keys::KeyFrames;
pub use transition::Transition;
pub use turning::Loop;

use crate::genome::Genome;

/// A genome over time.
pub trait Motion: Sync {
    /// The genome at `frame`, in frames from the clip's start; fractions and frames outside the clip are fine.
    fn at(&self, frame: f64) -> Genome;
}

/// A genome that does not move.
impl Motion for Genome {
    fn at(&self, _frame: f64) -> Genome {
        self.clone()
    }
}

impl<M: Motion + ?Sized> Motion for &M {
    fn at(&self, frame: f64) -> Genome {
        (**self).at(frame)
    }
}

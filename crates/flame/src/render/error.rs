//! Why a genome is not rendered.
//!
//! Owns the errors of the renderer; those of reading are `GenomeError`.
//!
//! Start at [`RenderError`].

use crate::genome::Reasons;

/// Why a genome is not rendered. Nothing was drawn.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RenderError {
    /// The GPU, or its driver, failed. It may be gone.
    #[error("the GPU `{name}` failed: {reason}")]
    Gpu {
        /// Its name.
        name: String,
        /// What it or its driver says.
        reason: String,
    },
    /// A frame does not fit into the memory of the GPU.
    #[error("a frame takes a buffer of {needed} MB, and the GPU `{name}` has room for {most} MB")]
    GpuMemory {
        /// Its name.
        name: String,
        /// Megabytes of the largest buffer.
        needed: u64,
        /// Megabytes that a buffer may have.
        most: u64,
    },
    /// There is no GPU that can be used.
    #[error("no GPU can be used: {found}")]
    NoGpu {
        /// What was found.
        found: String,
    },
    /// This program cannot draw on a GPU.
    #[error("this program is built without the feature `gpu`")]
    NotBuilt,
    /// A GPU cannot draw it.
    #[error("a GPU does not draw {what}; `--on cpu` does")]
    NotOnGpu {
        /// What it asks for.
        what: &'static str,
    },
    /// It has no colours, only the number of a palette in flam3's library, which is not ours to ship.
    #[error("the genome has no palette, only the number of one in flam3's library")]
    NoPalette,
    /// The chaos game could not choose anything.
    #[error("the genome has no transform with a weight above 0, among {xforms}")]
    NothingToChoose {
        /// How many transforms there are.
        xforms: usize,
    },
    /// A number is outside the range in which it makes sense.
    #[error("`{name}` is {value}, expected {expected}")]
    Range {
        /// The attribute's or setting's name.
        name: &'static str,
        /// The value found.
        value: f64,
        /// The expected value.
        expected: &'static str,
    },
    /// Rendering was stopped by the caller.
    #[error("rendering was stopped")]
    Stopped,
    /// The system gives no threads.
    #[error("cannot start {threads} threads: {reason}")]
    Threads {
        /// How many were asked for; 0 means one per core.
        threads: usize,
        /// The system error.
        reason: String,
    },
    /// The genome asks for what is not drawn: most often an unknown variation.
    #[error("this renderer does not draw {reasons}")]
    Unsupported {
        /// All of it.
        reasons: Reasons,
    },
}

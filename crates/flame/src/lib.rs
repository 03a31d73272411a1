//! Flames: genomes, their motion, and the renderer that turns a moment of them into light.
//!
//! Owns everything that knows what a transform is: reading and writing flam3 XML ([`genome`]), loops and transitions
//! ([`animate`]), the picture ([`render`]), how bright a transition is half way ([`Exposure`]), and new genomes by chance and
//! from parents ([`breed`]). Never opens a file, reads a clock or knows what a flock or a clip is; [`variations`] has the
//! formulas.
//!
//! Start at [`Flames`], the species; at [`Renderer::render`] with settings of its own.
#![forbid(unsafe_code)]
#![allow(clippy::inline_always, reason = "a call that is not inlined would use other instructions than its caller")]
#![allow(clippy::float_cmp, reason = "0 and 1 mean `off` and `whole` exactly, as files say them")]

pub mod animate;
pub mod breed;
mod exposure;
pub mod genome;
mod light;
pub mod render;
mod species;

pub use self::species::{Flame, Flames};
pub use ::species::{Image, Rng};
pub use ::variations;
pub use animate::{KeyFrames, Loop, Motion, Transition};
pub use exposure::{Exposed, Exposure};
pub use genome::{Genome, GenomeError};
pub use render::{
    Arithmetic, Backend, Filter, FrameCost, GPU_VERSION, Measured, RenderError, Renderer, Settings, VERSION,
};

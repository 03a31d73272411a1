//! What every kind of sheep shares: pictures, random numbers that mean the same on every machine, threads, and the
//! contract of a species.
//!
//! Owns the layout of displayable light ([`Image`]), the one generator ([`Rng`]), what a species promises ([`Species`],
//! [`Genome`], [`Motion`]), and the dissolve between pictures of any two of them ([`Dissolve`]). Never knows a genome: a
//! species is a package of its own, and species do not know each other.
//!
//! | file | what is there |
//! |---|---|
//! | `contract.rs` | the traits, and what passes through them |
//! | `breed.rs` | the trait of species that can be bred, and their operators |
//! | `lineage.rs`, `licence.rs` | parents, authors and licence of a genome |
//! | `dissolve.rs`, `guide.rs` | the transition between pictures of two species |
//! | `middle.rs`, `light.rs` | whether a transition is worth its rendering, told by small pictures |
//! | `figures.rs` | whether a loop is worth showing, told by small pictures |
//! | `shutter.rs` | the moments of a frame |
//! | `capsule.rs` | the stroke that species draw lines of |
//! | `image.rs`, `luma.rs`, `rng.rs` | pictures, how bright they are, random numbers |
//! | `threads.rs`, `place.rs` | threads, places in a text |
//!
//! Start at [`Species`].
#![forbid(unsafe_code)]

mod breed;
mod capsule;
mod contract;
mod dissolve;
mod figures;
mod guide;
mod image;
mod licence;
mod light;
mod lineage;
mod luma;
#[cfg(test)]
mod made;
mod middle;
mod place;
mod rng;
mod shutter;
mod threads;

pub use breed::{Breed, Child, Operator, UNCHANGED, descended};
pub use capsule::Capsule;
pub use contract::{Demand, Drawn, Genome, Motion, Recipe, Refusal, RenderError, Settings, Species};
pub use dissolve::Dissolve;
pub use figures::{FigureFault, Figures};
pub use image::Image;
pub use licence::strictest;
pub use light::Light;
pub use lineage::Lineage;
pub use middle::{Middle, MiddleFault, expected};
pub use place::Place;
pub use rng::Rng;
pub use shutter::shutter;
pub use threads::{Threads, ThreadsError};

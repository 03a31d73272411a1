//! Clips of a flock, rendered from its genomes.
//!
//! Owns the way from a manifest to its clips: `selection.rs` finds the missing ones, `plan.rs` plans each, `make.rs` renders
//! them, `hashes.rs` writes their hashes into the manifest. `presets.rs` has named qualities, `shard.rs` the part of a run,
//! `estimate.rs` and `cost.rs` what it costs, `machine.rs` the memory and threads that it may take.
//!
//! Start at [`selection::Selection`], then [`make::make`].

pub mod clip_job;
pub mod cost;
pub mod estimate;
pub mod frames;
pub mod hashes;
pub mod machine;
pub mod make;
pub mod plan;
pub mod presets;
pub mod selection;
pub mod shard;
#[cfg(test)]
mod tests;

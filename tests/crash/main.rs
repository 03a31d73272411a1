//! The crash laboratory: cuts the power of a unit's disk, thousands of times, at the level of its blocks.
//!
//! The real `dreams-update` and `dreams-owner` run on ext4, on a disk of which every write and every flush is recorded. Then the disk is
//! made as it may be after a power cut at any of them: what was flushed is there, of the rest any part, torn writes
//! included. Each such disk is mounted and looked at, and then the update has to complete by itself. Owns the lives
//! that are recorded and what must hold after each cut. Needs root and devices of its own: `run` starts it in a guest.
//!
//! Start at [`lives`], then [`claims::cuts::Cuts`] and [`judge`].
#![forbid(unsafe_code)]
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout, reason = "a laboratory that breaks has failed")]

#[path = "../../crates/bundle/tests/it/careless.rs"]
mod careless;
mod judge;
mod lives;
mod reports;
mod rig;
mod upkeep;

use std::process::ExitCode;

fn main() -> ExitCode {
    let mut lab = lives::Lab::from(std::env::args().skip(1)); // which programs, how many cuts
    let holds = lab.whole_lives(); // what is promised
    let proves = lab.careless_lives(); // that a broken promise would be noticed
    ExitCode::from(u8::from(!(holds && proves)))
}

//! The crash laboratory: cuts the power of a unit's disk, thousands of times, at the level of its blocks.
//!
//! The real `dreams-update` and `dreams-owner` run on ext4, on a disk of which every write and every flush is recorded.
//! From the recording it makes disks as a power cut may leave them: everything before the last flush, and any part of
//! the rest, torn writes included. It mounts each disk, checks it, and completes the update. Owns the scenarios and the
//! checks. Needs root and devices of its own: `run` starts it in a guest.
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
